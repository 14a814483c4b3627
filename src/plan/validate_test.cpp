// A valid plan passes; broken in one place, it fails with a complaint about that place.
#include "plan/validate.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <ostream>
#include <string>
#include <vector>

#include "base/numbers.h"
#include "plan/testing/sample_plan.h"

namespace ctn::plan {
namespace {

using testing::Contains;

std::vector<std::string> keys_of(const Status& status) {
  std::vector<std::string> keys;
  if (status) return keys;
  for (const Problem& problem : status.error().problems()) keys.push_back(problem.key);
  return keys;
}

struct Break {
  std::string name;
  std::string complaint;  // the key of the problem it must cause
  std::function<void(Plan&)> apply;
};

std::ostream& operator<<(std::ostream& out, const Break& broken) { return out << broken.name; }

class Broken : public testing::TestWithParam<Break> {};

TEST_P(Broken, IsNoticedWhereItIsBroken) {
  const graph::App app = sample_app();
  const model::CostTable costs = sample_costs(app);
  Plan plan = sample_plan(app, costs);
  GetParam().apply(plan);
  const Status status = validate(plan, app, costs, kSampleCores);
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().kind(), ErrorKind::kCaller);
  EXPECT_THAT(keys_of(status), Contains(GetParam().complaint)) << status.error().message();
}

SubchainPlan& of(Plan& plan, SubchainId id) { return plan.subchains[id.index()]; }

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

const std::vector<Break> kShape{
    {"SubchainMissing", "subchains", [](Plan& p) { p.subchains.pop_back(); }},
    {"CoreMissing", "cores", [](Plan& p) { p.cores.pop_back(); }},
    {"CoreTooMany", "cores", [](Plan& p) { p.cores.emplace_back(); }},
    {"NoPlanner", "planner", [](Plan& p) { p.planner.clear(); }},
    {"SlackOfOne", "slack", [](Plan& p) { p.slack = 1.0; }},
    {"SlackIsNoNumber", "slack", [](Plan& p) { p.slack = kNan; }},
    {"GapNegative", "gap", [](Plan& p) { p.gap = -0.1; }},
    {"OptimalWithAGap", "gap", [](Plan& p) { p.quality = Quality::kOptimal; }},
    {"ObjectiveInfinite", "objective", [](Plan& p) { p.objective = kInfinity; }},
    {"PeriodIsNoNumber", "subchains.fast.period_ms", [](Plan& p) { of(p, kFast).period = Millis{kNan}; }},
    {"SliceNegative", "subchains.slow.slice_ms", [](Plan& p) { of(p, kSlow).slice = Millis{-5}; }},
    {"ShareZero", "subchains.log.share", [](Plan& p) { of(p, kBatch).share = 0.0; }},
    {"EveryZero", "subchains.slow.every", [](Plan& p) { of(p, kSlow).every = 0; }},
    {"NoThread", "subchains.see.threads", [](Plan& p) { of(p, kSee).threads = 0; }},
    {"NoCore", "subchains.see.cores", [](Plan& p) { of(p, kSee).cores.clear(); }},
    {"CoreOutOfRange", "subchains.see.cores",
     [](Plan& p) {
       of(p, kSee).cores = {1, 3};
     }},
    {"CoreNegative", "subchains.see.cores",
     [](Plan& p) {
       of(p, kSee).cores = {-1, 1};
     }},
    {"CoresDescending", "subchains.see.cores",
     [](Plan& p) {
       of(p, kSee).cores = {2, 1};
     }},
    {"CoreTwice", "subchains.see.cores",
     [](Plan& p) {
       of(p, kSee).cores = {1, 1};
     }},
    {"SlotOfNoSubchain", "cores[0].slots[1].subchain", [](Plan& p) { p.cores[0].slots[1].subchain = SubchainId{9}; }},
    {"PhaseTooLate", "cores[0].slots[1].phase", [](Plan& p) { p.cores[0].slots[1].phase = 4; }},
    {"PhaseOfAQueueNode", "cores[0].slots[2].phase", [](Plan& p) { p.cores[0].slots[2].phase = 1; }},
};

const std::vector<Break> kCores{
    {"OwnerAlsoShares", "subchains.see.cores",
     [](Plan& p) {
       of(p, kSee).cores = {0, 1};
     }},
    {"CoreLeftEmptyWhileOthersAreShared", "cores[2]", [](Plan& p) { of(p, kSee).cores = {1}; }},
};

const std::vector<Break> kSharedCores{
    {"FrameTooShort", "cores[0].frame_ms", [](Plan& p) { p.cores[0].frame = Millis{19}; }},
    {"IdleChangesTheFrame", "cores[0].frame_ms", [](Plan& p) { p.cores[0].idle = Millis{3}; }},
    {"SlackChangesTheFrame", "cores[0].frame_ms", [](Plan& p) { p.slack = 0.0; }},
    {"SlotsOverlap", "cores[0].slots[1].offset_ms", [](Plan& p) { p.cores[0].slots[1].offset = Millis{5}; }},
    {"SlotSliceDiffers", "cores[0].slots[1].slice_ms", [](Plan& p) { p.cores[0].slots[1].slice = Millis{4}; }},
    {"SlotEveryDiffers", "cores[0].slots[1].every", [](Plan& p) { p.cores[0].slots[1].every = 5; }},
    {"SlotsOutOfOrder", "cores[0].slots", [](Plan& p) { std::swap(p.cores[0].slots[0], p.cores[0].slots[1]); }},
    {"SlotMissing", "cores[0].slots", [](Plan& p) { p.cores[0].slots.pop_back(); }},
    {"SlotTwice", "cores[0].slots", [](Plan& p) { p.cores[0].slots.push_back(p.cores[0].slots[2]); }},
    {"FrameMinBeyondTheFrame", "cores[0].frame_min_ms", [](Plan& p) { p.cores[0].frame_min = Millis{21}; }},
    {"FrameMinBreaksACap", "cores[0].frame_min_ms", [](Plan& p) { p.cores[0].frame_min = Millis{9}; }},
    {"SliceIsNotShareOfCost", "subchains.slow.slice_ms", [](Plan& p) { of(p, kSlow).slice = Millis{6}; }},
    {"ShareIsNoWholeFraction", "subchains.slow.share", [](Plan& p) { of(p, kSlow).share = 0.3; }},
    {"QueueNodeWithAnEvery", "subchains.log.every", [](Plan& p) { of(p, kBatch).every = 1; }},
    {"EveryMissing", "subchains.fast.every", [](Plan& p) { of(p, kFast).every.reset(); }},
    {"PeriodIsNotFrameByShare", "subchains.slow.period_ms", [](Plan& p) { of(p, kSlow).period = Millis{79}; }},
    {"ExecutionIsNotThePeriod", "subchains.slow.execution_ms", [](Plan& p) { of(p, kSlow).execution = Millis{20}; }},
    {"ThreadsOnASharedCore", "subchains.slow.threads", [](Plan& p) { of(p, kSlow).threads = 2; }},
    {"SliceBelowTheMinimum", "subchains.slow.slice_ms",
     [](Plan& p) {
       of(p, kSlow).every = p.cores[0].slots[1].every = 40;
       of(p, kSlow).share = 1.0 / 40;
       of(p, kSlow).slice = p.cores[0].slots[1].slice = Millis{0.5};
     }},
};

const std::vector<Break> kOwnedCores{
    {"OwnedCoreWithSlots", "cores[1].slots",
     [](Plan& p) {
       p.cores[1].slots.push_back({kSee, Millis{0}, Millis{20}, 1, 0});
     }},
    {"OwnedCoreWithAFrame", "cores[1].frame_ms", [](Plan& p) { p.cores[1].frame = Millis{10}; }},
    {"OwnedCoreWithAShortestFrame", "cores[2].frame_min_ms", [](Plan& p) { p.cores[2].frame_min = Millis{1}; }},
    {"OwnedCoreWithIdleTime", "cores[1].idle_ms", [](Plan& p) { p.cores[1].idle = Millis{3}; }},
    {"MoreThreadsThanCores", "subchains.see.threads", [](Plan& p) { of(p, kSee).threads = 3; }},
    {"OwnedPeriodTooShort", "subchains.see.period_ms", [](Plan& p) { of(p, kSee).period = Millis{10}; }},
    {"OwnedPeriodTooLong", "subchains.see.period_ms", [](Plan& p) { of(p, kSee).period = Millis{12}; }},
    {"OwnedExecutionTooShort", "subchains.see.execution_ms", [](Plan& p) { of(p, kSee).execution = Millis{10}; }},
    {"OwnedShareNotOne", "subchains.see.share", [](Plan& p) { of(p, kSee).share = 0.5; }},
};

const std::vector<Break> kPromises{
    {"CapBroken", "subchains.fast.period_ms", [](Plan& p) { of(p, kFast).period = Millis{9}; }},
    {"ChainMissing", "chains", [](Plan& p) { p.chains.pop_back(); }},
    {"ChainOfAnotherPath", "chains[0].path", [](Plan& p) { p.chains[0].path.pop_back(); }},
    {"LatencyTooGood", "chains[0].latency_ms", [](Plan& p) { p.chains[0].latency -= Millis{1e-6}; }},
    {"ChainPeriodTooGood", "chains[2].period_ms", [](Plan& p) { p.chains[2].period = Millis{1}; }},
    {"ResponseTooGood", "chains[1].response_time_ms", [](Plan& p) { p.chains[1].response = Millis{25}; }},
    {"ChainWeightDiffers", "chains[1].weight", [](Plan& p) { p.chains[1].weight = 5; }},
    {"NodeMissing", "nodes", [](Plan& p) { p.nodes.clear(); }},
    {"NodeDiffers", "nodes[0].node", [](Plan& p) { p.nodes[0].node = NodeId{0}; }},
    {"NodePeriodTooGood", "nodes[0].period_ms", [](Plan& p) { p.nodes[0].period = Millis{1}; }},
    {"NodeWeightDiffers", "nodes[0].weight", [](Plan& p) { p.nodes[0].weight = 5; }},
    {"ObjectiveTooGood", "objective", [](Plan& p) { p.objective *= 1.0 - 1e-8; }},
    {"BoundNotNamed", "relaxed.bounds", [](Plan& p) { p.relaxed.clear(); }},
    {"BoundThatHoldsNamed", "relaxed.bounds[1].bound",
     [](Plan& p) {
       p.relaxed.push_back({"nodes.map.min_rate", Millis{100}, Millis{80}});
     }},
    {"BoundNamedTwice", "relaxed.bounds[1].bound", [](Plan& p) { p.relaxed.push_back(p.relaxed[0]); }},
    {"BoundAskedDiffers", "relaxed.bounds[0].asked_ms", [](Plan& p) { p.relaxed[0].asked = Millis{26}; }},
    {"BoundPlannedDiffers", "relaxed.bounds[0].planned_ms", [](Plan& p) { p.relaxed[0].planned = Millis{26}; }},
    {"FactorTooSmall", "relaxed.factor", [](Plan& p) { p.relax_factor = 1.0; }},
    {"FactorTooLarge", "relaxed.factor", [](Plan& p) { p.relax_factor = 2.0; }},
};

std::string name_of(const testing::TestParamInfo<Break>& info) { return info.param.name; }

INSTANTIATE_TEST_SUITE_P(Shape, Broken, testing::ValuesIn(kShape), name_of);
INSTANTIATE_TEST_SUITE_P(Cores, Broken, testing::ValuesIn(kCores), name_of);
INSTANTIATE_TEST_SUITE_P(SharedCores, Broken, testing::ValuesIn(kSharedCores), name_of);
INSTANTIATE_TEST_SUITE_P(OwnedCores, Broken, testing::ValuesIn(kOwnedCores), name_of);
INSTANTIATE_TEST_SUITE_P(Promises, Broken, testing::ValuesIn(kPromises), name_of);

TEST(Validate, AcceptsTheSamplePlan) {
  const graph::App app = sample_app();
  const model::CostTable costs = sample_costs(app);
  const Status status = validate(sample_plan(app, costs), app, costs, kSampleCores);
  EXPECT_TRUE(status.ok()) << status.error().message();
}

TEST(Validate, FramesMayBeFixedForNoReason) {
  const graph::App app = sample_app();
  const model::CostTable costs = sample_costs(app);
  Plan plan = sample_plan(app, costs);
  plan.cores[0].frames = graph::FrameMode::kFixed;
  EXPECT_TRUE(validate(plan, app, costs, kSampleCores).ok());
}

TEST(Validate, NeedsTheCostsThatThePlanWasMadeFor) {
  const graph::App app = sample_app();
  model::CostTable costs = sample_costs(app);
  const Plan plan = sample_plan(app, costs);
  costs.set(*app.graph.find_node("map"), model::CostProfile::constant(Millis{21}));
  EXPECT_THAT(keys_of(validate(plan, app, costs, kSampleCores)), Contains("subchains.slow.slice_ms"));
}

TEST(Validate, ReportsAllViolationsAtOnce) {
  const graph::App app = sample_app();
  const model::CostTable costs = sample_costs(app);
  Plan plan = sample_plan(app, costs);
  plan.objective += 1.0;
  plan.cores[0].slots[1].offset = Millis{5};
  plan.subchains[kSee.index()].share = 0.5;
  const auto keys = keys_of(validate(plan, app, costs, kSampleCores));
  EXPECT_THAT(keys, Contains("objective"));
  EXPECT_THAT(keys, Contains("cores[0].slots[1].offset_ms"));
  EXPECT_THAT(keys, Contains("subchains.see.share"));
}

// steer at exactly 50 Hz is what the sample plans anyway; but then its core's frames are fixed.
TEST(Validate, AnExactRateFixesTheFramesOfItsCore) {
  graph::AppSpec spec = sample_spec();
  node(spec, "steer").min_rate = node(spec, "steer").max_rate = graph::At<Rate>{Rate{50.0}, {}};
  const graph::App app = graph::build_app(spec).value();
  const model::CostTable costs = sample_costs(app);
  Plan plan = sample_plan(app, costs);
  EXPECT_THAT(keys_of(validate(plan, app, costs, kSampleCores)), Contains("cores[0].frames"));
  plan.cores[0].frames = graph::FrameMode::kFixed;
  const Status status = validate(plan, app, costs, kSampleCores);
  EXPECT_TRUE(status.ok()) << status.error().message();
}

TEST(Validate, AnExactRateIsMetExactly) {
  graph::AppSpec spec = sample_spec();
  node(spec, "steer").min_rate = node(spec, "steer").max_rate = graph::At<Rate>{Rate{60.0}, {}};
  const graph::App app = graph::build_app(spec).value();
  const model::CostTable costs = sample_costs(app);
  Plan plan = sample_plan(app, costs);
  plan.cores[0].frames = graph::FrameMode::kFixed;
  EXPECT_THAT(keys_of(validate(plan, app, costs, kSampleCores)), Contains("subchains.fast.period_ms"));
}

TEST(Validate, AWholeRunMayBeShorterThanTheLeastSlice) {
  const graph::App app = sample_app();
  model::CostTable costs = sample_costs(app);
  costs.set(*app.graph.find_node("log"), model::CostProfile::constant(Millis{0.4}));
  Plan plan = sample_plan(app, costs);
  // 1.5 runs of 0.4 ms are less than 1 ms; the time that is left becomes idle time.
  plan.subchains[kBatch.index()].slice = plan.cores[0].slots[2].slice = Millis{0.4 * 1.5};
  plan.subchains[kBatch.index()].execution = plan.cores[0].frame + Millis{0.4 - 0.4 * 1.5};
  plan.cores[0].idle = Millis{2 + 6 - 0.4 * 1.5};
  const Status status = validate(plan, app, costs, kSampleCores);
  EXPECT_TRUE(status.ok()) << status.error().message();
}

}  // namespace
}  // namespace ctn::plan
