#include "sim/clocks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "graph/build.h"
#include "graph/testing/spec_text.h"

namespace ctn::sim {
namespace {

using namespace std::chrono_literals;

// imu (a timer of 5 ms) -> int (follows) -> a -> display (ticks every 8 ms) | motor (no clock).
graph::App headset() {
  graph::AppSpec spec = graph::spec_of({"imu", "int", "a", "display", "motor"}, {"imu int a display", "a motor"});
  for (const char* name : {"imu", "int"}) graph::node(spec, name).unscheduled = true;
  for (const char* name : {"display", "motor"}) graph::node(spec, name).external = true;
  graph::node(spec, "imu").period = graph::At<Nanos>{5ms, {}};
  graph::node(spec, "display").period = graph::At<Nanos>{8ms, {}};
  spec.objective = {graph::response("imu int a display", 1.0)};
  return graph::build_app(spec).value();
}

constexpr std::size_t kImu = 0;
constexpr std::size_t kDisplay = 3;

double ppm(Nanos period, Nanos nominal) {
  return 1e6 * static_cast<double>((period - nominal).count()) / static_cast<double>(nominal.count());
}

TEST(Clocks, OnlyThoseThatAreThere) {
  const Clocks clocks = draw_clocks(headset().graph, {.seed = 1, .drift_ppm = 20.0});
  for (std::size_t node = 0; node < clocks.external.size(); ++node) {
    EXPECT_EQ(clocks.external[node].period > Nanos{0}, node == kDisplay) << node;
    EXPECT_EQ(clocks.timers[node].period > Nanos{0}, node == kImu) << node;
  }
}

TEST(Clocks, WithoutDriftTimersAreAsTheyWereAndTicksHaveAnyPhase) {
  const graph::App app = headset();
  std::set<TimePoint> phases;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Clocks clocks = draw_clocks(app.graph, {.seed = seed});
    EXPECT_EQ(clocks.timers[kImu], (Ticks{TimePoint{} + 5ms, 5ms}));
    EXPECT_EQ(clocks.external[kDisplay].period, 8ms);
    EXPECT_LT(clocks.external[kDisplay].tick, TimePoint{} + 8ms);
    phases.insert(clocks.external[kDisplay].tick);
  }
  EXPECT_EQ(phases.size(), 20U);
}

TEST(Clocks, DriftEitherWayAndNoFurtherThanSaid) {
  const graph::App app = headset();
  double fastest = 0.0;
  double slowest = 0.0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    const Clocks clocks = draw_clocks(app.graph, {.seed = seed, .drift_ppm = 50.0});
    for (const double off : {ppm(clocks.timers[kImu].period, 5ms), ppm(clocks.external[kDisplay].period, 8ms)}) {
      EXPECT_LE(std::abs(off), 50.0 + 0.2) << "to the nanosecond";
      fastest = std::min(fastest, off);
      slowest = std::max(slowest, off);
    }
  }
  EXPECT_LT(fastest, -40.0);
  EXPECT_GT(slowest, 40.0);
  EXPECT_EQ(draw_clocks(app.graph, {.seed = 3, .drift_ppm = 50.0}).timers,
            draw_clocks(app.graph, {.seed = 3, .drift_ppm = 50.0}).timers);
}

}  // namespace
}  // namespace ctn::sim
