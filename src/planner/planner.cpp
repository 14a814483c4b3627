#include "planner/planner.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

namespace ctn::planner {

Status check_request(const graph::App& app, int cores, double slack) {
  std::vector<Problem> problems;
  if (cores < 1) {
    problems.push_back({{}, "cores", fmt::format("there are {} cores to plan for", cores), "give at least 1"});
  } else if (cores > kMaxCores) {
    problems.push_back({{},
                        "cores",
                        fmt::format("{} cores are more than this version plans for", cores),
                        fmt::format("give at most {}", kMaxCores)});
  } else if (cores > app.core_count().value_or(cores)) {
    problems.push_back(
        {{},
         "cores",
         fmt::format("there are {} cores to plan for, and the app lists {}", cores, *app.core_count()),
         fmt::format("give at most {}, or list the others under cores in the app file", *app.core_count())});
  }
  if (!(slack >= 0.0 && slack < 1.0)) {
    problems.push_back({{},
                        "slack",
                        fmt::format("a slack of {} % leaves nothing to plan with, or is no share", 100 * slack),
                        "give 0 % or more and less than 100 %"});
  }
  const std::size_t subchains = app.graph.subchains().size();
  if (subchains == 0) {
    problems.push_back({{},
                        "subchains",
                        "the app has no subchain: there is nothing to schedule",
                        "leave at least one node neither external nor unscheduled"});
  } else if (subchains > kMaxSubchains) {
    problems.push_back(
        {{},
         "subchains",
         fmt::format("the app has {} subchains, more than this version plans for", subchains),
         fmt::format("put nodes that run one after the other into one subchain, at most {} in all", kMaxSubchains)});
  }
  if (!problems.empty()) return Error(ErrorKind::kCaller, std::move(problems));
  return Done{};
}

std::size_t fastest_kind(const graph::App& app) {
  const auto fastest = std::max_element(app.core_kinds.begin(), app.core_kinds.end(),
                                        [](const auto& a, const auto& b) { return a.speed < b.speed; });
  return static_cast<std::size_t>(fastest - app.core_kinds.begin());
}

graph::App with_more_cores(const graph::App& app, int cores, std::size_t kind, int more) {
  graph::App other = app;
  if (app.core_kinds.empty()) return other;
  const std::vector<int> counts = app.cores_by_kind(cores);
  for (std::size_t k = 0; k < counts.size(); ++k) other.core_kinds[k].count = counts[k];
  other.core_kinds[kind].count += more;
  return other;
}

}  // namespace ctn::planner
