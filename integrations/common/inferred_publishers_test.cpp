// Topics that several programs publish, in the app file that is inferred.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "common/inferred_app.h"

namespace catan_ros {
namespace {

using namespace std::chrono_literals;
using std::chrono::nanoseconds;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr int kMessages = 40;  // of each driver

ObservedCallback driver(const std::string& ros_node, nanoseconds first, const std::string& topic = "/joint_states") {
  ObservedCallback callback;
  callback.ros_node = ros_node;
  callback.kind = Binding::Kind::kTimer;
  callback.period = 20ms;
  for (int run = 0; run < kMessages; ++run) callback.runs.push_back({1, first + run * 20ms, 1ms, {}, {topic}});
  return callback;
}

// It is called with each message of both, wherever they come from.
ObservedCallback reader_of(const ObservedCallback& left, const ObservedCallback& right) {
  ObservedCallback callback;
  callback.ros_node = "/state";
  callback.name = "/joint_states";
  callback.type = "sensor_msgs/JointState";
  for (const ObservedCallback* const from : {&left, &right}) {
    for (const ObservedRun& run : from->runs) {
      callback.runs.push_back({2, run.begin + 1ms, 1ms, from->ros_node, {"/state"}});
    }
  }
  const auto earlier = [](const ObservedRun& a, const ObservedRun& b) { return a.begin < b.begin; };
  std::stable_sort(callback.runs.begin(), callback.runs.end(), earlier);
  return callback;
}

// Of the newest one a run would get either driver's, and the other's would be lost.
TEST(InferredPublishers, OfTwoDriversEachMessageCounts) {
  const ObservedCallback left = driver("/left", 1s);
  const ObservedCallback right = driver("/right", 1s + 500us);
  EXPECT_THAT(
      infer_app({left, right, reader_of(left, right)}, {}, "robot").app,
      HasSubstr("  state: { input: queue, fallback_rate: 101.217Hz, max_rate: 110Hz, ros: { node: /state, topic: "
                "/joint_states } }   # sensor_msgs/JointState, 80 runs; each message counts: /left, /right "
                "send them\n"));
}

TEST(InferredPublishers, SoItIsWhereTheyAreNotObserved) {
  const ObservedCallback left = driver("/left", 1s);
  const ObservedCallback right = driver("/right", 1s + 500us);
  EXPECT_THAT(infer_app({reader_of(left, right)}, {}, "robot").app, HasSubstr("  state: { input: queue, "));
  EXPECT_THAT(infer_app({left, reader_of(left, right)}, {}, "robot").app, HasSubstr("  state: { input: queue, "));
}

TEST(InferredPublishers, OfOneDriverTheNewestMessageCounts) {
  const ObservedCallback left = driver("/left", 1s);
  const ObservedCallback again = driver("/left", 5s);
  EXPECT_THAT(infer_app({left, again, reader_of(left, again)}, {}, "robot").app,
              AllOf(HasSubstr("node: /state"), Not(HasSubstr("queue")), Not(HasSubstr("each message counts"))));
}

}  // namespace
}  // namespace catan_ros
