#include "baselines/policies.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "config/testing/apps.h"

namespace ctn::baselines {
namespace {

// Nodes cost 5 ms, as the situation says.
template <class Decide>
auto in_situation(const graph::App& app, const Decide& decide) {
  const model::CostTable costs(app.graph, Millis{5});
  const os::CpuSet cpus{2, 3};
  return decide(policy::Situation{.app = app, .cpus = cpus, .costs = costs, .typical = costs, .slack = 0.06});
}

Result<policy::Decision> decided(const char* method, const graph::App& app, const GivenCosts& given = {}) {
  const Baseline baseline = make_baseline(method, method, given);
  return in_situation(app, [&](const policy::Situation& situation) { return baseline.policy->decide(situation); });
}

Result<std::vector<sim::Reservation>> reserved_by(const char* method, const graph::App& app) {
  const Baseline baseline = make_baseline(method, method, {});
  return in_situation(app, [&](const policy::Situation& situation) { return baseline.reserve(situation); });
}

// Two chains of two subchains each, the second of more weight.
graph::App two_chains() {
  return parse(R"(
catan: 1
app: two
nodes:
  a: { fallback_rate: 10Hz }
  b: { fallback_rate: 20Hz }
  c: { fallback_rate: 5Hz }
  d: {}
  imu: { unscheduled: true, period: 5ms }
edges: [ a -> b, c -> d, imu -> c ]
subchains: { cd: [c, d] }
objective: [ { response_time: [a, b], weight: 1 }, { response_time: [c, d], weight: 2 } ]
)");
}

TEST(Compared, PicasKeepsChainsTogetherAndRanksTheirNodes) {
  const graph::App app = two_chains();
  const policy::Decision decision = *decided("picas", app);
  const policy::SubchainPlace& a = decision.assignment.places[app.graph.find_subchain("a")->index()];
  const policy::SubchainPlace& b = decision.assignment.places[app.graph.find_subchain("b")->index()];
  const policy::SubchainPlace& cd = decision.assignment.places[app.graph.find_subchain("cd")->index()];
  EXPECT_EQ(cd.levels, (std::vector<os::Level>{os::fixed_level(2), os::fixed_level(3)}));
  EXPECT_EQ(a.level_of(0), os::fixed_level(0));
  EXPECT_EQ(b.level_of(0), os::fixed_level(1));
  EXPECT_EQ(a.cpus, b.cpus);
  EXPECT_EQ(a.cpus.size(), 1U);
  EXPECT_NE(a.cpus, cd.cpus);
  EXPECT_EQ(decision.unscheduled_level, os::fixed_level(4));
  EXPECT_EQ(decision.dispatcher_level, os::fixed_level(5));
}

TEST(Compared, DeadlinesAreReservationsANode) {
  const graph::App app = two_chains();
  const policy::Decision decision = *decided("deadline", app);
  const policy::SubchainPlace& cd = decision.assignment.places[app.graph.find_subchain("cd")->index()];
  EXPECT_EQ(cd.pacing.period, std::chrono::milliseconds{200});
  EXPECT_EQ(cd.cpus, (os::CpuSet{2, 3}));
  const std::vector<sim::Reservation> reserved = *reserved_by("deadline", app);
  EXPECT_EQ(reserved[app.graph.find_node("d")->index()],
            (sim::Reservation{std::chrono::microseconds{5500}, std::chrono::milliseconds{200}}));
  EXPECT_EQ(reserved[app.graph.find_node("imu")->index()], sim::Reservation{}) << "is not scheduled";
}

TEST(Compared, RatesAreOnOneCoreEachAtOnePriority) {
  for (const char* name : {"davare", "verucchi"}) {
    const graph::App app = two_chains();
    const policy::Decision decision = *decided(name, app);
    std::vector<os::Level> levels;
    for (const policy::SubchainPlace& place : decision.assignment.places) {
      EXPECT_EQ(place.cpus.size(), 1U);
      EXPECT_GE(place.pacing.period, std::chrono::milliseconds{5});
      EXPECT_LE(place.pacing.period, std::chrono::milliseconds{50});
      levels.push_back(place.level);
    }
    std::sort(levels.begin(), levels.end());
    EXPECT_EQ(levels, (std::vector<os::Level>{os::fixed_level(0), os::fixed_level(1), os::fixed_level(2)}));
    EXPECT_FALSE(decision.plan);
  }
}

// As given, not as the situation has them.
TEST(Compared, ComputeTimesMayBeGiven) {
  const graph::App app = two_chains();
  const model::CostTable ten(app.graph, Millis{10});
  for (const char* method : {"picas", "deadline", "davare", "verucchi"}) {
    ASSERT_TRUE(is_baseline(method));
    EXPECT_TRUE(make_baseline(method, method, {}).policy->needs_costs());
    EXPECT_FALSE(make_baseline(method, "as written", ten).policy->needs_costs());
    EXPECT_EQ(make_baseline(method, "as written", ten).policy->name(), "as written");
    EXPECT_EQ(make_baseline(method, method, {}).reserve != nullptr, std::string(method) == "deadline");
  }
  const auto period = [&](const GivenCosts& given) {
    return decided("davare", app, given)->assignment.places.front().pacing.period;
  };
  EXPECT_GT(period(ten), period({}));
  EXPECT_FALSE(is_baseline("catan"));
}

}  // namespace
}  // namespace ctn::baselines
