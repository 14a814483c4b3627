#include "runtime/clock_watch.h"

#include <gtest/gtest.h>

#include <limits>

#include "config/testing/apps.h"

namespace ctn::runtime {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::seconds;

class ClockWatchTest : public ::testing::Test {
 protected:
  // Ticks up to now; what is news.
  std::vector<record::ClockReading> tick_until(TimePoint until, Nanos period) {
    std::vector<record::ClockReading> news;
    for (; next <= until; next += period) {
      EXPECT_TRUE(tell_tick(app, region, "display", next).ok());
      if (next - looked < milliseconds{50}) continue;
      looked = next;
      for (const record::ClockReading& reading : watch.look(next + microseconds{200})) news.push_back(reading);
    }
    return news;
  }

  const graph::App app = parse(R"(
catan: 1
app: shown
nodes: { a: {}, display: { external: true, period: 8ms }, motor: { external: true } }
edges: [ a -> display, a -> motor ]
objective: [ { response_time: [a, display], weight: 1 } ]
)");
  const NodeId display = *app.graph.find_node("display");
  LocalRegion memory{app.graph, 1};
  const Region& region = memory.region();
  ClockWatch watch{app.graph, region};
  TimePoint next{seconds{5}};
  TimePoint looked{};
};

TEST_F(ClockWatchTest, TellsOfAClockOnceItIsKnownAndWhenItHasDrifted) {
  const std::vector<record::ClockReading> first = tick_until(TimePoint{seconds{8}}, milliseconds{8});
  ASSERT_EQ(first.size(), 1U);
  EXPECT_EQ(first[0].node, display);
  EXPECT_EQ(first[0].ticks.period, milliseconds{8});
  EXPECT_EQ((first[0].ticks.tick - TimePoint{seconds{5}}) % milliseconds{8}, Nanos{0});
  const std::vector<record::ClockReading> later = tick_until(TimePoint{seconds{12}}, milliseconds{8} + Nanos{200});
  ASSERT_GE(later.size(), 2U);
  EXPECT_LE(later.size(), 4U) << "no more than once a second";
  EXPECT_NEAR(static_cast<double>((later.back().ticks.period - milliseconds{8}).count()), 200.0, 10.0);
}

TEST_F(ClockWatchTest, RefusesWhatHasNoClock) {
  for (const char* name : {"a", "motor", "nobody"}) {
    const Status told = tell_tick(app, region, name, TimePoint{});
    ASSERT_FALSE(told.ok());
    EXPECT_EQ(told.error().message(), std::string("app shown has no node '") + name +
                                          "' with a clock; name an external node that has a period in the app file");
  }
}

// A timer of 5 ms, of which runs begin up to 100 us late; and the node that follows it.
TEST(ClockWatchOfRuns, TellsOfTheTimerOfAnUnscheduledNode) {
  const graph::App app = parse(R"(
catan: 1
app: worn
nodes: { imu: { unscheduled: true, period: 5ms }, filter: { unscheduled: true }, warp: {} }
edges: [ imu -> filter -> warp ]
objective: [ { response_time: [imu, filter, warp], weight: 1 } ]
)");
  const NodeId imu = *app.graph.find_node("imu");
  LocalRegion memory{app.graph, 1};
  ClockWatch watch{app.graph, memory.region()};
  std::vector<record::ClockReading> news;
  for (int number = 0; number < 100; ++number) {
    const TimePoint tick = TimePoint{seconds{3}} + number * milliseconds{5};
    record::Run run;
    run.node = imu;
    run.begin = tick + microseconds{number % 7 == 0 ? 100 : 20};
    watch.ran(run);
    run.node = *app.graph.find_node(number % 2 == 0 ? "filter" : "warp");
    run.begin += microseconds{1700};
    watch.ran(run);
    for (const record::ClockReading& reading : watch.look(tick + milliseconds{1})) news.push_back(reading);
  }
  ASSERT_EQ(news.size(), 1U);
  EXPECT_EQ(news[0].node, imu);
  EXPECT_NEAR(static_cast<double>(news[0].ticks.period.count()), 5e6, 1e3);
  const Nanos late = (news[0].ticks.tick - TimePoint{seconds{3}}) % milliseconds{5};
  EXPECT_NEAR(static_cast<double>(late.count()), 20e3, 10e3);
}

// Any process may write anything into the region.
TEST_F(ClockWatchTest, SurvivesWhatCannotBeTrue) {
  NodeCell& cell = region.node(display);
  cell.newest_output.store(std::numeric_limits<std::uint64_t>::max());
  EXPECT_TRUE(watch.look(TimePoint{seconds{1}}).empty());
  cell.newest_output.store(3);
  EXPECT_TRUE(watch.look(TimePoint{seconds{1}}).empty());
  cell.give(4, std::numeric_limits<std::int64_t>::max());
  EXPECT_TRUE(watch.look(TimePoint{seconds{1}}).empty());
  EXPECT_EQ(tick_until(TimePoint{seconds{7}}, milliseconds{8}).size(), 1U) << "and goes on";
}

}  // namespace
}  // namespace ctn::runtime
