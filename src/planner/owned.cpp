#include "planner/owned.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include "model/formulas.h"
#include "plan/limits.h"
#include "plan/predict.h"
#include "planner/instance.h"

namespace ctn::planner {
namespace {

const SubchainId kOnly{0};

// What cannot be told apart from rounding counts as equal, so that a core is not taken for the last bit of a figure.
bool clearly_less(double a, double b) { return a < b * (1.0 - plan::kTolerance / 1000.0); }

struct Candidate {
  plan::SubchainPlan subchain;
  plan::Prediction prediction;

  Millis response() const { return subchain.execution + subchain.period; }
};

struct Input {
  const graph::App& app;
  const model::CostTable& base;   // of a core of speed 1
  const model::CostTable& costs;  // of the kind looked at
  int first;                      // the number of the first core of that kind
  double slack;
  plan::PeriodLimits limits;
};

model::OwnedCores formula(const Input& in, int cores, int threads) {
  return model::owned_cores_with(in.app.graph, kOnly, in.costs, cores, threads, in.slack);
}

// None where the exact rate is out of reach.
std::optional<Candidate> candidate(const Input& in, int cores, int threads) {
  const model::OwnedCores owned = formula(in, cores, threads);
  Millis period = std::max(owned.period, in.limits.min);
  if (in.limits.exact) {
    if (owned.period > *in.limits.exact * (1.0 + plan::kTolerance)) return std::nullopt;
    period = *in.limits.exact;
  }
  Candidate made;
  made.subchain.cores.resize(static_cast<std::size_t>(cores));
  std::iota(made.subchain.cores.begin(), made.subchain.cores.end(), in.first);
  made.subchain.period = period;
  made.subchain.execution = owned.execution;
  made.subchain.wait = in.costs.subchain_wait(in.app.graph, kOnly);
  if (!plan::takes_batches(in.app.graph, kOnly)) made.subchain.every = 1;
  made.subchain.slice = in.costs.subchain_total(in.app.graph, kOnly);
  made.subchain.threads = threads;
  made.prediction = plan::predict(in.app, in.base, {&made.subchain, 1}, {});
  return made;
}

// Whether `a` is the better number of threads for the same cores.
bool better_threads(const Candidate& a, const Candidate& b) {
  if (clearly_less(a.prediction.relax_factor, b.prediction.relax_factor)) return true;
  if (clearly_less(b.prediction.relax_factor, a.prediction.relax_factor)) return false;
  return clearly_less(a.response().count(), b.response().count());
}

// Whether `a` is worth its cores more than `b`.
bool better_cores(const Candidate& a, const Candidate& b) {
  if (clearly_less(a.prediction.relax_factor, b.prediction.relax_factor)) return true;
  if (clearly_less(b.prediction.relax_factor, a.prediction.relax_factor)) return false;
  return clearly_less(a.prediction.objective, b.prediction.objective);
}

std::optional<Candidate> best_on(const Input& in, int cores) {
  std::optional<Candidate> best;
  for (int threads = 1; threads <= std::min(cores, useful_threads(in.app, in.costs, kOnly)); ++threads) {
    std::optional<Candidate> other = candidate(in, cores, threads);
    if (other && (!best || better_threads(*other, *best))) best = std::move(other);
  }
  return best;
}

Millis shortest_period(const Input& in, int cores) {
  Millis shortest = formula(in, 1, 1).period;
  for (int k = 1; k <= cores; ++k) {
    for (int threads = 1; threads <= k; ++threads) shortest = std::min(shortest, formula(in, k, threads).period);
  }
  return shortest;
}

// Why no number of cores and threads meets the exact rate.
Error unattainable(const Input& in, int cores, Millis shortest) {
  const Millis exact = *in.limits.exact;
  const std::string& node = in.app.graph.node(*in.limits.exact_of).name;
  return Error(ErrorKind::kCaller,
               {Problem{{},
                        fmt::format("nodes.{}.min_rate", node),
                        fmt::format("exactly {:.6g}Hz asks for a run every {:.6g}ms, and with {} and {:.6g} % slack "
                                    "the least possible period is {:.6g}ms: {:.6g}ms too long, {:.3g} % of the CPU "
                                    "time it needs is missing",
                                    1000.0 / exact.count(), exact.count(),
                                    cores == 1 ? "1 core" : fmt::format("{} cores", cores), 100.0 * in.slack,
                                    shortest.count(), (shortest - exact).count(), 100.0 * (1.0 - exact / shortest)),
                        fmt::format("ask for at most {:.6g}Hz, make the nodes of subchain {} cheaper, or give it more "
                                    "cores if it can use them",
                                    1000.0 / shortest.count(), in.app.graph.subchain(kOnly).name)}});
}

plan::Plan to_plan(const Input& in, Candidate best, int cores) {
  plan::Plan plan;
  plan.slack = in.slack;
  plan.subchains.push_back(std::move(best.subchain));
  plan.cores.resize(static_cast<std::size_t>(cores));
  for (plan::CorePlan& core : plan.cores) core.frames = in.app.scheduler.frames;
  plan::fill_predictions(plan, in.app, in.base);
  return plan;
}

}  // namespace

Result<plan::Plan> plan_owned(const graph::App& app, const model::CostTable& costs, int cores, double slack) {
  const plan::PeriodLimits limits = plan::period_limits(app.graph, kOnly);
  const std::vector<int> counts = app.cores_by_kind(cores);
  std::optional<Candidate> best;
  Millis shortest = Millis::max();
  int useful = 0;
  int first = 0;
  for (std::size_t kind = 0; kind < counts.size(); first += counts[kind++]) {
    if (counts[kind] == 0) continue;
    const model::CostTable of_kind = costs.on(app, kind);
    const Input in{app, costs, of_kind, first, slack, limits};
    const int of_use = useful_cores(app, of_kind, kOnly, counts[kind]);
    useful = std::max(useful, of_use);
    shortest = std::min(shortest, shortest_period(in, of_use));
    for (int k = 1; k <= of_use; ++k) {
      std::optional<Candidate> other = best_on(in, k);
      if (other && (!best || better_cores(*other, *best))) best = std::move(other);
    }
  }
  const Input in{app, costs, costs, 0, slack, limits};
  if (!best) return unattainable(in, useful, shortest);
  return to_plan(in, *std::move(best), cores);
}

}  // namespace ctn::planner
