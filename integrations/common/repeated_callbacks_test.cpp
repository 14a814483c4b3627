#include "common/repeated_callbacks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "common/inferred_app.h"

namespace catan_ros {
namespace {

using namespace std::chrono_literals;
using std::chrono::nanoseconds;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

ObservedCallback subscription(const std::string& topic, nanoseconds first, int runs, nanoseconds cpu_time = 2ms) {
  ObservedCallback callback;
  callback.ros_node = "/detector";
  callback.name = topic;
  for (int run = 0; run < runs; ++run) callback.runs.push_back({1, first + run * 100ms, cpu_time, "/camera", {}});
  return callback;
}

TEST(RepeatedCallbacks, OnesThatCameOneAfterTheOtherAreOneWithAllRuns) {
  const MergedCallbacks merged =
      merge_repeated({subscription("/images", 10s, 3), subscription("/other", 1s, 4), subscription("/images", 1s, 5)});
  ASSERT_EQ(merged.callbacks.size(), 2U);
  ASSERT_EQ(merged.callbacks[0].runs.size(), 8U);
  EXPECT_EQ(merged.callbacks[0].runs.front().begin, 1s);
  EXPECT_EQ(merged.callbacks[0].runs.back().begin, 10s + 200ms);
  EXPECT_EQ(merged.callbacks[1].name, "/other");
  EXPECT_THAT(merged.remarks, ElementsAre(HasSubstr("/detector's subscription of /images is there more than once")));
}

TEST(RepeatedCallbacks, OnesThatAreThereAtATimeStayAsTheyAre) {
  const MergedCallbacks merged = merge_repeated(
      {subscription("/images", 1s, 5), subscription("/images", 10s, 3), subscription("/images", 1s + 50ms, 5)});
  EXPECT_EQ(merged.callbacks.size(), 3U);
  EXPECT_THAT(merged.remarks, IsEmpty());
}

TEST(RepeatedCallbacks, ThatOfANodeletIsNotItsNeighbours) {
  ObservedCallback one = subscription("/images", 1s, 3);
  one.nodelet = "/one";
  ObservedCallback other = subscription("/images", 10s, 3);
  other.nodelet = "/other";
  EXPECT_EQ(merge_repeated({one, other}).callbacks.size(), 2U);
}

// The first of them was there for a moment, and its runs are no measure of the others.
TEST(RepeatedCallbacks, TheNodeHasTheRunsAndCostsOfAllOfThem) {
  const InferredApp inferred =
      infer_app({subscription("/images", 1s, 2, 1ms), subscription("/images", 10s, 40, 20ms)}, {}, "robot");
  EXPECT_THAT(inferred.app, HasSubstr("topic: /images } }   # 42 runs\n"));
  EXPECT_THAT(inferred.costs, HasSubstr("detector: { cost: 20ms, typical: 20ms }"));
}

}  // namespace
}  // namespace catan_ros
