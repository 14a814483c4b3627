#include "baselines/period_program.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <Eigen/Dense>

#include "base/numbers.h"

namespace ctn::baselines {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// A value with its first and second derivatives in the variables.
struct Jet {
  double value = 0.0;
  VectorXd gradient;
  MatrixXd hessian;

  explicit Jet(Eigen::Index variables)
      : gradient(VectorXd::Zero(variables)), hessian(MatrixXd::Zero(variables, variables)) {}

  // Adds -log(of), the barrier that keeps `of` above 0.
  void add_barrier(const Jet& of) {
    value -= std::log(of.value);
    gradient -= of.gradient / of.value;
    hessian += of.gradient * of.gradient.transpose() / (of.value * of.value) - of.hessian / of.value;
  }
};

// A linear function that must stay above 0: few variables, each with its slope.
struct Room {
  double value = 0.0;
  std::vector<std::pair<int, double>> slopes;

  void add_barrier_to(Jet& jet) const {
    jet.value -= std::log(value);
    for (const auto& [a, slope_a] : slopes) {
      jet.gradient[a] -= slope_a / value;
      for (const auto& [b, slope_b] : slopes) jet.hessian(a, b) += slope_a * slope_b / (value * value);
    }
  }
};

// The variables are the utilisations of the tasks whose rate is not exact, and, while bounds are being relaxed, their
// factor behind them.
class Barrier {
 public:
  explicit Barrier(const PeriodProgram& program) : program_(program) {
    for (const PeriodTask& task : program.tasks) {
      variable_.push_back(task.exact_period > 0.0 ? -1 : static_cast<int>(free_++));
    }
  }

  // The factor is a variable, and what is minimised.
  void relax() { relaxing_ = true; }
  // The factor is given; infinite: no bounds.
  void set_factor(double factor) {
    relaxing_ = false;
    factor_ = factor;
  }

  Eigen::Index free() const { return free_; }
  Eigen::Index variables() const { return free_ + (relaxing_ ? 1 : 0); }
  double constraints() const { return static_cast<double>(3 * program_.tasks.size() + program_.bounds.size()); }

  double utilisation(std::size_t i, const VectorXd& x) const {
    const PeriodTask& task = program_.tasks[i];
    return variable_[i] < 0 ? task.cost / task.exact_period : x[variable_[i]];
  }

  Jet sum(const LatencySum& of, const VectorXd& x) const {
    Jet jet(variables());
    jet.value = of.constant;
    for (const LatencySum::Part& part : of.parts) {
      const auto i = static_cast<std::size_t>(part.task);
      if (part.period > 0.0) add_period(jet, i, part, x);
      if (part.response > 0.0) add_response(jet, i, part.response, x);
    }
    return jet;
  }

  Jet target(const VectorXd& x) const {
    if (!relaxing_) return sum(program_.objective, x);
    Jet jet(variables());
    jet.value = x[free_];
    jet.gradient[free_] = 1.0;
    return jet;
  }

  // scale * target + barriers; none outside of what is allowed.
  std::optional<Jet> at(const VectorXd& x, double scale) const {
    Jet all = target(x);
    all.value *= scale;
    all.gradient *= scale;
    all.hessian *= scale;
    for (std::size_t i = 0; i < program_.tasks.size(); ++i) {
      for (const Room& room : rooms(i, x)) {
        if (room.slopes.empty()) {  // of exact rates only
          if (room.value < -1e-12) return std::nullopt;
          continue;
        }
        if (!(room.value > 0.0)) return std::nullopt;
        room.add_barrier_to(all);
      }
    }
    if (!relaxing_ && factor_ == kInfinity) return all;
    for (const LatencySum& bound : program_.bounds) {
      Jet room = sum(bound, x);
      room.gradient *= -1.0;
      room.hessian *= -1.0;
      room.value = (relaxing_ ? x[free_] : factor_) * bound.asked - room.value;
      if (relaxing_) room.gradient[free_] += bound.asked;
      if (!(room.value > 0.0)) return std::nullopt;
      all.add_barrier(room);
    }
    return all;
  }

 private:
  // What must stay above 0: 1 - (utilisation above) - u b / c, so that a run ends within its period, and the room to
  // the period's limits.
  std::vector<Room> rooms(std::size_t i, const VectorXd& x) const {
    const PeriodTask& task = program_.tasks[i];
    std::vector<Room> made;
    Room ends{left_by_higher(i, x) - task.burst / task.cost * utilisation(i, x), {}};
    for (const int j : task.higher) add_slope(ends, static_cast<std::size_t>(j), -1.0);
    add_slope(ends, i, -task.burst / task.cost);
    made.push_back(std::move(ends));
    const int at = variable_[i];
    if (at < 0) return made;
    made.push_back({x[at] - task.cost / task.max_period, {{at, 1.0}}});
    if (task.min_period > 0.0) made.push_back({task.cost / task.min_period - x[at], {{at, -1.0}}});
    return made;
  }

  double left_by_higher(std::size_t i, const VectorXd& x) const {
    double left = 1.0;
    for (const int j : program_.tasks[i].higher) left -= utilisation(static_cast<std::size_t>(j), x);
    return left;
  }

  void add_slope(Room& room, std::size_t i, double slope) const {
    if (variable_[i] >= 0) room.slopes.emplace_back(variable_[i], slope);
  }

  // max(t, emits) as the norm (t^q + emits^q)^(1/q).
  void add_period(Jet& jet, std::size_t i, const LatencySum::Part& part, const VectorXd& x) const {
    constexpr double kNorm = 16.0;
    const double u = utilisation(i, x);
    const double t = program_.tasks[i].cost / u;
    double value = t;
    double slope = 1.0;
    double curve = 0.0;  // second derivative in t
    if (part.emits > 0.0) {
      const double largest = std::max(t, part.emits);
      const double a = t / largest;
      const double e = std::pow(part.emits / largest, kNorm);
      const double s = std::pow(a, kNorm) + e;
      value = largest * std::pow(s, 1.0 / kNorm);
      slope = std::pow(s, 1.0 / kNorm - 1.0) * std::pow(a, kNorm - 1.0);
      curve = (kNorm - 1.0) * std::pow(s, 1.0 / kNorm - 2.0) * std::pow(a, kNorm - 2.0) * e / largest;
    }
    jet.value += part.period * value;
    const int at = variable_[i];
    if (at < 0) return;
    jet.gradient[at] -= part.period * slope * t / u;
    jet.hessian(at, at) += part.period * (curve * t * t + slope * 2.0 * t) / (u * u);
  }

  void add_response(Jet& jet, std::size_t i, double weight, const VectorXd& x) const {
    const PeriodTask& task = program_.tasks[i];
    const double left = left_by_higher(i, x);
    const double response = weight * task.burst / left;
    jet.value += response;
    for (const int j : task.higher) {
      const int a = variable_[static_cast<std::size_t>(j)];
      if (a < 0) continue;
      jet.gradient[a] += response / left;
      for (const int k : task.higher) {
        const int b = variable_[static_cast<std::size_t>(k)];
        if (b >= 0) jet.hessian(a, b) += 2.0 * response / (left * left);
      }
    }
  }

  const PeriodProgram& program_;
  std::vector<int> variable_;  // by task; -1: its rate is exact
  Eigen::Index free_ = 0;
  bool relaxing_ = false;
  double factor_ = kInfinity;
};

// Newton steps to the least of scale * target + barriers. `x` stays within what is allowed.
void centre(const Barrier& barrier, double scale, VectorXd& x) {
  constexpr int kSteps = 60;
  std::optional<Jet> here = barrier.at(x, scale);
  for (int step = 0; here && step < kSteps; ++step) {
    MatrixXd hessian = here->hessian;
    // Scaled by its diagonal: utilisations differ by orders of magnitude.
    const VectorXd by = hessian.diagonal().cwiseMax(std::numeric_limits<double>::min()).cwiseSqrt().cwiseInverse();
    hessian = by.asDiagonal() * hessian * by.asDiagonal();
    hessian.diagonal().array() += 1e-12;
    const VectorXd direction = -by.cwiseProduct(hessian.ldlt().solve(by.cwiseProduct(here->gradient)));
    const double decrement = -direction.dot(here->gradient);
    if (!(decrement > 1e-8)) return;
    double length = 1.0;
    std::optional<Jet> next;
    for (int halving = 0; halving < 50; ++halving, length *= 0.5) {
      next = barrier.at(x + length * direction, scale);
      if (next && next->value <= here->value - 0.1 * length * decrement) break;
      next.reset();
    }
    if (!next) return;
    x += length * direction;
    here = std::move(next);
  }
}

// `stop` ends it early. Precondition: `x` is allowed.
template <class Stop>
void minimise(const Barrier& barrier, VectorXd& x, const Stop& stop) {
  constexpr double kGap = 1e-7;
  const double begin = std::max(std::abs(barrier.target(x).value), 1e-9);
  for (double scale = 1.0 / begin; !stop(x); scale *= 12.0) {
    centre(barrier, scale, x);
    if (barrier.constraints() / scale < kGap * std::abs(barrier.target(x).value)) return;
  }
}

// Every task at a part of what it could have, small enough for all; none where even that is too much.
std::optional<VectorXd> any_start(const PeriodProgram& program, const Barrier& barrier) {
  VectorXd x(barrier.free());
  for (double part = 0.5; part > 1e-9; part *= 0.5) {
    Eigen::Index at = 0;
    for (const PeriodTask& task : program.tasks) {
      if (task.exact_period > 0.0) continue;
      const double low = task.cost / task.max_period;
      double high = task.cost / (task.burst * static_cast<double>(program.tasks.size()));
      if (task.min_period > 0.0) high = std::min(high, task.cost / task.min_period);
      x[at++] = low + part * (std::max(high, low * 1.001) - low);
    }
    if (barrier.at(x, 1.0)) return x;
  }
  return std::nullopt;
}

double factor_of(const PeriodProgram& program, const Barrier& barrier, const VectorXd& x) {
  double factor = 0.0;
  for (const LatencySum& bound : program.bounds) {
    factor = std::max(factor, barrier.sum(bound, x).value / bound.asked);
  }
  return factor;
}

}  // namespace

void LatencySum::add(const Part& part) {
  const auto same = std::find_if(parts.begin(), parts.end(), [&](const Part& other) {
    return other.task == part.task && other.emits == part.emits;
  });
  if (same == parts.end()) return parts.push_back(part);
  same->period += part.period;
  same->response += part.response;
}

std::optional<PeriodSolution> solve_periods(const PeriodProgram& program) {
  Barrier barrier(program);
  const auto never = [](const VectorXd&) { return false; };
  std::optional<VectorXd> x = any_start(program, barrier);
  if (!x) return std::nullopt;
  PeriodSolution solution;
  if (barrier.free() > 0) {
    const VectorXd start = *x;
    minimise(barrier, *x, never);
    if (factor_of(program, barrier, *x) > 1.0) {
      x = start;
      x->conservativeResize(barrier.free() + 1);
      (*x)[barrier.free()] = 2.0 * factor_of(program, barrier, start) + 1.0;
      barrier.relax();
      const Eigen::Index last = barrier.free();
      minimise(barrier, *x, [last](const VectorXd& at) { return at[last] < 0.999; });
      solution.factor = std::max(1.0, (*x)[last] * (1.0 + 1e-9));
      x->conservativeResize(last);
      barrier.set_factor(solution.factor);
      minimise(barrier, *x, never);
    }
  }
  for (std::size_t i = 0; i < program.tasks.size(); ++i) {
    const PeriodTask& task = program.tasks[i];
    solution.periods.push_back(task.exact_period > 0.0 ? task.exact_period : task.cost / barrier.utilisation(i, *x));
  }
  solution.factor = std::max(1.0, factor_of(program, barrier, *x));
  return solution;
}

}  // namespace ctn::baselines
