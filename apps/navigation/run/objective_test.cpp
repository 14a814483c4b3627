#include "run/objective.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <utility>

namespace ctn::navigation::run {
namespace {

using namespace std::chrono_literals;
using ::testing::DoubleNear;
using ::testing::ElementsAre;
using ::testing::Optional;

Summary responses(std::uint64_t count, double mean) { return {count, mean, mean, mean, mean, mean}; }

// A chain and a node's period, with weights 1 and 0.5.
Snapshot snapshot(Summary response, std::uint64_t runs, double rate) {
  Snapshot result;
  result.warmed_up = true;
  result.objective = {{"scan -> LM", 1.0, {}}, {"period of GL", 0.5, {}}};
  result.chains.push_back({{"scan", "LM"}, response, {}, {}, {}});
  result.nodes.push_back({"GL", responses(runs, 2.0), rate});
  return result;
}

TEST(Objective, IsTheWeightedSumOfMeans) {
  EXPECT_THAT(objective_of(snapshot(responses(40, 17.0), 100, 50.0)), Optional(17.0 + 0.5 * 20.0));
  EXPECT_FALSE(objective_of(snapshot({}, 100, 50.0))) << "no response";
  EXPECT_FALSE(objective_of(snapshot(responses(40, 17.0), 0, 0.0))) << "no run";
  EXPECT_FALSE(objective_of(Snapshot()));
}

TEST(Objective, OfAStretchIsOfWhatCameInIt) {
  ObjectiveByTime by_time;
  EXPECT_FALSE(by_time.due(9999ms));
  ASSERT_TRUE(by_time.due(10s));
  by_time.add(10s, snapshot(responses(10, 20.0), 100, 12.5));
  EXPECT_FALSE(by_time.due(19s));
  // Ten more responses, of 40 ms each; 200 more runs in 10 s.
  by_time.add(20s, snapshot(responses(20, 30.0), 300, 16.7));
  // None, though there are runs.
  by_time.add(30s, snapshot(responses(20, 30.0), 400, 14.3));
  EXPECT_THAT(by_time.values(), ElementsAre(std::nullopt, Optional(DoubleNear(40.0 + 0.5 * 50.0, 1e-9)), std::nullopt));
}

TEST(Objective, OfAStretchThatBeganInTheBootstrapIsNotTold) {
  ObjectiveByTime by_time;
  Snapshot early = snapshot(responses(10, 20.0), 100, 12.5);
  early.warmed_up = false;
  by_time.add(10s, std::move(early));
  by_time.add(20s, snapshot(responses(20, 30.0), 300, 16.7));
  EXPECT_THAT(by_time.values(), ElementsAre(std::nullopt, std::nullopt));
}

}  // namespace
}  // namespace ctn::navigation::run
