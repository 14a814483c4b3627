// How often change detection (src/model/change_detector.h) raises an alarm without a change, and how many runs it takes
// to tell one. Everything is drawn, so every machine prints the same, but for the time a run takes.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "model/change_detector.h"
#include "model/testing/change_detection_cases.h"

namespace {

using namespace ctn;
using namespace ctn::model;

// Runs between two alarms while nothing changes.
void false_alarms(const std::string& name, const std::function<Nanos(std::uint64_t)>& draw, std::uint64_t runs) {
  ChangeDetector detector;
  std::uint64_t alarms = 0;
  for (std::uint64_t run = 0; run < runs; ++run) alarms += detector.add(draw(run)) ? 1U : 0U;
  if (alarms == 0) {
    fmt::print("  {:<46} none in {} runs\n", name, runs);
  } else {
    fmt::print("  {:<46} one in {} runs ({} in {})\n", name, runs / alarms, alarms, runs);
  }
}

// `step`: what the compute time is multiplied with after 200 runs.
void delays(const char* name, std::uint64_t seed, const CaseLaw& law, double step) {
  constexpr int kTrials = 2000;
  constexpr std::uint64_t kBefore = 200;
  constexpr std::uint64_t kTimeout = 300;
  std::vector<std::size_t> delays;
  int missed = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    ChangeDetector detector;
    const Draw before = draws(law, seed + static_cast<std::uint64_t>(trial));
    for (std::uint64_t run = 0; run < kBefore; ++run) detector.add(before());
    std::uint64_t delay = 1;
    while (delay <= kTimeout && !detector.add(scaled(before(), step))) ++delay;
    delay <= kTimeout ? delays.push_back(delay) : static_cast<void>(++missed);
  }
  std::sort(delays.begin(), delays.end());
  if (delays.empty()) return fmt::print("  {:<46} {:+4.0f} %: never within {}\n", name, (step - 1.0) * 100.0, kTimeout);
  fmt::print("  {:<46} {:+4.0f} %: median {}, 95 % {}; not within {}: {:.1f} %\n", name, (step - 1.0) * 100.0,
             delays[delays.size() / 2], delays[delays.size() * 95 / 100], kTimeout, 100.0 * missed / kTrials);
}

void time_a_run() {
  constexpr std::uint64_t kRuns = 2'000'000;
  const Draw draw = draws({.spread = 0.25}, 1);
  std::vector<Nanos> costs;
  for (std::uint64_t run = 0; run < 10'000; ++run) costs.push_back(draw());
  ChangeDetector detector;
  std::size_t alarms = 0;
  const auto begin = std::chrono::steady_clock::now();
  for (std::uint64_t run = 0; run < kRuns; ++run) alarms += detector.add(costs[run % costs.size()]) ? 1U : 0U;
  const std::chrono::duration<double, std::nano> took = std::chrono::steady_clock::now() - begin;
  fmt::print("A run takes {:.0f} ns ({} alarms)\n", took.count() / kRuns, alarms);
}

}  // namespace

int main() {
  constexpr std::uint64_t kMany = 10'000'000;
  fmt::print("False alarms\n");
  for (const Case& each : unchanging_cases()) {
    false_alarms(
        each.name, [draw = draws(each.law, 7)](std::uint64_t) { return draw(); }, kMany);
  }
  fmt::print("Growth by 0.5 % a second, not compound, for 200 s\n");
  for (const double hertz : {1.0, 2.0, 5.0, 10.0, 100.0}) {
    for (const Case& each : {Case{"always the same", {}}, Case{"log-normal, spread 0.25", {.spread = 0.25}}}) {
      const Draw draw = draws(each.law, 7);
      const auto growing = [&](std::uint64_t run) {
        return scaled(draw(), 1.0 + 0.005 * static_cast<double>(run) / hertz);
      };
      false_alarms(fmt::format("{}, {} Hz", each.name, hertz), growing, static_cast<std::uint64_t>(200.0 * hertz));
    }
  }
  fmt::print("Runs until a change is told\n");
  for (const Case& each : unchanging_cases()) {
    for (const double step : {1.25, 1.5, 2.0, 0.75, 0.5}) delays(each.name, 100, each.law, step);
  }
  time_a_run();
}
