// Response times of periodic tasks under fixed priorities on one core, exactly: the least r = c + sum over the tasks of
// higher priority of ceil(r / t) c (Joseph and Pandya, 1986), when all begin together, which is the worst.
//
// Units: milliseconds. Thread safety: pure functions.
#pragma once

#include <optional>
#include <span>

namespace ctn::baselines {

struct PeriodicTask {
  double cost = 0.0;
  double period = 0.0;
};

// None where a run could outlast `deadline`. A quotient that is whole but for rounding counts as whole.
std::optional<double> response_time(double cost, std::span<const PeriodicTask> higher, double deadline);

}  // namespace ctn::baselines
