// The answer of the paper's planner for a random app by brute force, which knows nothing of the planner: it tries every
// partition of the subchains and every whole number, by the formulas of the paper, in which no run waits and runs of a
// queue node are evenly spread.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "base/numbers.h"
#include "model/evaluate.h"
#include "model/formulas.h"
#include "plan/limits.h"
#include "planner/testing/random_apps.h"

namespace ctn::planner {

class BruteForce {
 public:
  struct Best {
    bool found = false;
    double factor = kInfinity;
    double objective = kInfinity;
  };

  explicit BruteForce(const RandomCase& any)
      : any_(any),
        count_(any.app.graph.subchains().size()),
        costs_(model::costs_by_kind(any.app, any.costs)),
        free_(any.app.cores_by_kind(any.cores)) {
    timings_.resize(count_);
    group_.resize(count_);
    kind_.resize(static_cast<std::size_t>(any.cores));
  }

  Best run() {
    // First the least factor, then the least objective among those that have it.
    for (factor_only_ = true;; factor_only_ = false) {
      partition(0, 0);
      if (!factor_only_) return best_;
      if (!best_.found) return best_;
    }
  }

 private:
  struct Timing {
    double period = 0.0;
    double execution = 0.0;
  };
  static constexpr double kRounding = 1e-9;

  SubchainId id(std::size_t i) const { return SubchainId(i); }
  std::size_t kind(std::size_t i) const { return kind_[static_cast<std::size_t>(group_[i])]; }
  double cost(std::size_t i) const { return costs_[kind(i)].subchain_total(any_.app.graph, id(i)).count(); }

  void partition(std::size_t i, int groups) {
    if (i == count_) return own(0);
    for (int g = 0; g < groups; ++g) {
      group_[i] = g;
      partition(i + 1, groups);
    }
    for (std::size_t kind = 0; groups < any_.cores && kind < free_.size(); ++kind) {
      if (free_[kind] == 0) continue;
      group_[i] = groups;
      kind_[static_cast<std::size_t>(groups)] = kind;
      --free_[kind];
      partition(i + 1, groups + 1);
      ++free_[kind];
    }
  }

  // Gives the spare cores to those that are alone, in every way.
  void own(std::size_t i) {
    if (i == count_) return share(0);
    const bool alone = std::count(group_.begin(), group_.end(), group_[i]) == 1;
    if (!alone) return own(i + 1);
    int& free = free_[kind(i)];
    const int before = free;
    for (int k = 1; k - 1 <= before; ++k) {
      free = before - (k - 1);
      const model::OwnedCores owned = model::owned_cores(any_.app.graph, id(i), costs_[kind(i)], k, any_.slack);
      const plan::PeriodLimits limits = plan::period_limits(any_.app.graph, id(i));
      double period = std::max(owned.period.count(), limits.min.count());
      if (limits.exact) {
        if (period > limits.exact->count() * (1.0 + kRounding)) continue;
        period = limits.exact->count();
      }
      timings_[i] = {period, owned.execution.count()};
      own(i + 1);
    }
    free = before;
  }

  std::vector<std::size_t> members(int g) const {
    std::vector<std::size_t> found;
    for (std::size_t i = 0; i < count_; ++i) {
      if (group_[i] == g) found.push_back(i);
    }
    return found;
  }

  void share(int g) {
    if (g == any_.cores) return judge();
    const std::vector<std::size_t> all = members(g);
    if (all.size() < 2) return share(g + 1);
    std::vector<int> every(all.size(), 1);
    choose(g, all, every, 0);
  }

  void choose(int g, const std::vector<std::size_t>& all, std::vector<int>& every, std::size_t at) {
    if (at == all.size()) return frame(g, all, every);
    const double c = cost(all[at]);
    const double min_slice = to_millis(any_.app.scheduler.min_slice).count();
    const int max = plan::takes_batches(any_.app.graph, id(all[at])) || c < min_slice
                        ? 1
                        : static_cast<int>(std::floor(c / min_slice * (1.0 + 1e-12)));
    for (every[at] = 1; every[at] <= max; ++every[at]) choose(g, all, every, at + 1);
  }

  void frame(int g, const std::vector<std::size_t>& all, const std::vector<int>& every) {
    const double usable = 1.0 - any_.slack;
    double busy = 0.0;
    double min = 0.0;
    std::optional<double> exact;
    std::optional<std::size_t> queue;
    for (std::size_t m = 0; m < all.size(); ++m) {
      if (plan::takes_batches(any_.app.graph, id(all[m]))) {
        queue = all[m];
        continue;
      }
      const plan::PeriodLimits limits = plan::period_limits(any_.app.graph, id(all[m]));
      busy += cost(all[m]) / every[m];
      min = std::max(min, limits.min.count() / every[m]);
      if (limits.exact) {
        const double given = limits.exact->count() / every[m];
        if (exact && std::abs(*exact - given) > kRounding * given) return;
        exact = given;
      }
    }
    const auto set = [&](double frame, double queue_period) {
      for (std::size_t m = 0; m < all.size(); ++m) {
        const double period = queue == all[m] ? queue_period : frame * every[m];
        const double share = frame > 0.0 ? frame / period : 1.0;
        timings_[all[m]] = {frame / share, frame / share};
      }
    };
    if (!queue) {
      const double shortest = std::max(busy / usable, min);
      if (exact && shortest > *exact * (1.0 + kRounding)) return;
      set(exact ? *exact : shortest, 0.0);
      return share(g + 1);
    }
    // One free share: convex in the frame, which is narrowed down by thirds (the rest of the app given).
    const double c = cost(*queue);
    const double min_slice = to_millis(any_.app.scheduler.min_slice).count();
    const double max = c < min_slice ? 1.0 : c / min_slice;
    const double cap = plan::period_limits(any_.app.graph, id(*queue)).min.count();
    double low = std::max({(busy + c / max) / usable, min, cap / max});
    double high = std::max(low, 60.0 * (busy + c) / usable);
    const auto at = [&](double frame) {
      const double room = usable - busy / frame;
      set(frame, std::max(c / room, cap));
      const Best before = best_;
      best_ = {};
      share(g + 1);
      const double found = factor_only_ ? best_.factor : best_.objective;
      best_ = before;
      return found;
    };
    for (int third = 0; third < 120; ++third) {
      const double a = low + (high - low) * 0.382;
      const double b = low + (high - low) * 0.618;
      (at(a) <= at(b) ? high : low) = at(a) <= at(b) ? b : a;
    }
    const double frame_found = 0.5 * (low + high);
    set(frame_found, std::max(c / (usable - busy / frame_found), cap));
    share(g + 1);
  }

  void judge() {
    std::vector<model::SubchainTiming> timings;
    for (const Timing& timing : timings_) timings.push_back({Millis{timing.period}, Millis{timing.execution}});
    double objective = 0.0;
    double factor = 1.0;
    for (const graph::Term& term : any_.app.objective) {
      const double value = term.metric == graph::Metric::kPeriod
                               ? model::evaluate_period(any_.app.graph, term.path.front(), timings).count()
                               : model::evaluate_chain(any_.app.graph, term.path, any_.costs, timings).response.count();
      objective += term.weight * value;
      if (term.max) factor = std::max(factor, value / to_millis(*term.max).count());
    }
    for (const graph::Node& node : any_.app.graph.nodes()) {
      if (!node.subchain || !node.min_rate || (node.max_rate && *node.min_rate == *node.max_rate)) continue;
      factor = std::max(factor, timings[node.subchain->index()].period / node.min_rate->period());
    }
    if (factor_only_) {
      if (factor < best_.factor) best_ = {true, factor, kInfinity};
    } else if (factor <= best_.factor * (1.0 + kRounding) && objective < best_.objective) {
      best_.objective = objective;
    }
  }

  const RandomCase& any_;
  std::size_t count_;
  const std::vector<model::CostTable> costs_;  // by kind of cores
  std::vector<int> free_;                      // cores, by kind
  std::vector<std::size_t> kind_;              // of cores, by group
  std::vector<int> group_;
  std::vector<Timing> timings_;
  bool factor_only_ = true;
  Best best_;
};

}  // namespace ctn::planner
