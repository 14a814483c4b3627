#include "planner/planner.h"

#include <fmt/format.h>

#include <utility>
#include <vector>

#include "planner/owned.h"

namespace ctn::planner {
namespace {

std::vector<Problem> problems_of(const graph::App& app, const Request& request) {
  std::vector<Problem> problems;
  if (request.cores < 1) {
    problems.push_back({{}, "cores", fmt::format("there are {} cores to plan for", request.cores), "give at least 1"});
  } else if (request.cores > kMostCores) {
    problems.push_back({{},
                        "cores",
                        fmt::format("{} cores are more than this version plans for", request.cores),
                        fmt::format("give at most {}", kMostCores)});
  }
  if (!(request.slack >= 0.0 && request.slack < 1.0)) {
    problems.push_back({{},
                        "slack",
                        fmt::format("a slack of {} % leaves nothing to plan with, or is no share", 100 * request.slack),
                        "give 0 % or more and less than 100 %"});
  }
  const std::size_t subchains = app.graph.subchains().size();
  if (subchains == 0) {
    problems.push_back({{},
                        "subchains",
                        "the app has no subchain: there is nothing to schedule",
                        "leave at least one node neither external nor unscheduled"});
  } else if (subchains > 1) {
    problems.push_back({{},
                        "subchains",
                        fmt::format("the app has {} subchains, and this version can neither share a core among "
                                    "subchains nor divide cores between them",
                                    subchains),
                        "put the nodes that Catan schedules into one subchain, or make those that run by themselves "
                        "at negligible cost unscheduled"});
  }
  return problems;
}

}  // namespace

Result<plan::Plan> make_plan(const graph::App& app, const model::CostTable& costs, const Request& request) {
  std::vector<Problem> problems = problems_of(app, request);
  if (!problems.empty()) return Error(ErrorKind::kCaller, std::move(problems));
  Result<plan::Plan> plan = plan_owned(app, costs, request.cores, request.slack);
  if (plan) plan->planner = request.method == Method::kJoint ? "joint" : "two-stage";
  return plan;
}

}  // namespace ctn::planner
