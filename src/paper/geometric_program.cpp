// Section 5.2: the solver of stage II's geometric program.
#include "paper/geometric_program.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Dense>

#include "base/numbers.h"

namespace ctn::paper {
namespace {

using Vector = Eigen::VectorXd;
using Matrix = Eigen::MatrixXd;

constexpr double kGap = 1e-11;        // of the logarithm of the value
constexpr double kStationary = 1e-8;  // residual of the dual at the end
constexpr int kMaxSteps = 150;

// The logarithm of a posynomial, with its gradient, at one point.
struct LogPosynomial {
  const Posynomial* sum = nullptr;
  std::vector<int> variables;  // that it depends on

  double value = 0.0;
  std::vector<double> parts;  // of each monomial in the sum; they add up to 1
  Vector gradient;            // by variable of the program; 0 but for `variables`

  LogPosynomial(const Posynomial& posynomial, int count) : sum(&posynomial), gradient(Vector::Zero(count)) {
    for (const Monomial& monomial : posynomial) {
      for (const auto& power : monomial.powers) variables.push_back(power.first);
    }
    std::sort(variables.begin(), variables.end());
    variables.erase(std::unique(variables.begin(), variables.end()), variables.end());
    parts.resize(posynomial.size());
  }

  double at(const Vector& y) {
    double largest = -kInfinity;
    for (std::size_t k = 0; k < sum->size(); ++k) {
      const Monomial& monomial = (*sum)[k];
      double log = std::log(monomial.coefficient);
      for (const auto& [variable, exponent] : monomial.powers) log += exponent * y[variable];
      parts[k] = log;
      largest = std::max(largest, log);
    }
    double total = 0.0;
    for (double& part : parts) total += part = std::exp(part - largest);
    for (double& part : parts) part /= total;
    value = largest + std::log(total);
    return value;
  }

  void differentiate() {
    for (const int variable : variables) gradient[variable] = 0.0;
    for (std::size_t k = 0; k < sum->size(); ++k) {
      for (const auto& [variable, exponent] : (*sum)[k].powers) gradient[variable] += parts[k] * exponent;
    }
  }

  // Adds weight x its Hessian, and outer x the outer product of its gradient.
  void add_to(Matrix& hessian, double weight, double outer) const {
    for (std::size_t k = 0; k < sum->size(); ++k) {
      for (const auto& [i, a] : (*sum)[k].powers) {
        for (const auto& [j, b] : (*sum)[k].powers) hessian(i, j) += weight * parts[k] * a * b;
      }
    }
    for (const int i : variables) {
      for (const int j : variables) hessian(i, j) += (outer - weight) * gradient[i] * gradient[j];
    }
  }
};

class InteriorPoint {
 public:
  explicit InteriorPoint(const GeometricProgram& program)
      : count_(program.variables), objective_(program.objective, program.variables) {
    for (const Posynomial& constraint : program.constraints) constraints_.emplace_back(constraint, program.variables);
  }

  bool strictly_feasible(const Vector& y) {
    return std::all_of(constraints_.begin(), constraints_.end(), [&](LogPosynomial& f) { return f.at(y) < 0.0; });
  }

  // From a strictly feasible point. `enough`: whether that is all that is asked for.
  template <typename Enough>
  Vector minimise(Vector y, const Enough& enough) {
    const std::size_t m = constraints_.size();
    evaluate(y);
    duals_.resize(static_cast<Eigen::Index>(m));
    for (std::size_t j = 0; j < m; ++j) dual(j) = -1.0 / constraints_[j].value;
    for (int step = 0; step < kMaxSteps && !enough(y); ++step) {
      const double gap = surrogate_gap();
      if (gap < kGap && dual_residual().norm() < kStationary) break;
      constexpr double kCentering = 10.0;
      const double inverse_t = gap / (kCentering * static_cast<double>(std::max<std::size_t>(1, m)));
      if (!advance(y, inverse_t)) break;
    }
    return y;
  }

  double value() const { return objective_.value; }
  const Vector& duals() const { return duals_; }

 private:
  double& dual(std::size_t j) { return duals_[static_cast<Eigen::Index>(j)]; }
  double dual(std::size_t j) const { return duals_[static_cast<Eigen::Index>(j)]; }

  void evaluate(const Vector& y) {
    objective_.at(y);
    objective_.differentiate();
    for (LogPosynomial& f : constraints_) {
      f.at(y);
      f.differentiate();
    }
  }

  double surrogate_gap() const {
    double gap = 0.0;
    for (std::size_t j = 0; j < constraints_.size(); ++j) gap -= dual(j) * constraints_[j].value;
    return gap;
  }

  Vector dual_residual() const {
    Vector residual = objective_.gradient;
    for (std::size_t j = 0; j < constraints_.size(); ++j) {
      for (const int i : constraints_[j].variables) residual[i] += dual(j) * constraints_[j].gradient[i];
    }
    return residual;
  }

  double residual(double inverse_t) const {
    double square = dual_residual().squaredNorm();
    for (std::size_t j = 0; j < constraints_.size(); ++j) {
      const double central = -dual(j) * constraints_[j].value - inverse_t;
      square += central * central;
    }
    return std::sqrt(square);
  }

  // One Newton step. False: it leads no further.
  bool advance(Vector& y, double inverse_t) {
    Matrix hessian = Matrix::Zero(count_, count_);
    Vector right = -objective_.gradient;
    objective_.add_to(hessian, 1.0, 0.0);
    for (std::size_t j = 0; j < constraints_.size(); ++j) {
      const LogPosynomial& f = constraints_[j];
      f.add_to(hessian, dual(j), dual(j) / -f.value);
      for (const int i : f.variables) right[i] -= inverse_t / -f.value * f.gradient[i];
    }
    hessian.diagonal().array() += 1e-13 * (1.0 + hessian.diagonal().array().abs());
    const Vector move = hessian.ldlt().solve(right);
    if (!move.allFinite()) return false;
    Vector dual_move(duals_.size());
    double longest = 1.0;
    for (std::size_t j = 0; j < constraints_.size(); ++j) {
      const LogPosynomial& f = constraints_[j];
      double along = 0.0;
      for (const int i : f.variables) along += f.gradient[i] * move[i];
      const double change = -dual(j) + (inverse_t + dual(j) * along) / -f.value;
      dual_move[static_cast<Eigen::Index>(j)] = change;
      if (change < 0.0) longest = std::min(longest, -dual(j) / change);
    }
    return search(y, move, dual_move, 0.99 * longest, inverse_t);
  }

  bool search(Vector& y, const Vector& move, const Vector& dual_move, double length, double inverse_t) {
    constexpr double kDecrease = 0.01;
    constexpr double kShorter = 0.5;
    constexpr double kShortest = 1e-12;
    const double before = residual(inverse_t);
    const Vector duals = duals_;
    for (; length > kShortest; length *= kShorter) {
      const Vector to = y + length * move;
      if (!strictly_feasible(to)) continue;
      duals_ = duals + length * dual_move;
      evaluate(to);
      if (residual(inverse_t) > (1.0 - kDecrease * length) * before) continue;
      y = to;
      return true;
    }
    duals_ = duals;
    evaluate(y);
    return false;
  }

  const int count_;
  LogPosynomial objective_;
  std::vector<LogPosynomial> constraints_;
  Vector duals_;
};

double at_one(const Posynomial& sum) {
  double value = 0.0;
  for (const Monomial& monomial : sum) value += monomial.coefficient;
  return value;
}

// A point that satisfies all constraints strictly: the least s with f_j(x) <= s, until s is below 1.
std::optional<Vector> feasible_from(const GeometricProgram& program, const Vector& start) {
  GeometricProgram looser = program;
  const Monomial s = looser.add_variable();
  const Monomial over = s.inverse();
  double largest = 0.0;
  for (Posynomial& constraint : looser.constraints) {
    largest = std::max(largest, LogPosynomial(constraint, program.variables).at(start));
    for (Monomial& monomial : constraint) monomial *= over;
  }
  constexpr double kFarBelow = 0.5;
  looser.constraints.push_back({kFarBelow * over});
  looser.objective = {s};
  Vector y(looser.variables);
  y << start, largest + 1.0;
  InteriorPoint point(looser);
  InteriorPoint asked(program);
  const auto without_s = [&](const Vector& all) -> Vector { return all.head(program.variables); };
  y = point.minimise(y, [&](const Vector& all) { return asked.strictly_feasible(without_s(all)); });
  y = without_s(y).eval();
  return asked.strictly_feasible(y) ? std::optional(y) : std::nullopt;
}

}  // namespace

Monomial& Monomial::operator*=(const Monomial& other) {
  coefficient *= other.coefficient;
  for (const auto& power : other.powers) {
    const auto same = [&](const auto& mine) { return mine.first == power.first; };
    const auto found = std::find_if(powers.begin(), powers.end(), same);
    if (found == powers.end()) {
      powers.push_back(power);
    } else {
      found->second += power.second;
    }
  }
  return *this;
}

Monomial Monomial::inverse() const {
  Monomial result = *this;
  result.coefficient = 1.0 / coefficient;
  for (auto& power : result.powers) power.second = -power.second;
  return result;
}

double value_of(const Monomial& monomial, const std::vector<double>& x) {
  double value = monomial.coefficient;
  for (const auto& [variable, exponent] : monomial.powers) {
    value *= std::pow(x[static_cast<std::size_t>(variable)], exponent);
  }
  return value;
}

std::optional<GeometricSolution> solve(const GeometricProgram& program, const std::vector<double>& start) {
  if (program.variables == 0) return GeometricSolution{{}, at_one(program.objective), {}};
  Vector y(program.variables);
  for (int i = 0; i < program.variables; ++i) y[i] = std::log(start[static_cast<std::size_t>(i)]);
  InteriorPoint point(program);
  if (!point.strictly_feasible(y)) {
    const std::optional<Vector> feasible = feasible_from(program, y);
    if (!feasible) return std::nullopt;
    y = *feasible;
  }
  y = point.minimise(y, [](const Vector&) { return false; });
  GeometricSolution solution;
  for (int i = 0; i < program.variables; ++i) solution.x.push_back(std::exp(y[i]));
  solution.value = std::exp(point.value());
  solution.duals.assign(point.duals().begin(), point.duals().end());
  return solution;
}

}  // namespace ctn::paper
