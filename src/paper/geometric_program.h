// A geometric program, which is what the paper's stage II is but for whole numbers:
//
//   minimise   f_0(x)   such that   f_j(x) <= 1,   x > 0,
//
// each f a posynomial, that is, a sum of monomials c x_1^a_1 x_2^a_2 ... with c > 0. In y = log x the logarithms of all
// f are convex; the program is solved there by a primal-dual interior-point method (Boyd and Vandenberghe, "Convex
// Optimization", 2004, sections 4.5 and 11.7), with dense Newton steps.
//
// Units: none. Thread safety: pure functions.
#pragma once

#include <optional>
#include <utility>
#include <vector>

namespace ctn::paper {

struct Monomial {
  double coefficient = 1.0;                      // > 0
  std::vector<std::pair<int, double>> powers{};  // variable, exponent; no variable twice

  Monomial& operator*=(const Monomial& other);
  friend Monomial operator*(Monomial a, const Monomial& b) { return a *= b; }
  friend Monomial operator*(double c, Monomial a) { return a.coefficient *= c, a; }
  Monomial inverse() const;
};

using Posynomial = std::vector<Monomial>;

struct GeometricProgram {
  int variables = 0;
  Posynomial objective;                 // not empty
  std::vector<Posynomial> constraints;  // <= 1; none empty

  Monomial add_variable() { return {1.0, {{variables++, 1.0}}}; }
};

struct GeometricSolution {
  std::vector<double> x;
  double value = 0.0;
  // By constraint: how much a relative change of its limit 1 is worth, in relative changes of the value.
  std::vector<double> duals;
};

// From `start`, which need not be feasible. None where no x satisfies all constraints strictly.
std::optional<GeometricSolution> solve(const GeometricProgram& program, const std::vector<double>& start);

double value_of(const Monomial& monomial, const std::vector<double>& x);

}  // namespace ctn::paper
