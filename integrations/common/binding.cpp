#include "common/binding.h"

#include <algorithm>
#include <cstdint>

#include "common/fields.h"

namespace catan_ros {
namespace {

// Periods that differ by such a part are written for the same timer: 33.333ms for 1 / 30 s.
constexpr int kSamePeriod = 1000;

bool read_flags(std::string_view text, Binding& binding) {
  if (text == kEmptyField) return true;
  for (const std::string_view flag : split(text, ',')) {
    bool* const field = flag == "queue"    ? &binding.takes_all
                        : flag == "itself" ? &binding.runs_by_itself
                        : flag == "world"  ? &binding.always_gives_output
                        : flag == "within" ? &binding.feeds_own_program
                        : flag == "behind" ? &binding.is_behind
                                           : nullptr;
    if (field == nullptr) return false;
    *field = true;
  }
  return true;
}

std::optional<Binding> parse_binding(std::string_view line) {
  const std::vector<std::string_view> fields = split(line, '\t');
  if (fields.size() != 9) return std::nullopt;
  Binding binding;
  binding.node = fields[0];
  binding.ros_node = fields[1];
  if (fields[2] != kEmptyField) binding.nodelet = fields[2];
  const std::optional<Binding::Kind> kind = parse_kind(fields[3]);
  if (!kind) return std::nullopt;
  binding.kind = *kind;
  if (binding.kind == Binding::Kind::kTimer) {
    const std::optional<std::int64_t> period = parse_number(fields[4]);
    if (!period || *period == 0) return std::nullopt;
    binding.period = std::chrono::nanoseconds{*period};
  } else if (binding.kind != Binding::Kind::kLoop) {
    binding.name = fields[4];
  }
  if (!read_flags(fields[5], binding)) return std::nullopt;
  binding.predecessors = read_list(fields[6]);
  binding.output_topics = read_list(fields[7]);
  binding.successors = read_list(fields[8]);
  return binding;
}

// The first that `is_one` and that names the nodelet; else the first that `is_one` and names none.
template <class IsOne>
const Binding* find_of_nodelet(const std::vector<Binding>& bindings, std::string_view nodelet, const IsOne& is_one) {
  const Binding* of_any = nullptr;
  for (const Binding& binding : bindings) {
    if (!is_one(binding)) continue;
    if (binding.nodelet == nodelet) return &binding;
    if (binding.nodelet.empty() && of_any == nullptr) of_any = &binding;
  }
  return of_any;
}

}  // namespace

bool Binding::gives_output_on(std::string_view topic) const {
  return output_topics.empty() || std::find(output_topics.begin(), output_topics.end(), topic) != output_topics.end();
}

std::string to_text(const std::vector<Binding>& bindings) {
  std::string text;
  for (const Binding& binding : bindings) {
    std::vector<std::string> set;
    if (binding.takes_all) set.emplace_back("queue");
    if (binding.runs_by_itself) set.emplace_back("itself");
    if (binding.always_gives_output) set.emplace_back("world");
    if (binding.feeds_own_program) set.emplace_back("within");
    if (binding.is_behind) set.emplace_back("behind");
    const std::string flags = list_text(set);
    const std::string predecessors = list_text(binding.predecessors);
    const std::string topics = list_text(binding.output_topics);
    const std::string successors = list_text(binding.successors);
    const std::string name =
        binding.kind == Binding::Kind::kTimer ? std::to_string(binding.period.count()) : binding.name;
    text += binding.node;
    for (const std::string_view field :
         {std::string_view(binding.ros_node), or_nothing(binding.nodelet), kind_text(binding.kind), or_nothing(name),
          or_nothing(flags), or_nothing(predecessors), or_nothing(topics), or_nothing(successors)}) {
      text += '\t';
      text += field;
    }
    text += '\n';
  }
  return text;
}

std::optional<std::vector<Binding>> parse_bindings(std::string_view text) {
  std::vector<Binding> bindings;
  for (const std::string_view line : split(text, '\n')) {
    if (line.empty()) continue;
    std::optional<Binding> binding = parse_binding(line);
    if (!binding) return std::nullopt;
    bindings.push_back(std::move(*binding));
  }
  return bindings;
}

std::vector<Binding> bindings_of(const std::vector<Binding>& bindings, std::string_view ros_node) {
  std::vector<Binding> own;
  std::copy_if(bindings.begin(), bindings.end(), std::back_inserter(own),
               [&](const Binding& binding) { return binding.ros_node == ros_node; });
  return own;
}

const Binding* find_named(const std::vector<Binding>& bindings, Binding::Kind kind, std::string_view name,
                          std::string_view nodelet) {
  return find_of_nodelet(bindings, nodelet,
                         [&](const Binding& binding) { return binding.kind == kind && binding.name == name; });
}

bool is_same_period(std::chrono::nanoseconds named, std::chrono::nanoseconds asked_for) {
  return std::chrono::abs(named - asked_for) <= asked_for / kSamePeriod;
}

const Binding* find_timer(const std::vector<Binding>& bindings, std::chrono::nanoseconds period,
                          std::string_view nodelet) {
  return find_by_period(period, [&](const auto& fits) {
    return find_of_nodelet(bindings, nodelet, [&](const Binding& binding) {
      return binding.kind == Binding::Kind::kTimer && fits(binding.period);
    });
  });
}

}  // namespace catan_ros
