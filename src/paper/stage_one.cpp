// Stage I, section 5.1: core allocation under equal shares.
#include "paper/stage_one.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <utility>

namespace ctn::paper {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kRounding = 1e-11;

// Exact rates come before bounds, bounds before the objective. All of them can be had here by relaxing them.
struct Value {
  double exact = kInfinity;   // the factor by which exact rates are missed
  double factor = kInfinity;  // that of bounds
  double objective = kInfinity;

  bool clearly_below(const Value& other) const {
    for (const double Value::*part : {&Value::exact, &Value::factor}) {
      if (this->*part < other.*part * (1.0 - kRounding)) return true;
      if (this->*part > other.*part * (1.0 + kRounding)) return false;
    }
    return objective < other.objective * (1.0 - kRounding);
  }
  bool same_factors(const Value& other) const {
    return exact <= other.exact * (1.0 + kRounding) && factor <= other.factor * (1.0 + kRounding);
  }
};

Timing shared_timing(const Problem& problem, std::size_t subchain, int kind, int rivals) {
  const double equal = rivals * problem.on(subchain, kind).cost / problem.usable;
  const double period = std::max(equal, problem.subchains[subchain].min_period);
  return {period, period};
}

Timing owned_timing(const Problem& problem, std::size_t subchain, int kind, int cores) {
  const std::vector<Owned>& owned = problem.on(subchain, kind).owned;
  return owned[std::min(owned.size(), static_cast<std::size_t>(cores)) - 1].timing;
}

class Bounds {
 public:
  explicit Bounds(const Problem& problem) : problem_(problem) {}
  Value value_of(const std::vector<Timing>& timings) const {
    return {factor_of(problem_.exact, timings), factor_of(problem_.bounds, timings),
            objective_of(problem_.terms, timings)};
  }

 private:
  const Problem& problem_;
};

// ---- What there is to choose, and the Lagrangian bound

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
      linear.coefficients[static_cast<std::size_t>(term.slowest[x])].period += term.weight * multipliers.slowest[t][x];
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

// Multipliers under which the bound is high: a subgradient method. `known`: the objective of some allocation.
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
  double best_bound = -kInfinity;
  constexpr int kRounds = 400;
  for (int round = 0; round < kRounds; ++round) {
    const Linear linear = linear_of(problem, multipliers);
    double bound = linear.constant;
    std::vector<Timing> timings;
    std::vector<double> used(problem.cores.size(), 0.0);
    for (std::size_t i = 0; i < choices.size(); ++i) {
      const auto cheaper = [&](const Choice& a, const Choice& b) {
        return cost_of(a, linear.coefficients[i], multipliers) < cost_of(b, linear.coefficients[i], multipliers);
      };
      const Choice& least = *std::min_element(choices[i].begin(), choices[i].end(), cheaper);
      bound += cost_of(least, linear.coefficients[i], multipliers);
      timings.push_back(least.timing);
      used[static_cast<std::size_t>(least.kind)] += least.usage;
    }
    if (bound > best_bound) {
      best_bound = bound;
      best = multipliers;
    }
    const double shorter = 1.0 / std::sqrt(1.0 + round);
    double square = 0.0;
    for (std::size_t kind = 0; kind < used.size(); ++kind) square += std::pow(used[kind] - problem.cores[kind], 2.0);
    const double step = square > 0.0 ? std::max(0.0, known - bound) / square * shorter : 0.0;
    for (std::size_t kind = 0; kind < used.size(); ++kind) {
      multipliers.core[kind] = std::max(0.0, multipliers.core[kind] + step * (used[kind] - problem.cores[kind]));
    }
    for (std::size_t t = 0; t < problem.terms.size(); ++t) {
      const Metric& term = problem.terms[t];
      const auto period = [&](std::size_t x) {
        return x < term.slowest.size() ? timings[static_cast<std::size_t>(term.slowest[x])].period : term.slowest_fixed;
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

// ---- Local search

// Subchains on cores; a core that somebody has to himself may be lent others of its kind.
struct Cores {
  std::vector<int> core_of;  // by subchain
  std::vector<int> lent;     // by core: how many more its owner has
};

class LocalSearch {
 public:
  LocalSearch(const Problem& problem, std::size_t& steps) : problem_(problem), bounds_(problem), steps_(steps) {
    for (std::size_t kind = 0; kind < problem.cores.size(); ++kind) {
      kind_of_.insert(kind_of_.end(), static_cast<std::size_t>(problem.cores[kind]), static_cast<int>(kind));
    }
  }

  Allocation run() {
    best_ = dealt();
    value_ = value_of(best_);
    while (steps_ > 0 && (move_any() || swap_any() || lend_any())) {
    }
    fill_cores();
    return allocation_of(best_);
  }

 private:
  std::size_t subchains() const { return problem_.subchains.size(); }
  std::size_t cores() const { return kind_of_.size(); }
  static std::size_t index(int number) { return static_cast<std::size_t>(number); }

  // One after the other to the core that has least to do, heavy ones first.
  Cores dealt() const {
    Cores state{std::vector<int>(subchains()), std::vector<int>(cores(), 0)};
    std::vector<std::size_t> order(subchains());
    std::iota(order.begin(), order.end(), 0U);
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return problem_.on(a, 0).cost > problem_.on(b, 0).cost; });
    std::vector<double> busy(cores(), 0.0);
    for (const std::size_t i : order) {
      std::size_t best = 0;
      for (std::size_t core = 1; core < cores(); ++core) {
        if (busy[core] + problem_.on(i, kind_of_[core]).cost < busy[best] + problem_.on(i, kind_of_[best]).cost) {
          best = core;
        }
      }
      state.core_of[i] = static_cast<int>(best);
      busy[best] += problem_.on(i, kind_of_[best]).cost;
    }
    return state;
  }

  std::vector<int> members(const Cores& state) const {
    std::vector<int> count(cores(), 0);
    for (const int core : state.core_of) ++count[index(core)];
    return count;
  }
  // How many cores of the kind nobody has; less than 0: the state cannot be.
  int spare(const Cores& state, const std::vector<int>& count, int kind) const {
    int spare = 0;
    for (std::size_t core = 0; core < cores(); ++core) {
      if (kind_of_[core] == kind) spare += (count[core] == 0 ? 1 : 0) - state.lent[core];
    }
    return spare;
  }

  Value value_of(const Cores& state) {
    if (steps_ > 0) --steps_;
    const std::vector<int> count = members(state);
    for (std::size_t kind = 0; kind < problem_.cores.size(); ++kind) {
      if (spare(state, count, static_cast<int>(kind)) < 0) return {};
    }
    std::vector<Timing> timings(subchains());
    for (std::size_t i = 0; i < subchains(); ++i) {
      const std::size_t core = index(state.core_of[i]);
      if (count[core] > 1 && state.lent[core] > 0) return {};
      timings[i] = count[core] > 1 ? shared_timing(problem_, i, kind_of_[core], count[core])
                                   : owned_timing(problem_, i, kind_of_[core], 1 + state.lent[core]);
    }
    return bounds_.value_of(timings);
  }

  bool take(Cores state) {
    const Value value = value_of(state);
    if (!value.clearly_below(value_)) return false;
    best_ = std::move(state);
    value_ = value;
    return true;
  }

  // To another core; where all are taken, to one that an owner was lent.
  bool move_any() {
    bool better = false;
    for (std::size_t i = 0; i < subchains() && steps_ > 0; ++i) {
      for (std::size_t core = 0; core < cores() && steps_ > 0; ++core) {
        Cores state = best_;
        const std::size_t from = index(state.core_of[i]);
        if (from == core) continue;
        state.core_of[i] = static_cast<int>(core);
        state.lent[from] = 0;
        const int kind = kind_of_[core];
        const std::vector<int> count = members(state);
        for (std::size_t other = 0; other < cores() && spare(state, count, kind) < 0; ++other) {
          if (kind_of_[other] == kind && state.lent[other] > 0) --state.lent[other];
        }
        better = take(std::move(state)) || better;
      }
    }
    return better;
  }

  bool swap_any() {
    bool better = false;
    for (std::size_t i = 0; i < subchains() && steps_ > 0; ++i) {
      for (std::size_t j = i + 1; j < subchains() && steps_ > 0; ++j) {
        if (best_.core_of[i] == best_.core_of[j]) continue;
        Cores state = best_;
        std::swap(state.core_of[i], state.core_of[j]);
        better = take(std::move(state)) || better;
      }
    }
    return better;
  }

  // A core that nobody has, or that another was lent.
  bool lend_any() {
    bool better = false;
    for (std::size_t to = 0; to < cores() && steps_ > 0; ++to) {
      if (Cores state = best_; spare(state, members(state), kind_of_[to]) > 0) {
        ++state.lent[to];
        better = take(std::move(state)) || better;
      }
      for (std::size_t from = 0; from < cores() && steps_ > 0; ++from) {
        if (from == to || kind_of_[from] != kind_of_[to] || best_.lent[from] == 0) continue;
        Cores state = best_;
        --state.lent[from];
        ++state.lent[to];
        better = take(std::move(state)) || better;
      }
    }
    return better;
  }

  // No core is left without a subchain while another of its kind is shared.
  void fill_cores() {
    for (std::vector<int> count = members(best_);; count = members(best_)) {
      std::optional<std::size_t> leaves;
      std::size_t to = 0;
      for (std::size_t core = 0; core < cores(); ++core) {
        if (count[core] > 0 || spare(best_, count, kind_of_[core]) <= 0) continue;
        for (std::size_t i = 0; i < subchains() && !leaves; ++i) {
          const std::size_t at = index(best_.core_of[i]);
          if (count[at] > 1 && kind_of_[at] == kind_of_[core]) leaves = i;
        }
        to = core;
        if (leaves) break;
      }
      if (!leaves) return;
      best_.core_of[*leaves] = static_cast<int>(to);
    }
  }

  Allocation allocation_of(const Cores& state) const {
    const std::vector<int> count = members(state);
    Allocation allocation;
    std::map<int, int> number;
    for (const int core : state.core_of) {
      Place place;
      place.kind = kind_of_[index(core)];
      if (count[index(core)] > 1) {
        place.shared = number.try_emplace(core, static_cast<int>(number.size())).first->second;
      } else {
        place.owned = 1 + state.lent[index(core)];
      }
      allocation.push_back(place);
    }
    return allocation;
  }

  const Problem& problem_;
  const Bounds bounds_;
  std::size_t& steps_;
  std::vector<int> kind_of_;  // by core
  Cores best_;
  Value value_;
};

// ---- Branch and bound

class BranchAndBound {
 public:
  BranchAndBound(const Problem& problem, std::vector<std::vector<Choice>> choices, const Multipliers& multipliers,
                 Value known, std::size_t& steps)
      : problem_(problem),
        bounds_(problem),
        choices_(std::move(choices)),
        best_(known),
        steps_(steps),
        in_class_(problem.cores.size(), std::vector<int>(choices_.size() + 1, 0)),
        owned_(problem.cores.size(), 0) {
    const Linear linear = linear_of(problem, multipliers);
    const std::size_t count = choices_.size();
    std::vector<double> least(count);
    for (std::size_t i = 0; i < count; ++i) {
      const auto cost = [&](const Choice& choice) { return cost_of(choice, linear.coefficients[i], multipliers); };
      std::stable_sort(choices_[i].begin(), choices_[i].end(),
                       [&](const Choice& a, const Choice& b) { return cost(a) < cost(b); });
      costs_.emplace_back();
      for (const Choice& choice : choices_[i]) costs_.back().push_back(cost(choice));
      least[i] = costs_.back().front();
      Timing& timing = timings_.emplace_back(choices_[i].front().timing);
      for (const Choice& choice : choices_[i]) {
        timing.period = std::min(timing.period, choice.timing.period);
        timing.execution = std::min(timing.execution, choice.timing.execution);
      }
      order_.push_back(i);
    }
    // Those first whose choice matters most.
    std::stable_sort(order_.begin(), order_.end(), [&](std::size_t a, std::size_t b) { return least[a] > least[b]; });
    rest_.assign(count + 1, 0.0);
    for (std::size_t at = count; at-- > 0;) rest_[at] = rest_[at + 1] + least[order_[at]];
    chosen_.resize(count);
    root_ = bounds_.value_of(timings_);
    root_.objective = linear.constant + rest_.front();
    descend(0, linear.constant);
  }

  const Value& best() const { return best_; }
  const Value& root() const { return root_; }  // nothing is below
  bool complete() const { return complete_; }
  // None where nothing is better than what was known.
  std::optional<Allocation> allocation() const {
    if (!found_) return std::nullopt;
    Allocation allocation;
    std::map<std::pair<int, int>, std::pair<int, int>> open;  // kind and class: the core, and how many more it takes
    int shared = 0;
    for (std::size_t i = 0; i < choices_.size(); ++i) {
      const Choice& choice = choices_[i][best_choice_[i]];
      Place place{choice.kind, choice.owned, 0};
      if (choice.owned == 0) {
        auto& [core, left] = open[{choice.kind, choice.rivals}];
        if (left == 0) {
          core = shared++;
          left = choice.rivals;
        }
        place.shared = core;
        --left;
      }
      allocation.push_back(place);
    }
    return allocation;
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
    Value bound = bounds_.value_of(timings_);
    bound.objective = std::max(bound.objective, linear + rest_[at]);
    return bound.clearly_below(best_);
  }

  void descend(std::size_t at, double linear) {
    if (at == order_.size()) {
      best_ = bounds_.value_of(timings_);
      best_choice_ = chosen_;
      found_ = true;
      return;
    }
    const std::size_t i = order_[at];
    const Timing before = timings_[i];
    for (std::size_t c = 0; c < choices_[i].size(); ++c) {
      if (steps_ == 0) {
        complete_ = false;
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
  const Bounds bounds_;
  std::vector<std::vector<Choice>> choices_;  // by subchain, the cheapest under the multipliers first
  std::vector<std::vector<double>> costs_;    // theirs
  std::vector<std::size_t> order_;
  std::vector<double> rest_;  // the least that those from a place in the order on add
  std::vector<Timing> timings_;
  std::vector<std::size_t> chosen_;
  std::vector<std::size_t> best_choice_;
  Value best_;
  Value root_;
  bool found_ = false;
  bool complete_ = true;
  std::size_t& steps_;
  std::vector<std::vector<int>> in_class_;  // by kind and m
  std::vector<int> owned_;                  // by kind: cores
};

}  // namespace

std::vector<Timing> equal_shares(const Problem& problem, const Allocation& allocation) {
  std::map<int, int> sharing;
  for (const Place& place : allocation) sharing[place.shared] += place.owned == 0 ? 1 : 0;
  std::vector<Timing> timings;
  for (std::size_t i = 0; i < allocation.size(); ++i) {
    const Place& place = allocation[i];
    timings.push_back(place.owned > 0 ? owned_timing(problem, i, place.kind, place.owned)
                                      : shared_timing(problem, i, place.kind, sharing[place.shared]));
  }
  return timings;
}

namespace {

// Who shares with whom is open under equal shares: those of a class are put together in their order.
Allocation put_together(Allocation allocation) {
  std::map<int, int> sharing;
  for (const Place& place : allocation) sharing[place.shared] += place.owned == 0 ? 1 : 0;
  std::map<std::pair<int, int>, std::pair<int, int>> open;  // kind and class: the core, and how many more it takes
  int shared = 0;
  for (Place& place : allocation) {
    if (place.owned > 0) continue;
    const int rivals = sharing[place.shared];
    auto& [core, left] = open[{place.kind, rivals}];
    if (left == 0) {
      core = shared++;
      left = rivals;
    }
    place.shared = core;
    --left;
  }
  return allocation;
}

}  // namespace

StageOne allocate_cores(const Problem& problem, std::size_t steps) {
  std::vector<std::vector<Choice>> choices;
  for (std::size_t i = 0; i < problem.subchains.size(); ++i) choices.push_back(choices_of(problem, i));
  // A step of local search looks at all subchains.
  std::size_t search = steps / (2 * (1 + problem.subchains.size() / 8));
  StageOne stage;
  stage.allocation = put_together(LocalSearch(problem, search).run());
  const Value found = Bounds(problem).value_of(equal_shares(problem, stage.allocation));
  const Multipliers multipliers = good_multipliers(problem, choices, found.objective);
  // Where there is no hope of a proof, and a step takes long, there are fewer.
  constexpr std::size_t kHopeful = 24;
  const std::size_t count = std::max(kHopeful, problem.subchains.size());
  std::size_t left = steps * kHopeful / count * kHopeful / count;
  const BranchAndBound search_all(problem, std::move(choices), multipliers, found, left);
  if (std::optional<Allocation> better = search_all.allocation()) stage.allocation = std::move(*better);
  stage.factor = search_all.best().factor;
  stage.objective = search_all.best().objective;
  if (!search_all.complete()) {
    // Where a lower factor is not ruled out, nothing is said of the objective.
    const bool least = search_all.best().same_factors(search_all.root());
    const double bound = std::max(0.0, search_all.root().objective);
    stage.gap = !least ? 1.0 : stage.objective > 0.0 ? std::max(0.0, 1.0 - bound / stage.objective) : 0.0;
  }
  return stage;
}

}  // namespace ctn::paper
