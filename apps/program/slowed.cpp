#include "program/slowed.h"

#include <ctime>
#include <utility>

namespace ctn::program {

std::chrono::nanoseconds thread_cpu_time() {
  timespec used{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &used);
  return std::chrono::seconds(used.tv_sec) + std::chrono::nanoseconds(used.tv_nsec);
}

std::function<void(Run&)> slowed(std::function<void(Run&)> body, double slowdown) {
  if (slowdown == 1.0) return body;
  return [body = std::move(body), slowdown](Run& run) {
    const std::chrono::nanoseconds begin = thread_cpu_time();
    body(run);
    const auto enough = slowdown * std::chrono::duration<double>(thread_cpu_time() - begin);
    while (thread_cpu_time() - begin < enough) {
    }
  };
}

std::function<void(Run&)> slowed(std::function<void(Run&)> body, std::function<void(Run&)> effect, double slowdown) {
  return [body = slowed(std::move(body), slowdown), effect = std::move(effect)](Run& run) {
    body(run);
    if (effect) effect(run);
  };
}

}  // namespace ctn::program
