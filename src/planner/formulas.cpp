#include "planner/formulas.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <optional>
#include <ratio>
#include <string>
#include <utility>
#include <vector>

#include "base/text.h"
#include "plan/limits.h"
#include "plan/promise.h"
#include "planner/planner.h"
#include "planner/promised.h"
#include "planner/schedule_search.h"

namespace ctn::planner {
namespace {

std::optional<plan::Plan> guessed(const graph::App& app, const trial::Samples& samples, const model::CostTable& costs,
                                  const FormulaRequest& request) {
  ScheduleSearch search(app, {.cores = request.cores, .slack = request.slack});
  search.set_costs(samples, costs);
  search.guess(request.guesses);
  std::optional<Promised> best = best_promised(search, app, request.cores, request.slack);
  if (!best) return std::nullopt;
  return std::move(best->plan);
}

std::optional<plan::Plan> planned(const graph::App& app, const model::CostTable& costs, const FormulaRequest& request) {
  if (may_have_frames(app)) {
    auto plan =
        make_plan_in_frames(app, costs, {.cores = request.cores, .slack = request.slack, .steps = request.frame_steps});
    if (plan) return *std::move(plan);
  }
  if (!may_have_priorities(app)) return std::nullopt;
  return guessed(app, trial::Samples(app, trial::MeasuredRuns{}, costs), costs, request);
}

double speed_of_all(const graph::App& app, int cores) {
  if (app.core_kinds.empty()) return cores;
  const std::vector<int> counts = app.cores_by_kind(cores);
  double sum = 0.0;
  for (std::size_t kind = 0; kind < counts.size(); ++kind) sum += counts[kind] * app.core_kinds[kind].speed;
  return sum;
}

// The fewest cores that would do; where they differ, the fewest more of the fastest kind.
std::string hint_for(const graph::App& app, const model::CostTable& costs, const FormulaRequest& request) {
  if (!request.count_cores) return "give it more cores, lower a rate, or make its nodes cheaper";
  const std::size_t fastest = fastest_kind(app);
  const int max = std::min(kMaxCores, request.cores + static_cast<int>(app.graph.subchains().size()));
  FormulaRequest other = request;
  for (other.cores = request.cores + 1; other.cores <= max; ++other.cores) {
    const int more = other.cores - request.cores;
    if (!planned(with_more_cores(app, request.cores, fastest, more), costs, other)) continue;
    const std::string give = app.core_kinds.empty()
                                 ? fmt::format("give it {} cores", other.cores)
                                 : fmt::format("give it {} more of kind {}", more, app.core_kinds[fastest].name);
    return give + ", lower a rate, or make its nodes cheaper";
  }
  return "lower a rate, or make its nodes cheaper: more cores would not do";
}

// Where runs take so long that nothing can be promised of them.
std::optional<Problem> too_long(const graph::App& app, const model::CostTable& costs, double slack) {
  Millis sum{0};
  SubchainId longest(0);
  for (std::size_t i = 0; i < app.graph.subchains().size(); ++i) {
    const SubchainId id(i);
    const Millis cost = costs.subchain_total(app.graph, id);
    if (cost > costs.subchain_total(app.graph, longest)) longest = id;
    sum += cost / (1.0 - slack);
  }
  if (sum <= plan::kLongestPromise) return std::nullopt;
  using Hours = std::chrono::duration<double, std::ratio<3600>>;
  return Problem{
      {},
      "nodes",
      fmt::format("with {:.6g} % slack, a run of each subchain takes {:.4g} h in all, most of it in {}; what "
                  "takes more than {:.4g} h is not promised",
                  100.0 * slack, Hours(sum).count(), quote(app.graph.subchain(longest).name),
                  Hours(plan::kLongestPromise).count()),
      "make its nodes cheaper, or leave less slack"};
}

}  // namespace

Result<plan::Plan> make_guessed_plan(const graph::App& app, const trial::Samples& samples,
                                     const model::CostTable& costs, const FormulaRequest& request) {
  if (Status asked = check_request(app, request.cores, request.slack); !asked) return asked.error();
  if (std::optional<plan::Plan> plan = guessed(app, samples, costs, request)) return *std::move(plan);
  return unattainable(app, costs, request);
}

Result<plan::Plan> make_plan_by_formulas(const graph::App& app, const model::CostTable& costs,
                                         const FormulaRequest& request) {
  if (Status asked = check_request(app, request.cores, request.slack); !asked) return asked.error();
  if (std::optional<plan::Plan> plan = planned(app, costs, request)) return *std::move(plan);
  return unattainable(app, costs, request);
}

Error unattainable(const graph::App& app, const model::CostTable& costs, const FormulaRequest& request) {
  double needed = 0.0;  // of cores of speed 1
  std::string exact;
  constexpr std::size_t kNamed = 8;
  std::size_t exact_rates = 0;
  for (std::size_t i = 0; i < app.graph.subchains().size(); ++i) {
    const SubchainId id(i);
    const std::optional<Millis> period = plan::period_limits(app.graph, id).exact;
    if (!period) continue;
    needed += costs.subchain_total(app.graph, id) / *period;
    if (++exact_rates <= kNamed) exact += (exact.empty() ? "" : ", ") + app.graph.subchain(id).name;
  }
  if (exact_rates > kNamed) exact += fmt::format(" and {} more", exact_rates - kNamed);
  // Without exact rates there is a plan in frames, if its value can be told from infinity.
  if (std::optional<Problem> problem = too_long(app, costs, request.slack)) {
    return Error(ErrorKind::kCaller, {*std::move(problem)});
  }
  if (exact.empty() && may_have_frames(app)) {
    return Error(ErrorKind::kCaller, {Problem{{},
                                              "objective",
                                              "weights x times add up to more than can be computed with",
                                              "scale all weights down: only their ratios matter"}});
  }
  if (exact.empty()) {
    const bool asked = app.scheduler.schedule == graph::ScheduleKind::kPriorities;
    return Error(ErrorKind::kCaller,
                 {Problem{{},
                          asked ? "scheduler.schedule" : "nodes",
                          "no fixed priorities were found under which each subchain is promised a time",
                          asked ? "leave out schedule: priorities, or give it more cores"
                                : "give it more cores, or make its nodes cheaper"}});
  }
  const double there = speed_of_all(app, request.cores) * (1.0 - request.slack);
  const std::string_view unit = app.core_kinds.empty() ? "a core" : "a core of speed 1";
  std::string what = fmt::format(
      "the exact rates of {} cannot be met on {} with {:.6g} % slack: they need {:.4g} % of {}, of {:.4g} % that there "
      "is",
      exact, request.cores == 1 ? "1 core" : fmt::format("{} cores", request.cores), 100.0 * request.slack,
      100.0 * needed, unit, 100.0 * there);
  if (needed > there) {
    what += fmt::format("; {:.4g} % of {} is missing", 100.0 * (needed - there), unit);
  } else {
    what += ", and no way was found to fit everything else beside them";
  }
  return Error(ErrorKind::kCaller, {Problem{{}, "nodes", std::move(what), hint_for(app, costs, request)}});
}

}  // namespace ctn::planner
