#include "paper/geometric_program.h"

#include <gtest/gtest.h>

#include <cmath>

namespace ctn::paper {
namespace {

constexpr double kSame = 1e-7;

// x + y such that c / (x y) <= 1: x = y = sqrt(c).
GeometricProgram rectangle(double area) {
  GeometricProgram program;
  const Monomial x = program.add_variable();
  const Monomial y = program.add_variable();
  program.objective = {x, y};
  program.constraints = {{area * x.inverse() * y.inverse()}};
  return program;
}

TEST(GeometricProgram, IsSolvedFromAFeasibleStart) {
  const auto solution = solve(rectangle(9.0), {10.0, 20.0});
  ASSERT_TRUE(solution);
  EXPECT_NEAR(solution->value, 6.0, kSame);
  EXPECT_NEAR(solution->x[0], 3.0, 1e-4);
  EXPECT_NEAR(solution->x[1], 3.0, 1e-4);
}

TEST(GeometricProgram, IsSolvedFromAStartThatIsNotFeasible) {
  const auto solution = solve(rectangle(9.0), {0.01, 0.1});
  ASSERT_TRUE(solution);
  EXPECT_NEAR(solution->value, 6.0, kSame);
}

// The value is 2 sqrt(c): a limit higher by 1 % makes it lower by 0.5 %.
TEST(GeometricProgram, DualsAreWhatLimitsAreWorth) {
  const auto solution = solve(rectangle(9.0), {10.0, 20.0});
  ASSERT_TRUE(solution);
  ASSERT_EQ(solution->duals.size(), 1U);
  EXPECT_NEAR(solution->duals[0], 0.5, 1e-5);
}

TEST(GeometricProgram, ConstraintsThatDoNotBindAreWorthNothing) {
  GeometricProgram program = rectangle(9.0);
  program.constraints.push_back({Monomial{0.01, {{0, 1.0}}}});
  const auto solution = solve(program, {10.0, 20.0});
  ASSERT_TRUE(solution);
  EXPECT_NEAR(solution->value, 6.0, kSame);
  EXPECT_NEAR(solution->duals[1], 0.0, 1e-5);
}

TEST(GeometricProgram, WhatContradictsItselfHasNoSolution) {
  GeometricProgram program = rectangle(9.0);
  program.constraints.push_back({Monomial{1.0, {{0, 1.0}}}});  // x <= 1
  program.constraints.push_back({Monomial{1.0, {{1, 1.0}}}});  // y <= 1
  EXPECT_FALSE(solve(program, {0.5, 0.5}));
}

TEST(GeometricProgram, OneWithoutVariablesIsItsConstant) {
  GeometricProgram program;
  program.objective = {Monomial{2.0, {}}, Monomial{3.0, {}}};
  const auto solution = solve(program, {});
  ASSERT_TRUE(solution);
  EXPECT_EQ(solution->value, 5.0);
}

}  // namespace
}  // namespace ctn::paper
