// Stage I, section 5.1: core allocation under equal shares.
#include "paper/stage_one.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "base/numbers.h"
#include "paper/equal_shares.h"
#include "paper/local_search.h"

namespace ctn::paper {
namespace {

// A class that a subchain may be in.
struct Choice {
  Timing timing;
  int kind = 0;
  int owned = 0;       // cores of its own; 0: it shares one
  int rivals = 1;      // how many share the core, itself included
  double usage = 1.0;  // of cores
};

std::vector<Choice> choices_of(const Problem& problem, std::size_t subchain) {
  std::vector<Choice> choices;
  const int count = static_cast<int>(problem.subchains.size());
  for (int kind = 0; kind < static_cast<int>(problem.cores.size()); ++kind) {
    const int cores = problem.cores[static_cast<std::size_t>(kind)];
    const int of_use = static_cast<int>(problem.on(subchain, kind).owned.size());
    for (int k = 1; k <= of_use; ++k) {
      choices.push_back({owned_timing(problem, subchain, kind, k), kind, k, 1, static_cast<double>(k)});
    }
    for (int m = 2; cores > 0 && m <= count; ++m) {
      choices.push_back({shared_timing(problem, subchain, kind, m), kind, 0, m, 1.0 / m});
    }
  }
  return choices;
}

// The objective from below: the slowest period of a term is at least any average of those it is the longest of, and a
// core more or less than there are changes it by the core's price. Then every subchain chooses by itself.
struct Multipliers {
  std::vector<std::vector<double>> slowest;  // by term: weights of its slowest subchains and, last, of the fixed period
  std::vector<double> core;                  // by kind
};

struct Linear {
  double constant = 0.0;
  std::vector<Timing> coefficients;  // of p and L, by subchain
};

Linear linear_of(const Problem& problem, const Multipliers& multipliers) {
  Linear linear;
  linear.coefficients.resize(problem.subchains.size());
  for (std::size_t t = 0; t < problem.terms.size(); ++t) {
    const Metric& term = problem.terms[t];
    linear.constant += term.weight * (term.constant + multipliers.slowest[t].back() * term.slowest_fixed);
    for (const Metric::Part& part : term.latency) {
      Timing& coefficient = linear.coefficients[static_cast<std::size_t>(part.subchain)];
      coefficient.period += term.weight * part.periods;
      coefficient.execution += term.weight * part.executions;
    }
    for (std::size_t x = 0; x < term.slowest.size(); ++x) {
      linear.coefficients[static_cast<std::size_t>(term.slowest[x].subchain)].period +=
          term.weight * multipliers.slowest[t][x] * term.slowest[x].runs;
    }
  }
  for (std::size_t kind = 0; kind < multipliers.core.size(); ++kind) {
    linear.constant -= multipliers.core[kind] * problem.cores[kind];
  }
  return linear;
}

double cost_of(const Choice& choice, const Timing& coefficient, const Multipliers& multipliers) {
  return coefficient.period * choice.timing.period + coefficient.execution * choice.timing.execution +
         multipliers.core[static_cast<std::size_t>(choice.kind)] * choice.usage;
}

// Multipliers under which the lower bound is high: a subgradient method. `known`: the objective of some allocation.
Multipliers good_multipliers(const Problem& problem, const std::vector<std::vector<Choice>>& choices, double known) {
  Multipliers multipliers;
  multipliers.core.assign(problem.cores.size(), 0.0);
  for (const Metric& term : problem.terms) {
    const std::size_t of = term.slowest.size();
    multipliers.slowest.emplace_back(of + 1, of > 0 ? 1.0 / static_cast<double>(of) : 1.0);
    if (of > 0) multipliers.slowest.back().back() = 0.0;
    if (of > 0 && term.slowest_fixed > 0.0) {
      multipliers.slowest.back().assign(of + 1, 1.0 / static_cast<double>(of + 1));
    }
  }
  Multipliers best = multipliers;
  double best_lower_bound = -kInfinity;
  constexpr int kRounds = 400;
  for (int round = 0; round < kRounds; ++round) {
    const Linear linear = linear_of(problem, multipliers);
    double lower_bound = linear.constant;
    std::vector<Timing> timings;
    std::vector<double> used(problem.cores.size(), 0.0);
    for (std::size_t i = 0; i < choices.size(); ++i) {
      const auto cheaper = [&](const Choice& a, const Choice& b) {
        return cost_of(a, linear.coefficients[i], multipliers) < cost_of(b, linear.coefficients[i], multipliers);
      };
      const Choice& cheapest = *std::min_element(choices[i].begin(), choices[i].end(), cheaper);
      lower_bound += cost_of(cheapest, linear.coefficients[i], multipliers);
      timings.push_back(cheapest.timing);
      used[static_cast<std::size_t>(cheapest.kind)] += cheapest.usage;
    }
    if (lower_bound > best_lower_bound) {
      best_lower_bound = lower_bound;
      best = multipliers;
    }
    const double shorter = 1.0 / std::sqrt(1.0 + round);
    double square = 0.0;
    for (std::size_t kind = 0; kind < used.size(); ++kind) square += std::pow(used[kind] - problem.cores[kind], 2.0);
    const double step = square > 0.0 ? std::max(0.0, known - lower_bound) / square * shorter : 0.0;
    for (std::size_t kind = 0; kind < used.size(); ++kind) {
      multipliers.core[kind] = std::max(0.0, multipliers.core[kind] + step * (used[kind] - problem.cores[kind]));
    }
    for (std::size_t t = 0; t < problem.terms.size(); ++t) {
      const Metric& term = problem.terms[t];
      const auto period = [&](std::size_t x) {
        if (x == term.slowest.size()) return term.slowest_fixed;
        const Metric::Slowest& slowest = term.slowest[x];
        return slowest.runs * timings[static_cast<std::size_t>(slowest.subchain)].period;
      };
      double longest = 0.0;
      for (std::size_t x = 0; x <= term.slowest.size(); ++x) longest = std::max(longest, period(x));
      if (longest <= 0.0) continue;
      double sum = 0.0;
      for (std::size_t x = 0; x <= term.slowest.size(); ++x) {
        multipliers.slowest[t][x] *= std::exp(shorter * (period(x) / longest - 1.0));
        sum += multipliers.slowest[t][x];
      }
      for (double& weight : multipliers.slowest[t]) weight /= sum;
    }
  }
  return best;
}

// Which subchains share a core is open under equal shares: those of a class are put together in their order. `rivals`:
// how many share a core, by subchain.
Allocation put_together(Allocation allocation, const std::vector<int>& rivals) {
  std::map<std::pair<int, int>, std::pair<int, int>> open;  // kind and class: the core, and how many more it takes
  int shared = 0;
  for (std::size_t i = 0; i < allocation.size(); ++i) {
    Place& place = allocation[i];
    if (place.owned > 0) continue;
    auto& [core, left] = open[{place.kind, rivals[i]}];
    if (left == 0) {
      core = shared++;
      left = rivals[i];
    }
    place.shared = core;
    --left;
  }
  return allocation;
}

std::vector<int> rivals_in(const Allocation& allocation) {
  std::map<int, int> sharing;
  for (const Place& place : allocation) sharing[place.shared] += place.owned == 0 ? 1 : 0;
  std::vector<int> rivals;
  for (const Place& place : allocation) rivals.push_back(place.owned > 0 ? 1 : sharing[place.shared]);
  return rivals;
}

class BranchAndBound {
 public:
  BranchAndBound(const Problem& problem, std::vector<std::vector<Choice>> choices, const Multipliers& multipliers,
                 EqualShares known, std::size_t& steps)
      : problem_(problem),
        choices_(std::move(choices)),
        best_(known),
        steps_(steps),
        in_class_(problem.cores.size(), std::vector<int>(choices_.size() + 1, 0)),
        owned_(problem.cores.size(), 0) {
    const Linear linear = linear_of(problem, multipliers);
    const std::size_t count = choices_.size();
    std::vector<double> cheapest(count);
    for (std::size_t i = 0; i < count; ++i) {
      const auto cost = [&](const Choice& choice) { return cost_of(choice, linear.coefficients[i], multipliers); };
      std::stable_sort(choices_[i].begin(), choices_[i].end(),
                       [&](const Choice& a, const Choice& b) { return cost(a) < cost(b); });
      costs_.emplace_back();
      for (const Choice& choice : choices_[i]) costs_.back().push_back(cost(choice));
      cheapest[i] = costs_.back().front();
      Timing& timing = timings_.emplace_back(choices_[i].front().timing);
      for (const Choice& choice : choices_[i]) {
        timing.period = std::min(timing.period, choice.timing.period);
        timing.execution = std::min(timing.execution, choice.timing.execution);
      }
      order_.push_back(i);
    }
    // Those first whose choice matters most.
    std::stable_sort(order_.begin(), order_.end(),
                     [&](std::size_t a, std::size_t b) { return cheapest[a] > cheapest[b]; });
    rest_.assign(count + 1, 0.0);
    for (std::size_t at = count; at-- > 0;) rest_[at] = rest_[at + 1] + cheapest[order_[at]];
    chosen_.resize(count);
    root_ = value_of(problem_, timings_);
    root_.objective = linear.constant + rest_.front();
    descend(0, linear.constant);
  }

  const EqualShares& best() const { return best_; }
  const EqualShares& root() const { return root_; }  // nothing is below
  // It did not run out of steps: each allocation was tried or ruled out.
  bool exhaustive() const { return exhaustive_; }
  // None where nothing is better than what was known.
  std::optional<Allocation> allocation() const {
    if (!found_) return std::nullopt;
    Allocation classes;
    std::vector<int> rivals;
    for (std::size_t i = 0; i < choices_.size(); ++i) {
      const Choice& choice = choices_[i][best_choice_[i]];
      classes.push_back({choice.kind, choice.owned, 0});
      rivals.push_back(choice.rivals);
    }
    return put_together(std::move(classes), rivals);
  }

 private:
  void count(const Choice& choice, int sign) {
    const auto kind = static_cast<std::size_t>(choice.kind);
    if (choice.owned > 0) {
      owned_[kind] += sign * choice.owned;
    } else {
      in_class_[kind][static_cast<std::size_t>(choice.rivals)] += sign;
    }
  }

  // There are cores for all classes begun, and subchains left to fill them. At the end: no core without a subchain.
  bool can_be(std::size_t left) const {
    std::size_t missing = 0;
    for (std::size_t kind = 0; kind < in_class_.size(); ++kind) {
      int cores = owned_[kind];
      bool shares = false;
      for (std::size_t m = 2; m < in_class_[kind].size(); ++m) {
        const auto in = static_cast<std::size_t>(in_class_[kind][m]);
        cores += static_cast<int>((in + m - 1) / m);
        missing += (m - in % m) % m;
        shares = shares || in > 0;
      }
      if (cores > problem_.cores[kind] || (left == 0 && shares && cores < problem_.cores[kind])) return false;
    }
    return missing <= left;
  }

  // The rest at their shortest, or as the multipliers say: nothing that follows is better than the worse of both.
  bool may_be_better(std::size_t at, double linear) const {
    EqualShares lower_bound = value_of(problem_, timings_);
    lower_bound.objective = std::max(lower_bound.objective, linear + rest_[at]);
    return lower_bound.clearly_below(best_);
  }

  void descend(std::size_t at, double linear) {
    if (at == order_.size()) {
      best_ = value_of(problem_, timings_);
      best_choice_ = chosen_;
      found_ = true;
      return;
    }
    const std::size_t i = order_[at];
    const Timing before = timings_[i];
    for (std::size_t c = 0; c < choices_[i].size(); ++c) {
      if (steps_ == 0) {
        exhaustive_ = false;
        break;
      }
      --steps_;
      const Choice& choice = choices_[i][c];
      count(choice, 1);
      timings_[i] = choice.timing;
      chosen_[i] = c;
      const double so_far = linear + costs_[i][c];
      if (can_be(order_.size() - at - 1) && may_be_better(at + 1, so_far)) descend(at + 1, so_far);
      count(choice, -1);
    }
    timings_[i] = before;
  }

  const Problem& problem_;
  std::vector<std::vector<Choice>> choices_;  // by subchain, the cheapest under the multipliers first
  std::vector<std::vector<double>> costs_;    // theirs
  std::vector<std::size_t> order_;
  std::vector<double> rest_;  // the least that those from a place in the order on add
  std::vector<Timing> timings_;
  std::vector<std::size_t> chosen_;
  std::vector<std::size_t> best_choice_;
  EqualShares best_;
  EqualShares root_;
  bool found_ = false;
  bool exhaustive_ = true;
  std::size_t& steps_;
  std::vector<std::vector<int>> in_class_;  // by kind and m
  std::vector<int> owned_;                  // by kind: cores
};

}  // namespace

StageOne allocate_cores(const Problem& problem, std::size_t steps) {
  std::vector<std::vector<Choice>> choices;
  for (std::size_t i = 0; i < problem.subchains.size(); ++i) choices.push_back(choices_of(problem, i));
  // A step of local search looks at all subchains.
  const std::size_t search = steps / (2 * (1 + problem.subchains.size() / 8));
  StageOne stage;
  Allocation first = search_locally(problem, search);
  const std::vector<int> rivals = rivals_in(first);
  stage.allocation = put_together(std::move(first), rivals);
  const EqualShares found = value_of(problem, equal_shares(problem, stage.allocation));
  const Multipliers multipliers = good_multipliers(problem, choices, found.objective);
  // Where there is no hope of a proof, and a step takes long, there are fewer.
  constexpr std::size_t kHopeful = 24;
  const std::size_t count = std::max(kHopeful, problem.subchains.size());
  std::size_t left = steps * kHopeful / count * kHopeful / count;
  const BranchAndBound search_all(problem, std::move(choices), multipliers, found, left);
  if (std::optional<Allocation> better = search_all.allocation()) stage.allocation = std::move(*better);
  stage.factor = search_all.best().factor;
  stage.objective = search_all.best().objective;
  if (!search_all.exhaustive()) {
    // Where a lower factor is not ruled out, nothing is said of the objective.
    const bool best_is_root = search_all.best().same_factors(search_all.root());
    const double lower_bound = std::max(0.0, search_all.root().objective);
    stage.gap = !best_is_root ? 1.0 : stage.objective > 0.0 ? std::max(0.0, 1.0 - lower_bound / stage.objective) : 0.0;
  }
  return stage;
}

}  // namespace ctn::paper
