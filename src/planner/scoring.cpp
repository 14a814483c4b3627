#include "planner/scoring.h"

#include <algorithm>

#include "plan/limits.h"

namespace ctn::planner {
namespace {

using trial::Place;
using trial::Schedule;

// A core that is used for more than this part of what the slack leaves is nearly full; what it adds to the score if no
// such core has a gap of its own.
constexpr double kNearlyFull = 0.95;
constexpr double kGapWeight = 0.015;
// So much worse are frames in which runs that need input come more often than there is some: of two schedules that are
// as good, the one without slots in which nothing but a message is waited for. In a trial such runs come up to 2 % too
// often, since clocks of others slide through all phases there.
constexpr double kWaitingInSlots = 0.04;

// By the system's clock, or by outputs of one that does.
bool keeps_to_grid(const Schedule& schedule, const Place& place) {
  const Place* by = &place;
  while (by->after) {
    const SubchainId* const leader = by->after->subchain();
    if (leader == nullptr) return false;
    by = &schedule.subchains[leader->index()];
  }
  return by->form == trial::Form::kPriority && !by->pause && !by->clock;
}

// By core. A pipeline's runs may use any of its cores, and so may those that are to have what it leaves: each of them
// is as busy as all are on average.
std::vector<double> load(const Schedule& schedule, const trial::Figures& figures) {
  std::vector<double> load = figures.busy;
  for (const trial::Pipeline& pipeline : schedule.pipelines) {
    double sum = 0.0;
    for (const int core : pipeline.cores) sum += figures.busy[static_cast<std::size_t>(core)];
    const double mean = sum / static_cast<double>(pipeline.cores.size());
    for (const int core : pipeline.cores) load[static_cast<std::size_t>(core)] = mean;
  }
  return load;
}

}  // namespace

std::vector<double> tail_weights(const graph::App& app) {
  std::vector<double> weights(app.objective.size(), kTailWeight);
  std::optional<std::size_t> heaviest;
  for (std::size_t term = 0; term < app.objective.size(); ++term) {
    if (app.objective[term].metric != graph::Metric::kResponseTime) continue;
    if (!heaviest || app.objective[term].weight > app.objective[*heaviest].weight) heaviest = term;
  }
  if (heaviest) weights[*heaviest] = kHeaviestTailWeight;
  return weights;
}

double overload_score(const graph::App& app) {
  double weights = 0.0;
  for (const graph::Term& term : app.objective) weights += term.weight;
  constexpr double kLargest = 1e299;  // a few of them add up
  return weights > 0.0 ? std::min(1e9 * weights, kLargest) : 1e9;
}

Scoring::Scoring(const graph::App& app, double slack)
    : app_(app), slack_(slack), overload_(overload_score(app)), tail_weights_(tail_weights(app)) {
  const std::vector<plan::UsefulPeriod> useful = plan::useful_periods(app.graph);
  limits_input_ = std::any_of(useful.begin(), useful.end(), [](const auto& each) { return each.min > Millis{0}; });
}

CoreUse Scoring::use(const Schedule& schedule, const trial::Figures& figures) const {
  CoreUse used{.by_core = load(schedule, figures)};
  used.fullest = *std::max_element(used.by_core.begin(), used.by_core.end()) / (1.0 - slack_ + kLoadTolerance);
  for (const double busy : used.by_core) used.overload += std::max(0.0, busy - (1.0 - slack_) - kLoadTolerance);
  return used;
}

double Scoring::with_gaps(double score, const Schedule& schedule, const std::vector<double>& used) {
  std::vector<const Place*> lowest(static_cast<std::size_t>(schedule.cores), nullptr);
  for (const Place& place : schedule.subchains) {
    if (place.form != trial::Form::kPriority) continue;
    const Place*& at = lowest[static_cast<std::size_t>(place.core)];
    if (at == nullptr || place.priority < at->priority) at = &place;
  }
  std::size_t without = 0;
  for (std::size_t core = 0; core < lowest.size(); ++core) {
    if (lowest[core] == nullptr || used[core] <= kNearlyFull) continue;
    if (keeps_to_grid(schedule, *lowest[core])) ++without;
  }
  return score * (1.0 + kGapWeight * static_cast<double>(without) / static_cast<double>(schedule.cores));
}

// Means, and something for tails.
double Scoring::weighted(const trial::Figures& figures) const {
  double score = figures.objective;
  for (std::size_t term = 0; term < figures.terms.size(); ++term) {
    score += tail_weights_[term] * app_.objective[term].weight * figures.terms[term].p95_ms;
  }
  return score;
}

double Scoring::unbounded(const Schedule& schedule, const trial::Figures& figures, const CoreUse& used) const {
  std::vector<double> of_usable = used.by_core;
  for (double& of_core : of_usable) of_core /= 1.0 - slack_;
  const double waiting = limits_input_ && !schedule.frames.empty() ? kWaitingInSlots : 0.0;
  return with_gaps(weighted(figures) * (1.0 + waiting), schedule, of_usable) + overload_ * used.overload;
}

double Scoring::at_a_glance(const Schedule& schedule, const trial::Figures& figures) const {
  return weighted(figures) * (1.0 + use(schedule, figures).overload);
}

double Scoring::bounded(Surrogate& surrogate, const Schedule& schedule, std::optional<double> relax,
                        double score) const {
  if (!schedule.frames.empty()) return relaxed_score(score, relax.value_or(1.0));
  const std::optional<Estimate> estimate = surrogate(schedule);
  if (!estimate || estimate->exact_missed || !estimate->promised) return 2.0 * overload_;
  return relaxed_score(score, estimate->relax);
}

}  // namespace ctn::planner
