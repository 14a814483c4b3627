// In virtual time, with a real node's port.
#include "runtime/unserved_pacer.h"

#include <gtest/gtest.h>

#include "base/run_access.h"
#include "config/testing/apps.h"
#include "os/fake/fake_os.h"
#include "runtime/node_link.h"

namespace ctn::runtime {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

class UnservedPacerTest : public ::testing::Test {
 protected:
  UnservedPacerTest() { pacer.begin(fake.now(), {{&port, milliseconds{20}}}); }

  // The node's run, if it was triggered, takes no time.
  bool run_if_triggered() {
    if (static_cast<std::uint32_t>(ran) == region.node(node).word.load()) return false;
    EXPECT_TRUE(port.wait_for_trigger());
    ctn::Run run;
    port.begin(run);
    port.end(run);
    ++ran;
    return true;
  }

  os::FakeOs fake;
  graph::App app = parse(
      "catan: 1\napp: one\nnodes: { node: { fallback_rate: 50Hz } }\nedges: []\n"
      "objective: [ { period: node, weight: 1 } ]\n");
  NodeId node{std::size_t{0}};
  SubchainId subchain{std::size_t{0}};
  LocalRegion memory{app.graph, 1};
  Region& region = memory.region();
  NodePort port{fake, app.graph, node, region};
  UnservedPacer pacer;
  std::uint64_t ran = 0;
};

TEST_F(UnservedPacerTest, TriggersEveryPeriod) {
  const TimePoint begin = fake.now();
  for (TimePoint next = begin; next < begin + seconds{1}; next = pacer.pace_heads(fake.now())) {
    fake.sleep_until(next);
    pacer.pace_heads(fake.now());
    run_if_triggered();
  }
  EXPECT_EQ(ran, 50U);
}

TEST_F(UnservedPacerTest, WaitsForTheRunUnderWay) {
  pacer.pace_heads(fake.now());
  const TimePoint begin = fake.now();
  for (int period = 1; period < 10; ++period) {
    fake.sleep_until(begin + period * milliseconds{20});
    EXPECT_EQ(pacer.pace_heads(fake.now()), fake.now() + milliseconds{20});
  }
  EXPECT_TRUE(run_if_triggered());
  EXPECT_FALSE(run_if_triggered()) << "one trigger, however often it was due";
}

TEST_F(UnservedPacerTest, GivesUpARunThatWillNotEnd) {
  pacer.pace_heads(fake.now());
  const TimePoint begin = fake.now();
  while (fake.now() < begin + milliseconds{1000}) fake.sleep_until(pacer.pace_heads(fake.now()));
  EXPECT_EQ(region.signal(subchain).completed.load(), 0U);
  while (fake.now() < begin + milliseconds{1100}) fake.sleep_until(pacer.pace_heads(fake.now()));
  EXPECT_EQ(region.signal(subchain).completed.load(), 1U);
  EXPECT_EQ(region.node(node).word.load(), 2U) << "and the next is triggered";
}

TEST_F(UnservedPacerTest, WakesANodeThatAServerTriggeredAndDidNotWake) {
  bool has_run = false;
  const auto thread = fake.spawn("node", [&] { has_run = port.wait_for_trigger(); });
  fake.sleep_until(fake.now() + milliseconds{1});
  region.node(node).word.store(1);  // and the server is killed here
  fake.sleep_until(fake.now() + milliseconds{1});
  EXPECT_FALSE(has_run);
  pacer.pace_heads(fake.now());
  thread->join();
  EXPECT_TRUE(has_run);
}

class ServerGoesOnTest : public UnservedPacerTest {
 protected:
  std::uint64_t completed() const { return region.signal(subchain).completed.load(); }

  Links links = links_of(fake, app.graph, region);
  SubchainLinks server = subchain_links(app.graph, links, region).front();
};

// The program goes on to trigger its nodes until the server has answered that all have registered.
TEST_F(ServerGoesOnTest, ARunThatTheProgramTriggeredWithTheServersNextNumberCountsAsTheServers) {
  pacer.pace_heads(fake.now());
  ASSERT_TRUE(run_if_triggered());
  ASSERT_EQ(completed(), 1U);
  server.trigger(1);
  EXPECT_FALSE(run_if_triggered()) << "the node does not see it";
  EXPECT_EQ(completed(), 1U) << "or the server would wait for its end without end";
  server.trigger(2);
  EXPECT_TRUE(run_if_triggered());
  EXPECT_EQ(completed(), 2U);
}

TEST_F(ServerGoesOnTest, ARunThatTheProgramTriggeredAndThatIsUnderWayCountsAsTheServers) {
  pacer.pace_heads(fake.now());
  server.trigger(1);
  EXPECT_EQ(completed(), 0U);
  EXPECT_TRUE(run_if_triggered());
  EXPECT_EQ(completed(), 1U);
}

TEST_F(ServerGoesOnTest, ARunThatHasNotBegunHasNotEndedWhateverTheRegionSays) {
  region.signal(subchain).completed.store(7);
  server.trigger(3);
  EXPECT_EQ(completed(), 2U);
  EXPECT_TRUE(run_if_triggered());
  EXPECT_EQ(completed(), 3U);
}

TEST_F(UnservedPacerTest, TakesThePeriodOfThePlanWithinReason) {
  const auto period = [&](Nanos planned) {
    region.signal(subchain).period.store(planned.count());
    return period_without_server(app.graph, subchain, region);
  };
  EXPECT_EQ(period(milliseconds{7}), milliseconds{7});
  EXPECT_EQ(period(Nanos{1}), std::chrono::microseconds{100});
  EXPECT_EQ(period(Nanos::max()), seconds{100});
  EXPECT_EQ(period(Nanos{0}), milliseconds{20}) << "its fallback rate";
  EXPECT_EQ(period(Nanos{-5}), milliseconds{20});
}

}  // namespace
}  // namespace ctn::runtime
