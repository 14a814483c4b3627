// Nodes within a subchain at rates of their own, in the whole runtime, in virtual time, every figure exact: what the
// simulator gives for the same app (sim/fallback_rates_test.cpp).
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "base/guarded.h"
#include "config/testing/apps.h"
#include "os/fake/fake_os.h"
#include "runtime/engine.h"

namespace ctn::runtime {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using testing::ElementsAre;

class FallbackRatesTest : public ::testing::Test {
 protected:
  void open(const std::string& policy, int cpus) {
    std::vector<int> numbers;
    for (int cpu = 0; cpu < cpus; ++cpu) numbers.push_back(cpu);
    auto made = Engine::create(own_rates_app(), fake,
                               {.policy = *policy::make_policy(policy),
                                .cpus = os::CpuSet(numbers),
                                .record = {},
                                .note = {},
                                .on_notice = {}});
    ASSERT_TRUE(made.ok()) << made.error().message();
    engine = std::move(*made);
    for (const auto& [name, cost] : costs) {
      engine->wiring().set_body(name, [this, name = name, cost = cost](ctn::Run&) {
        begins.lock()->operator[](name).push_back(to_millis(fake.now() - started).count());
        fake.burn(cost);
      });
    }
  }
  Snapshot run_for(Nanos duration) {
    started = fake.now();
    EXPECT_TRUE(engine->start().ok());
    fake.sleep_until(started + duration);
    Snapshot snapshot = engine->snapshot();
    EXPECT_TRUE(engine->stop().ok());
    return snapshot;
  }
  std::vector<double> begins_of(const std::string& node) { return begins.lock()->operator[](node); }

  const std::map<std::string, Nanos> costs{
      {"scan", milliseconds{2}}, {"LM", milliseconds{4}}, {"LP", milliseconds{3}}, {"push", milliseconds{1}}};
  os::FakeOs fake{os::fake_topology(4)};
  TimePoint started{};
  Guarded<std::map<std::string, std::vector<double>>> begins;  // ms, by node
  std::unique_ptr<Engine> engine;                              // after `fake`: it goes first
};

TEST_F(FallbackRatesTest, OfNodesWithinASubchainAreKeptByTime) {
  open("default", 4);
  run_for(milliseconds{299});
  EXPECT_THAT(begins_of("scan"), ElementsAre(0, 50, 100, 150, 200, 250));
  EXPECT_THAT(begins_of("LM"), ElementsAre(0, 200));
  EXPECT_THAT(begins_of("LP"), ElementsAre(0, 100, 200));
  EXPECT_THAT(begins_of("push"), ElementsAre(3, 103, 203));
}

TEST_F(FallbackRatesTest, MakeRunsTakeTheNewestOfTheirPredecessors) {
  open("default", 4);
  const Snapshot snapshot = run_for(seconds{20});
  EXPECT_DOUBLE_EQ(snapshot.chains.front().response_ms.mean, 354.0);
  EXPECT_DOUBLE_EQ(snapshot.chains.front().response_ms.max, 354.0);
  EXPECT_DOUBLE_EQ(snapshot.chains.front().period_ms.mean, 200.0);
}

TEST_F(FallbackRatesTest, AreKeptAtFixedPrioritiesToo) {
  fake.share_cpus(true);
  open("fifo", 1);
  const Snapshot snapshot = run_for(seconds{20});
  EXPECT_DOUBLE_EQ(snapshot.chains.front().response_ms.mean, 210.0);
  EXPECT_DOUBLE_EQ(snapshot.chains.front().response_ms.max, 210.0);
  const std::vector<double> lp = begins_of("LP");
  ASSERT_GE(lp.size(), 3U);
  EXPECT_EQ(std::vector(lp.begin(), lp.begin() + 3), (std::vector<double>{6, 102, 206}));
}

}  // namespace
}  // namespace ctn::runtime
