// Periods of tasks under fixed priorities on cores, as a convex program: the heart of davare.h.
//
// The response time of task i is taken to be r_i = c_i + sum_j (r_i / t_j + a_ij) c_j over the tasks j of higher
// priority on its core, where the ceiling of r_i / t_j would be exact and a_ij in [0, 1] stands for what it rounds up.
// In utilisations u_i = c_i / t_i that is r_i = b_i / (1 - sum_j u_j), b_i = c_i + sum_j a_ij c_j: convex. So are the
// periods c_i / u_i, hence all weighted sums of both, and r_i <= t_i is linear. The geometric program of the paper is
// this one in other variables; here it is solved by a barrier method with Newton steps, which needs no solver.
//
//   minimise   objective(t, r)
//   such that  bound(t, r) <= asked * factor, r_i <= t_i, and each period within its limits
//
// with the least factor >= 1 for which there is a solution.
//
// Units: milliseconds. Thread safety: pure functions.
#pragma once

#include <optional>
#include <vector>

namespace ctn::baselines {

struct PeriodTask {
  double cost = 1.0;          // c > 0
  double burst = 1.0;         // b >= c
  std::vector<int> higher;    // the tasks of higher priority on its core
  double min_period = 0.0;    // rate cap
  double max_period = 0.0;    // > min_period
  double exact_period = 0.0;  // 0: none
};

// constant + sum of period * max(t, emits) + response * r. The maximum is rounded off a little, which makes it more.
struct LatencySum {
  struct Part {
    int task = 0;
    double period = 0.0;
    double response = 0.0;
    double emits = 0.0;
  };
  double constant = 0.0;
  double asked = 0.0;  // of a bound
  std::vector<Part> parts;

  void add(const Part& part);  // into a part of the same task, where there is one
};

struct PeriodProgram {
  std::vector<PeriodTask> tasks;
  LatencySum objective;
  std::vector<LatencySum> bounds;
};

struct PeriodSolution {
  std::vector<double> periods;
  double factor = 1.0;
};

// None where no periods at all keep the exact rates and the caps.
std::optional<PeriodSolution> solve_periods(const PeriodProgram& program);

}  // namespace ctn::baselines
