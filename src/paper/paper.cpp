// Stage I, stage II, and from their numbers to a plan.
#include "paper/paper.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include "model/formulas.h"
#include "paper/problem.h"
#include "paper/stage_one.h"
#include "paper/stage_two.h"
#include "plan/batches.h"
#include "plan/limits.h"
#include "plan/predict.h"

namespace ctn::paper {
namespace {

std::optional<Error> mistake(const graph::App& app, const Request& request) {
  const std::size_t subchains = app.graph.subchains().size();
  const int listed = app.core_count().value_or(kMaxCores);
  std::vector<ctn::Problem> problems;
  if (request.cores < 1 || request.cores > std::min(listed, kMaxCores)) {
    problems.push_back({{},
                        "cores",
                        fmt::format("there are {} cores to plan for", request.cores),
                        fmt::format("give from 1 to {}{}", std::min(listed, kMaxCores),
                                    app.core_count() ? ", which the app lists" : "")});
  }
  if (!(request.slack >= 0.0 && request.slack < 1.0)) {
    problems.push_back({{},
                        "slack",
                        fmt::format("a slack of {} % leaves nothing to plan with, or is no share", 100 * request.slack),
                        "give 0 % or more and less than 100 %"});
  }
  if (subchains == 0 || subchains > kMaxSubchains) {
    problems.push_back({{},
                        "subchains",
                        fmt::format("the app has {} subchains", subchains),
                        fmt::format("this planner takes from 1 to {}", kMaxSubchains)});
  }
  if (problems.empty()) return std::nullopt;
  return Error(ErrorKind::kCaller, std::move(problems));
}

// The cores that each subchain has in a plan; none where it is not one of this app and these cores.
std::optional<Allocation> allocation_of(const plan::Plan& plan, const graph::App& app, const Problem& problem,
                                        int cores) {
  if (plan.subchains.size() != problem.subchains.size()) return std::nullopt;
  std::vector<int> members(static_cast<std::size_t>(cores), 0);
  for (const plan::SubchainPlan& subchain : plan.subchains) {
    if (subchain.cores.empty()) return std::nullopt;
    for (const int core : subchain.cores) {
      if (core < 0 || core >= cores) return std::nullopt;
      ++members[static_cast<std::size_t>(core)];
    }
  }
  std::vector<int> number(members.size(), -1);
  int shared = 0;
  Allocation allocation;
  for (const plan::SubchainPlan& subchain : plan.subchains) {
    const auto core = static_cast<std::size_t>(subchain.cores.front());
    Place place{static_cast<int>(app.kind_of(subchain.cores.front())), 0, 0};
    if (members[core] == 1) {
      place.owned = static_cast<int>(subchain.cores.size());
    } else {
      if (number[core] < 0) number[core] = shared++;
      place.shared = number[core];
    }
    allocation.push_back(place);
  }
  return allocation;
}

class Assembly {
 public:
  Assembly(const graph::App& app, const Problem& problem, const Allocation& allocation, const StageTwo& stage,
           const Request& request)
      : app_(app), problem_(problem), allocation_(allocation), stage_(stage) {
    plan_.planner = "paper";
    plan_.slack = request.slack;
    plan_.subchains.resize(allocation.size());
    plan_.cores.resize(static_cast<std::size_t>(request.cores));
    for (plan::CorePlan& core : plan_.cores) core.frames = app.scheduler.frames;
  }

  plan::Plan run(const model::CostTable& costs) {
    number_cores();
    for (std::size_t i = 0; i < allocation_.size(); ++i) {
      if (allocation_[i].owned > 0) own(i);
    }
    for (std::size_t shared = 0; shared < number_.size(); ++shared) share(shared);
    plan::fill_predictions(plan_, app_, costs);
    return std::move(plan_);
  }

 private:
  // In the order of the subchains that have them.
  void number_cores() {
    std::vector<int> next;
    int first = 0;
    for (const int count : problem_.cores) {
      next.push_back(first);
      first += count;
    }
    number_.assign(stage_.frames.size(), -1);
    for (std::size_t i = 0; i < allocation_.size(); ++i) {
      const Place& place = allocation_[i];
      int& free = next[static_cast<std::size_t>(place.kind)];
      std::vector<int>& cores = plan_.subchains[i].cores;
      if (place.owned > 0) {
        cores.resize(static_cast<std::size_t>(place.owned));
        std::iota(cores.begin(), cores.end(), free);
        free += place.owned;
        continue;
      }
      int& number = number_[static_cast<std::size_t>(place.shared)];
      if (number < 0) number = free++;
      cores = {number};
    }
  }

  void own(std::size_t i) {
    const OnKind& on = problem_.on(i, allocation_[i].kind);
    const Owned& owned = on.owned[std::min(on.owned.size(), static_cast<std::size_t>(allocation_[i].owned)) - 1];
    plan::SubchainPlan& subchain = plan_.subchains[i];
    subchain.period = Millis{owned.promised};
    subchain.wait = Millis{problem_.subchains[i].wait};
    subchain.execution = Millis{owned.timing.execution} + subchain.wait;
    subchain.slice = Millis{on.cost};
    subchain.threads = owned.threads;
    if (!problem_.subchains[i].queue) subchain.every = 1;
  }

  // The members' fractions of a run, and slots one after the other.
  void share(std::size_t shared) {
    plan::CorePlan& core = plan_.cores[static_cast<std::size_t>(number_[shared])];
    const double frame = stage_.frames[shared];
    for (const SubchainId id : app_.order) {
      const std::size_t i = id.index();
      if (allocation_[i].owned > 0 || static_cast<std::size_t>(allocation_[i].shared) != shared) continue;
      plan::SubchainPlan& subchain = plan_.subchains[i];
      if (problem_.subchains[i].exact_period > 0.0) core.frames = graph::FrameMode::kFixed;
      const double period = stage_.timings[i].period;
      if (!problem_.subchains[i].queue) {
        subchain.every = frame > 0.0 ? std::max(1, static_cast<int>(std::lround(period / frame))) : 1;
        subchain.share = 1.0 / *subchain.every;
      } else {
        subchain.share = period > 0.0 ? frame / period : 1.0;
      }
      subchain.slice = subchain.share * Millis{problem_.on(i, allocation_[i].kind).cost};
      Millis offset{0};
      if (!core.slots.empty()) offset = core.slots.back().offset + core.slots.back().slice;
      core.slots.push_back({id, offset, subchain.slice, subchain.every, 0});
    }
    const Millis busy = core.slots.back().offset + core.slots.back().slice;
    core.idle = std::max(Millis{0}, Millis{frame} * problem_.usable - busy);
    core.frame = (busy + core.idle) / problem_.usable;
    for (const plan::Slot& slot : core.slots) {
      plan::SubchainPlan& subchain = plan_.subchains[slot.subchain.index()];
      const Subchain& known = problem_.subchains[slot.subchain.index()];
      subchain.wait = Millis{known.wait};
      const model::SharedTiming timing =
          model::shared_core({core.frame, subchain.share, subchain.slice, subchain.wait}, known.exact_period > 0.0);
      subchain.period = timing.period;
      subchain.execution = timing.execution;
    }
    core.frame_min = std::min(core.frame, plan::min_frame(app_.graph, plan_, core));
  }

  const graph::App& app_;
  const Problem& problem_;
  const Allocation& allocation_;
  const StageTwo& stage_;
  plan::Plan plan_;
  std::vector<int> number_;  // by shared core: as the plan numbers it
};

Error unattainable(const graph::App& app, const Problem& problem, int cores) {
  std::string exact;
  for (std::size_t i = 0; i < problem.subchains.size(); ++i) {
    if (problem.subchains[i].exact_period <= 0.0) continue;
    exact += (exact.empty() ? "" : ", ") + app.graph.subchain(SubchainId(i)).name;
  }
  if (exact.empty()) {
    return Error::caller("weights x times add up to more than can be computed with",
                         "scale all weights down: only their ratios matter");
  }
  return Error::caller(
      fmt::format(
          "the exact rates of {} cannot be met on the cores that stage I of the paper's planner gives them, of {}",
          exact, cores),
      "give it more cores, lower a rate, make its nodes cheaper, or use another planner");
}

}  // namespace

graph::App as_in_the_paper(const graph::App& app) {
  graph::App fixed = app;
  fixed.scheduler.frames = graph::FrameMode::kFixed;
  return fixed;
}

namespace {

// At costs that do not depend on batches.
Result<plan::Plan> make_plan_at(const model::CostTable& costs, const graph::App& app, const Request& request) {
  const Problem problem = make_problem(app, costs, request.cores, request.slack);
  std::optional<Allocation> allocation;
  double gap = 0.0;
  if (request.allocated) allocation = allocation_of(*request.allocated, app, problem, request.cores);
  if (!allocation) {
    StageOne stage = allocate_cores(problem, request.steps);
    allocation = std::move(stage.allocation);
    gap = stage.gap;
  }
  const std::optional<StageTwo> stage = divide_cores(problem, *allocation, request.steps);
  if (!stage) return unattainable(app, problem, request.cores);
  plan::Plan plan = Assembly(app, problem, *allocation, *stage, request).run(costs);
  if (!std::isfinite(plan.objective)) return unattainable(app, problem, request.cores);
  plan.gap = std::max(gap, stage->gap);
  const bool waits =
      std::any_of(plan.subchains.begin(), plan.subchains.end(), [](const auto& each) { return each.wait > Millis{0}; });
  if (waits && plan.objective > 0.0) {
    // What a plan promises of runs that wait in frames is more than the model that was solved says.
    plan.gap = std::max(plan.gap, 1.0 - objective_of(problem.terms, stage->timings) / plan.objective);
  }
  plan.quality = plan.gap > 0.0 ? plan::Quality::kFeasible : plan::Quality::kOptimal;
  return plan;
}

}  // namespace

Result<plan::Plan> make_plan(const graph::App& app, const model::CostTable& costs, const Request& request) {
  if (std::optional<Error> error = mistake(app, request)) return *std::move(error);
  std::optional<Error> error;
  std::optional<plan::Plan> plan =
      plan::settle_batches(app, costs, [&](const std::vector<plan::Batch>& batches) -> std::optional<plan::Plan> {
        Result<plan::Plan> made = make_plan_at(plan::at_batches(costs, batches, app.graph), app, request);
        if (!made) {
          error = made.error();
          return std::nullopt;
        }
        made->batches = batches;
        return *std::move(made);
      });
  if (!plan) return *std::move(error);
  // Each stage took the size of batches for given; of all plans that there are, nothing is proven.
  if (!plan->batches.empty()) {
    plan->gap = 1.0;
    plan->quality = plan::Quality::kFeasible;
  }
  return *std::move(plan);
}

}  // namespace ctn::paper
