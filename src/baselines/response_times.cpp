#include "baselines/response_times.h"

#include <cmath>

namespace ctn::baselines {

std::optional<double> response_time(double cost, std::span<const PeriodicTask> higher, double deadline) {
  constexpr double kRounding = 1e-9;
  double response = cost;
  for (const PeriodicTask& task : higher) response += task.cost;
  for (;;) {
    if (response > deadline * (1.0 + kRounding)) return std::nullopt;
    double next = cost;
    for (const PeriodicTask& task : higher) next += std::ceil(response / task.period - kRounding) * task.cost;
    if (next <= response * (1.0 + kRounding)) return response;
    response = next;
  }
}

}  // namespace ctn::baselines
