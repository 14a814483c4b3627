#include "baselines/verucchi.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <optional>
#include <set>
#include <tuple>
#include <utility>
#include <vector>

#include "base/numbers.h"
#include "baselines/rate_graphs.h"

namespace ctn::baselines {
namespace {

constexpr int kMaxDoublings = 8;
constexpr std::size_t kMaxCombinations = 2'000'000;
constexpr std::size_t kDefaultEffort = 4'000'000;

class Verucchi {
 public:
  Verucchi(const graph::App& app, const model::CostTable& costs, const RateRequest& request)
      : app_(app),
        graphs_(app, costs, request),
        cores_(request.cores),
        effort_(request.effort > 0 ? request.effort : kDefaultEffort),
        count_(app.graph.subchains().size()) {}

  std::optional<RateGraph> run() {
    descend(first());
    enumerate();
    if (best_.value.objective == kInfinity) return std::nullopt;
    return best_;
  }

  bool exhaustive() const { return exhaustive_; }

 private:
  bool hopeless(const RateValue& lowest) const {
    if (lowest.factor > best_.value.factor * (1.0 + 1e-9)) return true;
    return best_.value.factor <= 1.0 && lowest.objective >= best_.value.objective;
  }

  // Keeps the best graph of a candidate if it is the best so far.
  void look_at(const RateCandidate& at) {
    const double base = graphs_.base_of(at);
    if (hopeless(graphs_.min_value(at, base))) return;
    std::optional<RateGraph> here = graphs_.best(at, base);
    if (!here || !here->value.better_than(best_.value)) return;
    best_ = *std::move(here);
    best_at_ = at;
  }

  // Rates as the weights suggest, cores by load.
  RateCandidate first() const {
    std::vector<double> wish(count_);
    for (std::size_t i = 0; i < count_; ++i) {
      const plan::PeriodLimits& limits = graphs_.limits(i);
      wish[i] = limits.exact
                    ? limits.exact->count()
                    : std::max(limits.min.count(), std::sqrt(graphs_.cost(i, 0) / std::max(graphs_.weight(i), 1e-9)));
    }
    // Exact rates are what the others are measured by.
    double unit = *std::min_element(wish.begin(), wish.end());
    for (std::size_t i = count_; i-- > 0;) {
      if (graphs_.limits(i).exact) unit = wish[i];
    }
    RateCandidate made;
    for (std::size_t i = 0; i < count_; ++i) {
      made.doublings.push_back(static_cast<int>(std::clamp(std::lround(std::log2(wish[i] / unit)), -8L, 8L)));
    }
    normalise(made);
    std::vector<std::size_t> order(count_);
    std::iota(order.begin(), order.end(), std::size_t{0});
    const auto load = [&](std::size_t i) { return graphs_.cost(i, 0) / std::ldexp(1.0, made.doublings[i]); };
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return load(a) > load(b); });
    std::vector<double> loads(static_cast<std::size_t>(cores_), 0.0);
    made.core.assign(count_, 0);
    for (const std::size_t i : order) {
      const auto lightest = std::min_element(loads.begin(), loads.end());
      made.core[i] = static_cast<int>(lightest - loads.begin());
      *lightest += load(i);
    }
    return made;
  }

  // The fastest has no doublings, the slowest no more than there may be.
  static void normalise(RateCandidate& at) {
    const int lowest = *std::min_element(at.doublings.begin(), at.doublings.end());
    for (int& doublings : at.doublings) doublings = std::min(doublings - lowest, kMaxDoublings);
  }

  // How good a candidate is to climb from, where none has been found that can be scheduled.
  double excess(const RateCandidate& at) const {
    double exact = kInfinity;
    double base = 0.0;
    std::vector<double> load(static_cast<std::size_t>(cores_), 0.0);
    for (std::size_t i = 0; i < count_; ++i) {
      const double by = std::ldexp(1.0, at.doublings[i]);
      load[static_cast<std::size_t>(at.core[i])] += graphs_.cost(i, at.core[i]) / by;
      if (graphs_.limits(i).exact)
        exact = std::min(exact, graphs_.limits(i).exact->count() / by);
      else
        base = std::max(base, graphs_.limits(i).min.count() / by);
    }
    return std::max(base, *std::max_element(load.begin(), load.end())) / exact;
  }

  void descend(RateCandidate from) {
    const std::size_t until = effort_ / 2;
    // Slow down what is not exact until exact rates can be met.
    for (int tries = 0; graphs_.base_of(from) == kInfinity && tries < 4 * kMaxDoublings * static_cast<int>(count_);
         ++tries) {
      RateCandidate next = from;
      for (const RateCandidate& other : neighbours(from)) {
        if (excess(other) < excess(next)) next = other;
      }
      if (excess(next) >= excess(from)) break;
      from = next;
    }
    best_at_ = from;
    look_at(from);
    for (bool better = true; better && graphs_.spent() < until;) {
      better = false;
      const double before = best_.value.objective;
      const double factor = best_.value.factor;
      for (const RateCandidate& other : neighbours(best_at_)) {
        if (graphs_.spent() >= until) break;
        look_at(other);
      }
      better = best_.value.objective < before || best_.value.factor < factor;
    }
    exhaustive_ = false;
  }

  // One task faster or slower by two, or all faster than it; one on another core; two that swap.
  std::vector<RateCandidate> neighbours(const RateCandidate& at) const {
    std::vector<RateCandidate> made;
    for (std::size_t i = 0; i < count_; ++i) {
      for (const int by : {-1, 1}) {
        RateCandidate other = at;
        other.doublings[i] += by;
        normalise(other);
        if (other.doublings != at.doublings) made.push_back(other);
        other = at;
        for (std::size_t j = 0; j < count_; ++j) {
          if (at.doublings[j] <= at.doublings[i]) other.doublings[j] += by;
        }
        normalise(other);
        if (other.doublings != at.doublings) made.push_back(other);
      }
    }
    const std::vector<bool> used = used_cores(at);
    for (std::size_t i = 0; i < count_; ++i) {
      bool free_seen = false;
      for (int core = 0; core < cores_; ++core) {
        const bool free = !used[static_cast<std::size_t>(core)];
        if (core == at.core[i] || (free && free_seen && app_.kinds() == 1)) continue;
        free_seen = free_seen || free;
        RateCandidate other = at;
        other.core[i] = core;
        made.push_back(std::move(other));
      }
      for (std::size_t j = i + 1; j < count_; ++j) {
        if (at.core[i] == at.core[j]) continue;
        RateCandidate other = at;
        std::swap(other.core[i], other.core[j]);
        made.push_back(std::move(other));
      }
    }
    return made;
  }

  std::vector<bool> used_cores(const RateCandidate& at) const {
    std::vector<bool> used(static_cast<std::size_t>(cores_), false);
    for (const int core : at.core) used[static_cast<std::size_t>(core)] = true;
    return used;
  }

  // All combinations, the best lower bounds first; none where there are too many.
  void enumerate() {
    double combinations = std::pow(kMaxDoublings + 1.0, static_cast<double>(count_));
    const auto as_many = static_cast<double>(kMaxCombinations);
    if (combinations > as_many) return;
    std::vector<std::vector<int>> placements;
    std::vector<int> core(count_, 0);
    place(core, 0, static_cast<std::size_t>(as_many / combinations), placements);
    if (static_cast<double>(placements.size()) * combinations > as_many) return;
    struct Entry {
      RateValue lowest;
      std::uint32_t placement;
      std::uint32_t rates;
    };
    std::vector<Entry> entries;
    RateCandidate at;
    at.doublings.assign(count_, 0);
    for (std::uint32_t placement = 0; placement < placements.size(); ++placement) {
      at.core = placements[placement];
      for (std::uint32_t rates = 0; rates < static_cast<std::uint32_t>(combinations); ++rates) {
        if (!unpack(rates, at.doublings)) continue;
        const RateValue lowest = graphs_.min_value(at, graphs_.base_of(at));
        if (lowest.objective < kInfinity && !hopeless(lowest)) entries.push_back({lowest, placement, rates});
      }
    }
    std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
      return std::tuple(a.lowest.factor, a.lowest.objective, a.placement, a.rates) <
             std::tuple(b.lowest.factor, b.lowest.objective, b.placement, b.rates);
    });
    exhaustive_ = true;
    for (const Entry& entry : entries) {
      if (hopeless(entry.lowest)) continue;
      if (graphs_.spent() >= effort_) {
        exhaustive_ = false;
        return;
      }
      at.core = placements[entry.placement];
      unpack(entry.rates, at.doublings);
      look_at(at);
    }
  }

  // False where no task has the base period: another combination is the same.
  bool unpack(std::uint32_t rates, std::vector<int>& doublings) const {
    for (int& of : doublings) {
      of = static_cast<int>(rates % (kMaxDoublings + 1));
      rates /= kMaxDoublings + 1;
    }
    return *std::min_element(doublings.begin(), doublings.end()) == 0;
  }

  // Every way to put subchains on cores, where cores of a kind are told apart only by the subchains on them; stops
  // beyond `max`.
  void place(std::vector<int>& core, std::size_t i, std::size_t max, std::vector<std::vector<int>>& placements) const {
    if (placements.size() > max) return;
    if (i == count_) {
      placements.push_back(core);
      return;
    }
    std::set<std::size_t> empty_of_kind;
    for (int candidate = 0; candidate < cores_; ++candidate) {
      const auto end = core.begin() + static_cast<std::ptrdiff_t>(i);
      const bool empty = std::find(core.begin(), end, candidate) == end;
      if (empty && !empty_of_kind.insert(app_.kind_of(candidate)).second) continue;
      core[i] = candidate;
      place(core, i + 1, max, placements);
    }
  }

  const graph::App& app_;
  RateGraphs graphs_;
  const int cores_;
  const std::size_t effort_;
  const std::size_t count_;
  RateCandidate best_at_;
  RateGraph best_;
  bool exhaustive_ = false;
};

}  // namespace

Result<RatePlan> plan_by_verucchi(const graph::App& app, const model::CostTable& costs, const RateRequest& request) {
  if (const Status fine = check_request(app, request); !fine) return fine.error();
  Verucchi search(app, costs, request);
  const std::optional<RateGraph> found = search.run();
  if (!found) {
    return Error(
        ErrorKind::kCaller,
        {Problem{{},
                 "nodes",
                 fmt::format("no rates found that are powers of two apart, keep the exact rates, and leave all "
                             "runs on {} cores time to end within their periods",
                             request.cores),
                 "give it more cores, lower the exact rates, or make them powers of two apart"}});
  }
  RatePlan plan;
  plan.planner = "verucchi";
  plan.exhaustive = search.exhaustive();
  plan.slack = request.slack;
  plan.hyperperiod = Millis{found->base * found->schedule.hyperperiod};
  for (std::size_t i = 0; i < found->tasks.size(); ++i) {
    const DagTask& task = found->tasks[i];
    double response = 0.0;
    for (std::size_t k = 0; k < found->schedule.runs[i].size(); ++k) {
      response = std::max(response, found->schedule.runs[i][k].end - static_cast<double>(k) * task.every);
    }
    plan.subchains.push_back(
        {task.core, Millis{found->base * task.every}, Millis{found->base * response}, task.priority});
  }
  for (const DagEdge& edge : found->edges) {
    plan.precedences.push_back({SubchainId(static_cast<std::size_t>(edge.from)),
                                SubchainId(static_cast<std::size_t>(edge.to)), Millis{found->base * edge.delay}});
  }
  fill_figures(plan, app, costs, request.cores, found->chains);
  return plan;
}

}  // namespace ctn::baselines
