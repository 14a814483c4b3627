#include "planner/planner.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "plan/predict.h"
#include "planner/allocation.h"
#include "planner/assemble.h"
#include "planner/instance.h"
#include "planner/owned.h"
#include "planner/set.h"

namespace ctn::planner {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
static_assert(kMostSubchains <= Set::kMost);

std::vector<Problem> mistakes(const graph::App& app, const Request& request) {
  std::vector<Problem> problems;
  if (request.cores < 1) {
    problems.push_back({{}, "cores", fmt::format("there are {} cores to plan for", request.cores), "give at least 1"});
  } else if (request.cores > kMaxCores) {
    problems.push_back({{},
                        "cores",
                        fmt::format("{} cores are more than this version plans for", request.cores),
                        fmt::format("give at most {}", kMaxCores)});
  } else if (request.cores > app.core_count().value_or(request.cores)) {
    problems.push_back(
        {{},
         "cores",
         fmt::format("there are {} cores to plan for, and the app lists {}", request.cores, *app.core_count()),
         fmt::format("give at most {}, or list the others under cores in the app file", *app.core_count())});
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
  } else if (subchains > kMostSubchains) {
    problems.push_back(
        {{},
         "subchains",
         fmt::format("the app has {} subchains, more than this version plans for", subchains),
         fmt::format("put nodes that run one after the other into one subchain, at most {} in all", kMostSubchains)});
  }
  return problems;
}

// Figures beyond what a double holds would neither compare nor print.
Error too_large() {
  return Error(ErrorKind::kCaller, {Problem{{},
                                            "objective",
                                            "weights x times add up to more than can be computed with",
                                            "scale all weights down: only their ratios matter"}});
}

// A step of stage I looks at one choice for one subchain: far less than one of the other searches.
constexpr std::size_t kStageOneSteps = 20;

class Planning {
 public:
  Planning(const graph::App& app, const model::CostTable& costs, const Request& request)
      : app_(app),
        costs_(costs),
        request_(request),
        instance_(make_instance(app, costs, request.cores, request.slack)) {}

  Result<plan::Plan> run() {
    Planned planned = search(free_target(instance_), nullptr);
    if (!planned.found && request_.method == Method::kJoint) {
      Effort effort{request_.effort};
      planned = plan_exact_apart(instance_, free_target(instance_), planned.bound, effort);
    }
    if (!planned.found) return unattainable();
    if (!meets_bounds(planned)) planned = bounded(planned);
    return assembled(planned);
  }

  std::optional<plan::Plan> run_below(double limit) {
    Planned planned = search(free_target(instance_), nullptr, limit);
    if (planned.found && !meets_bounds(planned)) {
      const double bound = planned.bound;
      planned = search(objective_target(instance_, kUnscaled), nullptr, limit);
      planned.bound = std::max(planned.bound, bound);
    }
    if (!planned.found || !(planned.shares.value < limit)) return std::nullopt;
    return assembled(planned);
  }

 private:
  // Bounds hold if they are missed by less than the plan's tolerance: what is searched for is well within it.
  static constexpr double kUnscaled = 1.0 + plan::kTolerance / 100.0;

  bool meets_bounds(const Planned& planned) const {
    return factor_of(instance_, planned.shares.timings) <= 1.0 + plan::kTolerance;
  }

  plan::Plan assembled(const Planned& planned) const {
    plan::Plan plan = assemble(app_, costs_, instance_, planned, request_.cores, request_.slack);
    plan.gap = plan.objective > 0.0 ? std::max(0.0, (plan.objective - planned.bound) / plan.objective) : 0.0;
    if (plan.gap <= plan::kTolerance) plan.gap = 0.0;
    plan.quality = plan.gap == 0.0 ? plan::Quality::kOptimal : plan::Quality::kFeasible;
    return plan;
  }

  Planned search(const Target& target, const Planned* known, double cutoff = kInfinity) const {
    Effort effort{request_.effort};
    Allocation allocation;
    if (request_.method == Method::kTwoStage) {
      effort = {kStageOneSteps * request_.effort};
      Planned first = allocate_by_equal_shares(instance_, target, effort);
      if (!first.found && !target.limits.empty()) {
        const Target free{target.groups, {}};
        first = allocate_by_equal_shares(instance_, free, effort);
      }
      if (!first.found) return first;
      effort = {request_.effort};
      Planned second = plan_shares(instance_, target, first.allocation, effort);
      if (second.found || !known) return second;
      return *known;
    }
    if (known) return plan_jointly(instance_, target, &known->allocation, known, cutoff, effort);
    const bool warm = request_.warm && allocation_of(*request_.warm, instance_, allocation);
    return plan_jointly(instance_, target, warm ? &allocation : nullptr, nullptr, cutoff, effort);
  }

  // Not all bounds hold in the best plan without them.
  Planned bounded(const Planned& without) const {
    const Target least = factor_target(instance_);
    Planned nearest = search(least, nullptr);
    if (!nearest.found) return without;
    const double factor = std::max(1.0, nearest.shares.value) * kUnscaled;
    const Target target = objective_target(instance_, factor);
    nearest.shares.value = objective_of(instance_, nearest.shares.timings);
    nearest.bound = without.bound;
    Planned planned = search(target, &nearest);
    if (!planned.found) return nearest;
    planned.bound = std::max(planned.bound, without.bound);
    return planned;
  }

  Error unattainable() const {
    double needed = 0.0;  // of cores of speed 1
    std::string exact;
    constexpr std::size_t kNamed = 8;
    std::size_t exact_rates = 0;
    for (std::size_t i = 0; i < instance_.members.size(); ++i) {
      const Member& member = instance_.members[i];
      if (member.exact_period <= 0.0) continue;
      needed += costs_.subchain_total(app_.graph, SubchainId(i)).count() / member.exact_period;
      if (++exact_rates <= kNamed) exact += (exact.empty() ? "" : ", ") + app_.graph.subchain(SubchainId(i)).name;
    }
    if (exact_rates > kNamed) exact += fmt::format(" and {} more", exact_rates - kNamed);
    // Without exact rates there is always a plan, if its value can be told from infinity.
    if (exact.empty()) return too_large();
    const double there = speed_of_all() * instance_.usable;
    const std::string_view unit = app_.core_kinds.empty() ? "a core" : "a core of speed 1";
    std::string what = fmt::format(
        "the exact rates of {} cannot be met on {} with {:.6g} % slack: they need {:.4g} % of {}, of {:.4g} % that "
        "there is",
        exact, request_.cores == 1 ? "1 core" : fmt::format("{} cores", request_.cores), 100.0 * request_.slack,
        100.0 * needed, unit, 100.0 * there);
    if (needed > there) {
      what += fmt::format("; {:.4g} % of {} is missing", 100.0 * (needed - there), unit);
    } else {
      what += ", but not side by side: each sets the pace of its core, and beside it everything else has to fit";
    }
    return Error(ErrorKind::kCaller, {Problem{{}, "nodes", std::move(what), mend()}});
  }

  double speed_of_all() const {
    if (app_.core_kinds.empty()) return request_.cores;
    const std::vector<int> counts = app_.cores_by_kind(request_.cores);
    double sum = 0.0;
    for (std::size_t kind = 0; kind < counts.size(); ++kind) sum += counts[kind] * app_.core_kinds[kind].speed;
    return sum;
  }

  // The fewest cores that would do; where they differ, the fewest more of the fastest kind.
  std::string mend() const {
    if (!request_.count_cores) return "give it more cores, lower a rate, or make its nodes cheaper";
    const std::size_t fastest = fastest_kind(app_);
    const int most = std::min<int>(kMaxCores, request_.cores + static_cast<int>(instance_.members.size()));
    for (int cores = request_.cores + 1; cores <= most; ++cores) {
      const int more = cores - request_.cores;
      const graph::App larger_app = with_more_cores(app_, request_.cores, fastest, more);
      const Instance larger = make_instance(larger_app, costs_, cores, request_.slack);
      const Target target = free_target(larger);
      Effort effort{request_.effort / 8};
      if (!plan_jointly(larger, target, nullptr, nullptr, kInfinity, effort).found) continue;
      const std::string give = app_.core_kinds.empty()
                                   ? fmt::format("give it {} cores", cores)
                                   : fmt::format("give it {} more of kind {}", more, app_.core_kinds[fastest].name);
      return give + ", lower a rate, or make its nodes cheaper";
    }
    return "lower a rate, or make its nodes cheaper: more cores would not do";
  }

  const graph::App& app_;
  const model::CostTable& costs_;
  const Request& request_;
  const Instance instance_;
};

}  // namespace

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

namespace {

std::string_view name_of(Method method) { return method == Method::kJoint ? "joint" : "two-stage"; }

}  // namespace

Result<plan::Plan> make_plan(const graph::App& app, const model::CostTable& costs, const Request& request) {
  std::vector<Problem> problems = mistakes(app, request);
  if (!problems.empty()) return Error(ErrorKind::kCaller, std::move(problems));
  Result<plan::Plan> plan = app.graph.subchains().size() == 1 ? plan_owned(app, costs, request.cores, request.slack)
                                                              : Planning(app, costs, request).run();
  if (plan && !std::isfinite(plan->objective)) return too_large();
  if (plan) plan->planner = name_of(request.method);
  return plan;
}

Result<std::optional<plan::Plan>> make_plan_below(const graph::App& app, const model::CostTable& costs,
                                                  const Request& request, double limit) {
  std::vector<Problem> problems = mistakes(app, request);
  if (!problems.empty()) return Error(ErrorKind::kCaller, std::move(problems));
  std::optional<plan::Plan> plan;
  if (app.graph.subchains().size() == 1) {
    Result<plan::Plan> owned = plan_owned(app, costs, request.cores, request.slack);
    if (owned && owned->relax_factor <= 1.0 && owned->objective < limit) plan = std::move(*owned);
  } else {
    plan = Planning(app, costs, request).run_below(limit);
  }
  if (plan) plan->planner = name_of(request.method);
  return plan;
}

}  // namespace ctn::planner
