#include "graph/build.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <tuple>

#include "base/text.h"
#include "graph/app_builder.h"

namespace ctn::graph {

Result<App> AppBuilder::build() {
  app_.name = spec_.name.value;
  app_.scheduler = spec_.scheduler;
  if (!app_.name.empty()) check_name(spec_.name, "app", "app");
  add_core_kinds();
  add_nodes();
  add_edges();
  check_cycles();
  if (problems_.empty()) sort_topologically();
  complete_periods();
  add_subchains();
  add_exclusive_groups();
  add_objective();
  add_order();
  if (problems_.empty()) return std::move(app_);
  std::stable_sort(problems_.begin(), problems_.end(), [](const Problem& a, const Problem& b) {
    return std::tie(a.place.line, a.place.column) < std::tie(b.place.line, b.place.column);
  });
  return Error(ErrorKind::kCaller, std::move(problems_));
}

void AppBuilder::add_core_kinds() {
  constexpr double kSlowest = 1e-3;
  constexpr double kFastest = 1e3;
  constexpr int kMaxCores = 1024;
  std::set<std::string_view> seen;
  int cores = 0;
  for (std::size_t i = 0; i < spec_.core_kinds.size(); ++i) {
    const CoreKindSpec& spec = spec_.core_kinds[i];
    const std::string key = is_name(spec.name) ? "cores." + spec.name.value : fmt::format("cores[{}]", i);
    if (check_name(spec.name, key, "kind of cores") && !seen.insert(spec.name.value).second) {
      problem(spec.name.place, key, fmt::format("there are two kinds of cores {}", quote(spec.name.value)),
              "rename or remove one");
    }
    const int count = spec.count.value;
    // One that is not written is 1, and has no place.
    const bool written = spec.count.place.line > 0;
    if (count < 1 || (written && count > kMaxCores - cores)) {
      problem(spec.count.place, key + ".count", fmt::format("{} cores are out of range", count),
              fmt::format("write a whole number from 1, at most {} for all kinds together", kMaxCores));
    } else if (count > kMaxCores - cores) {
      problem(spec.name.place, key, fmt::format("with this kind there are {} cores", cores + count),
              fmt::format("have at most {} of all kinds together", kMaxCores));
    } else {
      cores += count;
    }
    if (!(spec.speed.value >= kSlowest && spec.speed.value <= kFastest)) {
      problem(spec.speed.place, key + ".speed", fmt::format("a speed of {} is out of range", spec.speed.value),
              "write how fast these cores are beside one of speed 1, from 0.001 to 1000, as in 0.45");
    }
    app_.core_kinds.push_back({spec.name.value, count, spec.speed.value});
  }
}

void AppBuilder::problem(const Place& place, std::string_view key, std::string_view what, std::string_view hint) {
  // Names may hold anything before they are found to be none.
  problems_.push_back({place, printable(key), printable(what), printable(hint)});
}

// Guessing costs time for each candidate; a text with this many mistakes is not one that was misspelt.
std::string AppBuilder::guess(std::string_view word, const std::vector<std::string>& candidates,
                              std::string otherwise) const {
  constexpr std::size_t kMaxGuesses = 200;
  if (problems_.size() > kMaxGuesses) return otherwise;
  const auto meant = nearest(word, candidates);
  return meant ? fmt::format("did you mean {}?", quote(*meant)) : otherwise;
}

std::optional<NodeId> AppBuilder::resolve_node(const Name& name, const std::string& key) {
  if (const auto found = node_index_.find(name.value); found != node_index_.end()) return found->second;
  problem(name.place, key, fmt::format("there is no node {}", quote(name.value)),
          guess(name.value, node_names_, "add it to nodes"));
  return std::nullopt;
}

Result<App> build_app(const AppSpec& spec) { return AppBuilder(spec).build(); }

}  // namespace ctn::graph
