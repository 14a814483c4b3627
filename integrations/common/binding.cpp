#include "common/binding.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>

namespace catan_ros {
namespace {

constexpr std::array<std::string_view, 3> kKinds{"topic", "timer", "service"};
constexpr std::string_view kNothing = "-";

std::vector<std::string_view> split(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  for (;;) {
    const std::size_t end = text.find(separator);
    parts.push_back(text.substr(0, end));
    if (end == std::string_view::npos) return parts;
    text.remove_prefix(end + 1);
  }
}

void append(std::string& list, std::string_view item) {
  if (!list.empty()) list += ',';
  list += item;
}

std::string_view or_nothing(const std::string& text) { return text.empty() ? kNothing : std::string_view(text); }

std::optional<std::chrono::nanoseconds> parse_period(std::string_view text) {
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || value <= 0) return std::nullopt;
  return std::chrono::nanoseconds{value};
}

std::vector<std::string> read_list(std::string_view text) {
  std::vector<std::string> list;
  if (text == kNothing) return list;
  for (const std::string_view item : split(text, ',')) list.emplace_back(item);
  return list;
}

std::string list_text(const std::vector<std::string>& list) {
  std::string text;
  for (const std::string& item : list) append(text, item);
  return text;
}

bool read_flags(std::string_view text, Binding& binding) {
  if (text == kNothing) return true;
  for (const std::string_view flag : split(text, ',')) {
    bool* const field = flag == "queue"    ? &binding.takes_all
                        : flag == "itself" ? &binding.runs_by_itself
                        : flag == "world"  ? &binding.always_gives_output
                                           : nullptr;
    if (field == nullptr) return false;
    *field = true;
  }
  return true;
}

std::optional<Binding> parse_binding(std::string_view line) {
  const std::vector<std::string_view> fields = split(line, '\t');
  if (fields.size() != 7) return std::nullopt;
  Binding binding;
  binding.node = fields[0];
  binding.ros_node = fields[1];
  const auto kind = std::find(kKinds.begin(), kKinds.end(), fields[2]);
  if (kind == kKinds.end()) return std::nullopt;
  binding.kind = static_cast<Binding::Kind>(kind - kKinds.begin());
  if (binding.kind == Binding::Kind::kTimer) {
    const auto period = parse_period(fields[3]);
    if (!period) return std::nullopt;
    binding.period = *period;
  } else {
    binding.name = fields[3];
  }
  if (!read_flags(fields[4], binding)) return std::nullopt;
  binding.predecessors = read_list(fields[5]);
  binding.output_topics = read_list(fields[6]);
  return binding;
}

}  // namespace

bool Binding::gives_output_on(std::string_view topic) const {
  return output_topics.empty() || std::find(output_topics.begin(), output_topics.end(), topic) != output_topics.end();
}

std::string to_text(const std::vector<Binding>& bindings) {
  std::string text;
  for (const Binding& binding : bindings) {
    std::string flags;
    if (binding.takes_all) append(flags, "queue");
    if (binding.runs_by_itself) append(flags, "itself");
    if (binding.always_gives_output) append(flags, "world");
    const std::string predecessors = list_text(binding.predecessors);
    const std::string topics = list_text(binding.output_topics);
    const std::string name =
        binding.kind == Binding::Kind::kTimer ? std::to_string(binding.period.count()) : binding.name;
    text += binding.node;
    for (const std::string_view field :
         {std::string_view(binding.ros_node), kKinds[static_cast<std::size_t>(binding.kind)], std::string_view(name),
          or_nothing(flags), or_nothing(predecessors), or_nothing(topics)}) {
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

const Binding* find_named(const std::vector<Binding>& bindings, Binding::Kind kind, std::string_view name) {
  const auto found = std::find_if(bindings.begin(), bindings.end(),
                                  [&](const Binding& binding) { return binding.kind == kind && binding.name == name; });
  return found == bindings.end() ? nullptr : &*found;
}

const Binding* find_timer(const std::vector<Binding>& bindings, std::chrono::nanoseconds period) {
  const auto found = std::find_if(bindings.begin(), bindings.end(), [&](const Binding& binding) {
    return binding.kind == Binding::Kind::kTimer && binding.period == period;
  });
  return found == bindings.end() ? nullptr : &*found;
}

}  // namespace catan_ros
