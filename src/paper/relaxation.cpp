// Section 5.2: the geometric program for f_i and p_i, without whole numbers or with them given.
#include "paper/relaxation.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "paper/geometric_program.h"

namespace ctn::paper {
namespace {

constexpr double kBoundRounding = 1e-9;
constexpr double kShortestFrame = 1e-6;
// Frames are no longer than so many runs of all members.
constexpr double kMaxRounds = 100.0;

class Formulation {
 public:
  Formulation(const Division& division, const Goal& goal, const std::vector<int>& every)
      : division_(division), problem_(division.problem), goal_(goal), every_(every) {
    periods_.resize(problem_.subchains.size());
    limits_.resize(problem_.subchains.size());
    for (const SharedCore& core : division.cores) add_core(core);
    goal.minimise_factor ? minimise_factor() : minimise_objective();
  }

  std::optional<Relaxed> solved() const {
    if (!possible_) return std::nullopt;
    const std::optional<GeometricSolution> solution = solve(program_, start_);
    if (!solution) return std::nullopt;
    Relaxed relaxed;
    relaxed.periods.assign(problem_.subchains.size(), 0.0);
    for (std::size_t i = 0; i < periods_.size(); ++i) {
      if (division_.core_of[i] >= 0) relaxed.periods[i] = value_of(periods_[i], solution->x);
    }
    for (const Monomial& frame : frames_) relaxed.frames.push_back(value_of(frame, solution->x));
    relaxed.prices = prices(*solution);
    return relaxed;
  }

 private:
  // Which constraint says that a period is no longer than the slowest of its metric.
  struct Slower {
    std::optional<Metric::Slowest> subchain;  // none: the fixed period
    std::size_t constraint = 0;
  };
  // Which constraints limit a period: by a rate cap, by T and by max_every T.
  struct Limits {
    std::optional<std::size_t> cap{};
    std::optional<std::size_t> shortest{};
    std::optional<std::size_t> longest{};
  };
  struct Written {
    const Metric* metric = nullptr;
    std::vector<Slower> slower;           // empty: there is just one
    std::optional<Metric::Slowest> only;  // that one, if it is on a shared core
    double fixed = 0.0;                   // of the periods that are given, the longest
    std::optional<std::size_t> bound;     // the constraint that it is, if it is a bound
  };

  Monomial add_variable(double start) {
    start_.push_back(start);
    return program_.add_variable();
  }
  double at_start(const Posynomial& sum) const {
    double value = 0.0;
    for (const Monomial& monomial : sum) value += value_of(monomial, start_);
    return value;
  }

  // sum <= 1. What depends on no variable holds, or nothing is possible.
  void require(Posynomial sum) {
    if (std::all_of(sum.begin(), sum.end(), [](const Monomial& m) { return m.powers.empty(); })) {
      possible_ = possible_ && at_start(sum) <= 1.0 + kBoundRounding;
      return;
    }
    program_.constraints.push_back(std::move(sum));
  }

  void add_core(const SharedCore& core) {
    const auto given = [&](std::size_t i) -> std::optional<double> {
      if (division_.is_free(i)) return std::nullopt;
      if (!every_.empty()) return every_[i];
      return division_.max_every(i) <= 1.0 ? std::optional(1.0) : std::nullopt;
    };
    const auto any_every = [&](std::size_t i) {
      const double max = division_.max_every(i);
      const Monomial every = add_variable(division_.is_free(i) ? 0.5 * max : std::sqrt(max));
      limits_[i].longest = program_.constraints.size();
      require({1.0 / max * every});
      if (division_.is_free(i)) return every;
      limits_[i].shortest = program_.constraints.size();
      require({every.inverse()});
      return every;
    };
    Monomial frame;
    if (core.exact) {
      const std::optional<double> every = given(*core.exact);
      const Monomial n = every ? *every * Monomial{} : any_every(*core.exact);
      frame = problem_.subchains[*core.exact].exact_period * n.inverse();
    } else {
      frame = add_variable(0.9 * core.longest_frame);
      require({1.0 / core.longest_frame * frame});
      require({kShortestFrame * frame.inverse()});
    }
    Posynomial busy;
    for (const std::size_t i : core.members) {
      const Subchain& subchain = problem_.subchains[i];
      if (division_.is_exact(i)) {
        periods_[i] = subchain.exact_period * Monomial{};
        if (core.exact != i) {
          const Monomial every = periods_[i] * frame.inverse();
          require({1.0 / division_.max_every(i) * every});
          if (!division_.is_free(i)) require({every.inverse()});
        }
      } else {
        const std::optional<double> every = given(i);
        periods_[i] = frame * (every ? *every * Monomial{} : any_every(i));
        if (subchain.min_period > 0.0) {
          const std::size_t before = program_.constraints.size();
          require({subchain.min_period * periods_[i].inverse()});
          if (program_.constraints.size() > before) limits_[i].cap = before;
        }
      }
      if (division_.cost(i) > 0.0) busy.push_back(division_.cost(i) / problem_.usable * periods_[i].inverse());
    }
    if (!busy.empty()) require(std::move(busy));
    frames_.push_back(std::move(frame));
  }

  // Table 1. What is longest becomes a variable that nothing it is the longest of exceeds.
  Posynomial posynomial(const Metric& metric, Written& written) {
    written.metric = &metric;
    Posynomial sum;
    double constant = metric.constant;
    for (const Metric::Part& part : metric.latency) {
      const auto i = static_cast<std::size_t>(part.subchain);
      if (division_.core_of[i] < 0) {
        constant += part.periods * division_.timings[i].period + part.executions * division_.timings[i].execution;
      } else {
        sum.push_back((part.periods + part.executions) * periods_[i]);
      }
    }
    std::vector<Metric::Slowest> shared;
    written.fixed = metric.slowest_fixed;
    for (const Metric::Slowest& each : metric.slowest) {
      const auto i = static_cast<std::size_t>(each.subchain);
      if (division_.core_of[i] >= 0) {
        shared.push_back(each);
      } else {
        written.fixed = std::max(written.fixed, each.runs * division_.timings[i].period);
      }
    }
    if (shared.empty()) {
      constant += written.fixed;
    } else if (shared.size() == 1 && written.fixed <= 0.0) {
      written.only = shared.front();
      sum.push_back(outputs_apart(shared.front()));
    } else {
      add_slowest(shared, written, sum);
    }
    if (constant > 0.0) sum.push_back(constant * Monomial{});
    return sum;
  }

  Monomial outputs_apart(const Metric::Slowest& of) const {
    return of.runs * periods_[static_cast<std::size_t>(of.subchain)];
  }

  void add_slowest(const std::vector<Metric::Slowest>& shared, Written& written, Posynomial& sum) {
    double longest = written.fixed;
    for (const Metric::Slowest& each : shared) longest = std::max(longest, value_of(outputs_apart(each), start_));
    const Monomial slowest = add_variable(1.5 * longest);
    const Monomial per = slowest.inverse();
    for (const Metric::Slowest& each : shared) {
      written.slower.push_back({each, program_.constraints.size()});
      program_.constraints.push_back({outputs_apart(each) * per});
    }
    if (written.fixed > 0.0) {
      written.slower.push_back({std::nullopt, program_.constraints.size()});
      program_.constraints.push_back({written.fixed * per});
    }
    sum.push_back(slowest);
  }

  void minimise_objective() {
    for (const Metric& term : problem_.terms) {
      if (term.weight <= 0.0) continue;
      for (Monomial& monomial : posynomial(term, terms_.emplace_back())) {
        program_.objective.push_back(term.weight * std::move(monomial));
      }
    }
    if (program_.objective.empty()) program_.objective.emplace_back();
    if (!std::isfinite(goal_.factor)) return;
    for (const Metric& bound : problem_.bounds) add_bound(bound, 1.0 / goal_.factor * Monomial{});
  }

  void minimise_factor() {
    double largest = 1.0;
    std::vector<std::pair<const Metric*, Posynomial>> bounds;
    const Monomial factor = add_variable(1.0);
    const std::size_t index = start_.size() - 1;
    for (const Metric& bound : problem_.bounds) {
      add_bound(bound, factor.inverse());
      if (bounds_.back().bound) {
        Posynomial& sum = program_.constraints[*bounds_.back().bound];
        largest = std::max(largest, at_start(sum));
      }
    }
    start_[index] = 1.5 * largest;
    require({factor.inverse()});
    program_.objective = {factor};
  }

  void add_bound(const Metric& bound, const Monomial& relaxed) {
    Written& written = bounds_.emplace_back();
    Posynomial sum = posynomial(bound, written);
    for (Monomial& monomial : sum) monomial = 1.0 / bound.asked * std::move(monomial) * relaxed;
    if (sum.empty()) return;
    const std::size_t before = program_.constraints.size();
    require(std::move(sum));
    if (program_.constraints.size() > before) written.bound = before;
  }

  // Adds weight x the metric, from below.
  void add(const Written& written, double weight, const std::vector<double>& duals, Prices& prices) const {
    const Metric& metric = *written.metric;
    prices.constant += weight * metric.constant;
    for (const Metric::Part& part : metric.latency) {
      const auto i = static_cast<std::size_t>(part.subchain);
      const Timing& given = division_.timings[i];
      if (division_.core_of[i] < 0) {
        prices.constant += weight * (part.periods * given.period + part.executions * given.execution);
      } else {
        prices.of[i] += weight * (part.periods + part.executions);
      }
    }
    if (written.only) {
      prices.of[static_cast<std::size_t>(written.only->subchain)] += weight * written.only->runs;
    } else if (written.slower.empty()) {
      prices.constant += weight * written.fixed;
    }
    double sum = 0.0;
    for (const Slower& slower : written.slower) sum += duals[slower.constraint];
    for (const Slower& slower : written.slower) {
      const double part = sum > 0.0 ? duals[slower.constraint] / sum : 1.0 / static_cast<double>(written.slower.size());
      if (slower.subchain) {
        prices.of[static_cast<std::size_t>(slower.subchain->subchain)] += weight * part * slower.subchain->runs;
      } else {
        prices.constant += weight * part * written.fixed;
      }
    }
  }

  Prices::Open open(std::size_t i, double price, const GeometricSolution& solution) const {
    const double period = value_of(periods_[i], solution.x);
    // In time: what a bound is worth that p meets just so.
    const auto worth = [&](const std::optional<std::size_t>& constraint) {
      return constraint ? solution.duals[*constraint] * solution.value / period : 0.0;
    };
    const double longest = worth(limits_[i].longest);
    const double cap = std::min(worth(limits_[i].cap), price + longest);
    const double shortest = std::min(worth(limits_[i].shortest), price + longest - cap);
    return {std::max(0.0, price - cap - shortest + longest), shortest - division_.max_every(i) * longest,
            cap * problem_.subchains[i].min_period};
  }

  // Whatever the duals are, what this returns bounds the goal: they only make it a good bound.
  Prices prices(const GeometricSolution& solution) const {
    Prices prices{0.0, std::vector<double>(problem_.subchains.size(), 0.0),
                  std::vector<Prices::Open>(problem_.subchains.size())};
    for (const Written& term : terms_) add(term, term.metric->weight, solution.duals, prices);
    double sum = 0.0;
    for (const Written& bound : bounds_) sum += bound.bound ? solution.duals[*bound.bound] : 0.0;
    for (const Written& bound : bounds_) {
      if (!bound.bound) continue;
      const double dual = solution.duals[*bound.bound];
      if (goal_.minimise_factor) {
        add(bound, dual / std::max(1.0, sum) / bound.metric->asked, solution.duals, prices);
      } else {
        const double asked = bound.metric->asked * goal_.factor;
        const double weight = dual * solution.value / asked;
        add(bound, weight, solution.duals, prices);
        prices.constant -= weight * asked;
      }
    }
    if (goal_.minimise_factor) prices.constant += std::max(0.0, 1.0 - sum);
    for (std::size_t i = 0; i < limits_.size(); ++i) {
      if (division_.core_of[i] >= 0 && !division_.is_exact(i)) prices.open[i] = open(i, prices.of[i], solution);
    }
    return prices;
  }

  const Division& division_;
  const Problem& problem_;
  const Goal& goal_;
  const std::vector<int>& every_;
  GeometricProgram program_;
  std::vector<double> start_;
  bool possible_ = true;
  std::vector<Monomial> periods_;  // by subchain
  std::vector<Monomial> frames_;   // by shared core
  std::vector<Written> terms_;
  std::vector<Written> bounds_;
  std::vector<Limits> limits_;  // by subchain
};

}  // namespace

Division divide(const Problem& problem, const Allocation& allocation) {
  Division division{problem, {}, {}, {}};
  for (std::size_t i = 0; i < allocation.size(); ++i) {
    const Place& place = allocation[i];
    Timing timing;
    if (place.owned > 0) {
      const std::vector<Owned>& owned = problem.on(i, place.kind).owned;
      timing = owned[std::min(owned.size(), static_cast<std::size_t>(place.owned)) - 1].timing;
    } else {
      const auto number = static_cast<std::size_t>(place.shared);
      if (division.cores.size() <= number) division.cores.resize(number + 1);
      division.cores[number].kind = place.kind;
      division.cores[number].members.push_back(i);
    }
    division.core_of.push_back(place.owned > 0 ? -1 : place.shared);
    division.timings.push_back(timing);
  }
  for (SharedCore& core : division.cores) {
    double round = 0.0;
    double longest_cap = 0.0;
    for (const std::size_t i : core.members) {
      round += division.cost(i) / problem.usable;
      longest_cap = std::max(longest_cap, problem.subchains[i].min_period);
      if (!core.exact && division.is_exact(i) && !division.is_free(i)) core.exact = i;
    }
    core.longest_frame = std::max({kMaxRounds * round, 2.0 * longest_cap, 1.0});
  }
  return division;
}

std::optional<Relaxed> relax(const Division& division, const Goal& goal, const std::vector<int>& every) {
  return Formulation(division, goal, every).solved();
}

}  // namespace ctn::paper
