#include "policy/search_policy.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

#include "base/numbers.h"
#include "plan/limits.h"
#include "plan/predict.h"
#include "plan/validate.h"
#include "planner/expected.h"
#include "planner/frames.h"
#include "planner/promised.h"
#include "planner/schedule_search.h"
#include "planner/scoring.h"
#include "policy/replan.h"
#include "trial/schedule.h"
#include "trial/trial.h"

namespace ctn::policy {
namespace {

constexpr std::size_t kGuesses = 6000;
constexpr std::size_t kGuessesAgain = 1000;
constexpr Nanos kSearchStep = std::chrono::milliseconds{4};
// By which a schedule must be better to replace the one in force, by two trials with the same draws, so that luck has
// little part in it.
constexpr double kBetter = 0.004;
// A node's mean cost (or typical time on several threads), and its highest, by which samples (model/estimator.h) may
// differ when nothing has changed.
constexpr double kMeanChanged = 0.1;
constexpr double kLongestChanged = 0.3;
// What is found at the costs of a few runs is not worth much more time than this for each time that their number has
// doubled; the rest is saved for when there are more.
constexpr Nanos kWorthADoubling = std::chrono::milliseconds{60};
constexpr std::size_t kManyRuns = 100;

// Work that is, in all, where each node has run so often or more.
Nanos worth_while(std::size_t runs) {
  if (runs >= kManyRuns) return Nanos::max();
  Nanos worth = kWorthADoubling;
  for (std::size_t doubled = 2; doubled <= runs; doubled *= 2) worth += kWorthADoubling;
  return worth;
}

// So many steps of the search without success, and it rests until something changes.
constexpr std::size_t kEnoughInVain = 1500;

bool differ(double before, double after, double threshold) {
  return std::abs(after - before) > threshold * std::max(before, after);
}

using Runs = std::vector<model::RunTime>;

double mean_of(const Runs& runs) {
  const Nanos sum = std::accumulate(runs.begin(), runs.end(), Nanos{0},
                                    [](Nanos so_far, const model::RunTime& run) { return so_far + run.cpu; });
  return static_cast<double>(sum.count()) / static_cast<double>(runs.size());
}
// With waits: what CPU time does not show shows here.
double mean_length_of(const Runs& runs) {
  const Nanos sum = std::accumulate(runs.begin(), runs.end(), Nanos{0},
                                    [](Nanos so_far, const model::RunTime& run) { return so_far + run.wait; });
  return mean_of(runs) + static_cast<double>(sum.count()) / static_cast<double>(runs.size());
}
double longest_of(const Runs& runs) {
  const auto cheaper = [](const model::RunTime& a, const model::RunTime& b) { return a.cpu < b.cpu; };
  return static_cast<double>(std::max_element(runs.begin(), runs.end(), cheaper)->cpu.count());
}

bool changed(const Runs& before, const Runs& after) {
  if (before.empty() || after.empty()) return before.empty() != after.empty();
  return differ(mean_of(before), mean_of(after), kMeanChanged) ||
         differ(mean_length_of(before), mean_length_of(after), kMeanChanged) ||
         differ(longest_of(before), longest_of(after), kLongestChanged);
}
bool changed(const trial::MeasuredRuns& before, const trial::MeasuredRuns& after) {
  for (std::size_t node = 0; node < before.size(); ++node) {
    for (std::size_t kind = 0; kind < before[node].size(); ++kind) {
      if (changed(before[node][kind], after[node][kind])) return true;
    }
  }
  return false;
}

// What the machine takes for each run is in what was measured; trials add it.
trial::MeasuredRuns without_overhead(trial::MeasuredRuns runs) {
  const Nanos machine = trial::Overheads{}.run;
  for (auto& kinds : runs) {
    for (Runs& kind : kinds) {
      for (model::RunTime& run : kind) run.cpu = std::max(run.cpu - machine, Nanos{1});
    }
  }
  return runs;
}

// What was decided on last, and what is known of it at the costs that the search goes by.
struct Chosen {
  trial::Schedule schedule;
  std::optional<plan::Plan> plan{};
  std::optional<planner::Found> as_tried{};
};

// One app, on one set of cores.
struct Searching {
  explicit Searching(const Situation& situation)
      : app(situation.app),
        search(app, {.cores = static_cast<int>(situation.cpus.size()), .slack = situation.slack}),
        costs(situation.costs),
        typical(situation.typical) {}

  bool goes_on(std::size_t min_runs) const {
    if (search.has_untried()) return true;  // the one in force may be a bad guess
    return search.steps_in_vain() < kEnoughInVain && search.work() < worth_while(min_runs);
  }

  graph::App app;  // the search refers to it
  planner::ScheduleSearch search;
  trial::MeasuredRuns runs;          // that it goes by; empty at first
  model::CostTable costs;            // the same
  model::CostTable typical;          // the same
  double step_factor = 1.0;          // the same
  std::optional<plan::Plan> frames;  // the plan in frames, at costs that may have changed since
  std::optional<trial::Schedule> frames_schedule;
  std::optional<Chosen> chosen;
};

class SearchMemory : public Memory {
 public:
  bool more_to_do(std::size_t min_runs) const override { return searching_ && searching_->goes_on(min_runs); }
  Nanos work() const override { return searching_ ? searching_->search.work() : Nanos{0}; }

  Searching& of(const Situation& situation) {
    if (!searching_) searching_ = std::make_unique<Searching>(situation);
    return *searching_;
  }

 private:
  std::unique_ptr<Searching> searching_;
};

// One decision.
class Deciding {
 public:
  Deciding(Searching& searching, const Situation& situation, const Decision& in_force)
      : with_(searching), situation_(situation), in_force_(in_force) {}

  // Errors: nothing was found that holds, and what is in force cannot go on either.
  Result<std::optional<Decision>> decide() {
    std::vector<NodeId> known;
    for (std::size_t index = 0; index < situation_.clocks.size(); ++index) {
      if (situation_.clocks[index].period > Nanos{0}) known.emplace_back(index);
    }
    with_.search.know_clocks(std::move(known));
    const bool other_phases = with_.search.know_phases({situation_.clocks.begin(), situation_.clocks.end()});
    if (other_phases && with_.chosen) with_.chosen->as_tried.reset();
    const bool fresh = take_costs();
    const bool routine = is_routine(situation_.why) && in_force_.plan.has_value();
    if (!routine || (fresh && has_frames())) ask_for_frames();
    if (!routine || fresh) with_.search.guess(routine ? kGuessesAgain : kGuesses);
    const bool whatever = !in_force_.plan || is_unconditional(situation_.why);
    if (whatever) return best_of_all(true);
    if (fresh || with_.goes_on(situation_.min_runs)) with_.search.improve(kSearchStep);
    std::optional<plan::Plan> now = in_force_now();
    if (!now) return best_of_all(fresh);
    const bool slower = try_chosen(now);
    const double score = planner::relaxed_score(with_.chosen->as_tried->score, now->relax_factor);
    Result<std::optional<Decision>> better = best(score * (1.0 - kBetter));
    if (!better || *better || !(fresh || slower)) return better;
    return std::optional(following(*now, with_.chosen->schedule));
  }

 private:
  // Whether costs are new ones.
  bool take_costs() {
    const bool known = !with_.runs.empty() && is_routine(situation_.why);
    const bool same_steps = with_.step_factor == situation_.step_factor;
    if (known && same_steps && !changed(with_.runs, *situation_.runs) && !outputs_changed() && !idle_runs_changed() &&
        !threads_changed() && !batches_changed()) {
      return false;
    }
    with_.runs = *situation_.runs;
    with_.costs = situation_.costs;
    with_.typical = situation_.typical;
    with_.step_factor = situation_.step_factor;
    with_.search.set_costs(trial::Samples(with_.app, without_overhead(with_.runs), with_.costs),
                           may_promise_typical() ? with_.typical : with_.costs,
                           trial::Overheads::with_steps(with_.step_factor));
    if (with_.chosen) with_.chosen = Chosen{with_.chosen->schedule};
    return true;
  }

  // What is told of them is no noise (model/output_estimator.h).
  bool outputs_changed() const {
    for (std::size_t index = 0; index < with_.app.graph.nodes().size(); ++index) {
      const NodeId node(index);
      if (with_.costs.runs_per_output(node) != situation_.costs.runs_per_output(node)) return true;
    }
    return false;
  }

  // Which part of the runs that find nothing new are idle is told as outputs are; what these cost, if by more than what
  // other runs may differ by when nothing has changed.
  bool idle_runs_changed() const {
    for (std::size_t index = 0; index < with_.app.graph.nodes().size(); ++index) {
      const NodeId node(index);
      const model::IdleRuns before = with_.costs.idle(node);
      const model::IdleRuns after = situation_.costs.idle(node);
      if (before.part != after.part) return true;
      const Millis noise = kMeanChanged * situation_.costs[node].single_thread();
      if (std::chrono::abs(after.cost - before.cost) > noise) return true;
    }
    return false;
  }

  // What each item of a batch adds, on any kind of cores, if by more than what differs when nothing has changed.
  bool batches_changed() const {
    for (std::size_t kind = 0; kind < with_.app.kinds(); ++kind) {
      const model::CostTable before = with_.costs.on(with_.app, kind);
      const model::CostTable after = situation_.costs.on(with_.app, kind);
      for (std::size_t index = 0; index < with_.app.graph.nodes().size(); ++index) {
        const NodeId node(index);
        if (differ(before[node].per_item().count(), after[node].per_item().count(), kMeanChanged)) return true;
      }
    }
    return false;
  }

  // What runs typically take on several threads, where that was measured.
  bool threads_changed() const {
    for (std::size_t index = 0; index < with_.app.graph.nodes().size(); ++index) {
      const int max = with_.app.graph.nodes()[index].max_threads;
      const model::CostProfile& before = with_.typical[NodeId(index)];
      const model::CostProfile& after = situation_.typical[NodeId(index)];
      for (const auto& [threads, elapsed] : after.by_threads()) {
        if (differ(before.with_threads(threads, max).count(), elapsed.count(), kMeanChanged)) return true;
      }
    }
    return false;
  }

  bool has_frames() const { return with_.chosen && with_.chosen->schedule == with_.frames_schedule; }

  // Where there is no such plan any more, the one before is not there either: it would not hold.
  void ask_for_frames() {
    // What it was decided on before is decided on again at the new costs.
    const bool followed = has_frames();
    with_.frames.reset();
    with_.frames_schedule.reset();
    if (!planner::may_have_frames(with_.app)) return;
    Result<plan::Plan> plan = planner::make_plan_in_frames(with_.app, with_.costs,
                                                           {.cores = static_cast<int>(situation_.cpus.size()),
                                                            .slack = situation_.slack,
                                                            .steps = planner::kFrameStepsAtRunTime});
    if (!plan) return;
    // Cores of its own are paced by what is usual.
    plan->expected = plan::expect(*plan, plan::as_planned(with_.app, *plan), situation_.typical);
    with_.frames = std::move(*plan);
    with_.frames_schedule = trial::schedule_of(with_.app, *with_.frames);
    if (followed) with_.chosen = Chosen{*with_.frames_schedule};
    with_.search.add(*with_.frames_schedule, with_.frames->relax_factor);
  }

  // Keeping promises makes response times longer. Where the app has no bounds and a core has no time for all runs at
  // the planned percentile, promises may be for what runs typically cost
  // (docs/decisions/0041-promises-for-typical-costs.md).
  bool may_promise_typical() const { return !with_.app.has_bounds(); }

  std::optional<plan::Plan> plan_of(const trial::Schedule& schedule) const {
    if (schedule != with_.frames_schedule) {
      const auto at = [&](const model::CostTable& costs) {
        return planner::plan_of(with_.app, with_.search.samples(), costs, schedule, situation_.slack);
      };
      std::optional<plan::Plan> plan = at(with_.costs);
      if (plan || !may_promise_typical()) return plan;
      plan = at(with_.typical);
      if (plan) plan->for_typical = true;
      return plan;
    }
    if (!plan::validate(*with_.frames, with_.app, with_.costs, static_cast<int>(situation_.cpus.size()))) return {};
    return with_.frames;
  }
  // With longer periods, where it holds by these alone. None: it cannot go on.
  std::optional<plan::Plan> in_force_now() {
    if (!with_.chosen) return std::nullopt;
    if (with_.chosen->plan) return with_.chosen->plan;
    if (has_frames()) return with_.chosen->plan = plan_of(with_.chosen->schedule);
    for (const double factor : planner::kSlowedBy) {
      trial::Schedule slowed = with_.search.slowed(with_.chosen->schedule, factor);
      std::optional<plan::Plan> plan = plan_of(slowed);
      if (!plan) continue;
      if (slowed != with_.chosen->schedule) with_.chosen = Chosen{std::move(slowed)};
      return with_.chosen->plan = std::move(plan);
    }
    return std::nullopt;
  }

  // At these costs; what would overload a core is chosen with longer periods, where that holds, and `now` is its plan.
  // Whether that is so.
  bool try_chosen(std::optional<plan::Plan>& now) {
    if (with_.chosen->as_tried) return false;
    planner::Found tried = with_.search.tried(with_.chosen->schedule, std::nullopt);
    const bool slower = tried.schedule != with_.chosen->schedule;
    std::optional<plan::Plan> plan = slower ? plan_of(tried.schedule) : std::nullopt;
    if (plan) {
      now = plan;
      with_.chosen = Chosen{tried.schedule, std::move(plan)};
    }
    with_.chosen->as_tried = std::move(tried);
    return slower && with_.chosen->schedule == with_.chosen->as_tried->schedule;
  }

  // Whatever it is worth. `must`: it is an error if there is none.
  Result<std::optional<Decision>> best_of_all(bool must) {
    Result<std::optional<Decision>> found = best(kInfinity);
    if (!must || (found && *found)) return found;
    return Error::caller("no schedule was found that keeps what the app asks for", "relax it");
  }

  // The best plan whose score is below `limit`, if there is one. Guesses count where anything does.
  Result<std::optional<Decision>> best(double limit) {
    const bool any = std::isinf(limit);
    for (const planner::Found& found : with_.search.best()) {
      if (!any && !found.tried) continue;
      const std::optional<plan::Plan> plan = plan_of(found.schedule);
      if (!plan || planner::relaxed_score(found.score, plan->relax_factor) >= limit) continue;
      with_.chosen = Chosen{found.schedule, plan};
      return std::optional(following(*plan, found.schedule));
    }
    return std::optional<Decision>();
  }

  Decision following(plan::Plan plan, const trial::Schedule& schedule) {
    say_what_is_known(plan, with_.costs, situation_.assumed, with_.app.graph);
    plan.planner = "auto";
    plan.expected = planner::expectation_of(with_.app, plan, schedule, with_.search.expected(schedule));
    return PlannedPolicy::following(std::move(plan), situation_);
  }

  Searching& with_;
  const Situation& situation_;
  const Decision& in_force_;
};

}  // namespace

std::unique_ptr<Memory> SearchPolicy::make_memory() const { return std::make_unique<SearchMemory>(); }

Result<std::optional<Decision>> SearchPolicy::decide_again(const Situation& situation, const Decision& in_force) const {
  auto* const memory = static_cast<SearchMemory*>(situation.memory);
  if (memory == nullptr || situation.runs == nullptr || situation.frames ||
      !planner::may_have_priorities(situation.app)) {
    return replacement(formulas_, situation, in_force);
  }
  Searching& searching = memory->of(situation);
  Result<std::optional<Decision>> decision = Deciding(searching, situation, in_force).decide();
  if (decision) return decision;
  searching.chosen.reset();
  return replacement(formulas_, situation, in_force);
}

}  // namespace ctn::policy
