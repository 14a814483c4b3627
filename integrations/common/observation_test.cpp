#include "common/observation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

namespace catan_ros {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

ObservedCallback written_camera() {
  ObservedCallback callback;
  callback.ros_node = "/camera";
  callback.kind = Binding::Kind::kTimer;
  callback.period = 20ms;
  callback.runs = {{71, 5000ns, 1200ns, "", {"/images", "/info"}}, {71, 20'005'000ns, 1300ns, "", {}}};
  return callback;
}

ObservedCallback written_detector() {
  ObservedCallback callback;
  callback.ros_node = "/camera";
  callback.name = "/images";
  callback.type = "sensor_msgs/Image";
  callback.runs = {{72, 6000ns, 30'000'000ns, "/camera", {"/things"}}};
  return callback;
}

ObservedCallback written_nodelet() {
  ObservedCallback callback = written_detector();
  callback.nodelet = "/detector";
  callback.one_at_a_time = true;
  return callback;
}

class ObservationTest : public testing::Test {
 protected:
  ObservationTest() {
    folder = testing::TempDir() + "catan-observed-XXXXXX";
    EXPECT_NE(::mkdtemp(folder.data()), nullptr);
  }
  ~ObservationTest() override { std::filesystem::remove_all(folder); }

  std::string folder;
};

TEST_F(ObservationTest, WhatProgramsWroteIsReadBack) {
  const auto log = ObservationLog::open(folder, "/camera");
  ASSERT_NE(log, nullptr);
  const std::size_t first = log->add(written_camera());
  const std::size_t second = log->add(written_detector());
  log->add_run(first, written_camera().runs[0]);
  log->add_run(second, written_detector().runs[0]);
  log->add_run(first, written_camera().runs[1]);
  std::ofstream(folder + "/other.txt") << "node\t/other\ncallback\t0\ttopic\t/x\t-\n";
  EXPECT_THAT(read_observations(folder), ElementsAre(written_camera(), written_detector()));
}

TEST_F(ObservationTest, WhoseNodeletsCallbacksAreIsReadBack) {
  const auto log = ObservationLog::open(folder, "/camera");
  ASSERT_NE(log, nullptr);
  ObservedCallback side_by_side = written_nodelet();
  side_by_side.nodelet = "/tracker";
  side_by_side.one_at_a_time = false;
  side_by_side.runs.clear();
  log->add_run(log->add(written_nodelet()), written_nodelet().runs[0]);
  log->add(side_by_side);
  EXPECT_THAT(read_observations(folder), ElementsAre(written_nodelet(), side_by_side));
  EXPECT_EQ(program_of(side_by_side), "/tracker");
  EXPECT_EQ(program_of(written_detector()), "/camera");
  EXPECT_FALSE(of_one_program(side_by_side, written_nodelet()));
  EXPECT_FALSE(of_one_program(written_detector(), written_nodelet()));
}

TEST_F(ObservationTest, WithoutAFolderThereIsNone) {
  EXPECT_EQ(ObservationLog::open(folder + "/nowhere", "/camera"), nullptr);
  EXPECT_THAT(read_observations(folder + "/nowhere"), IsEmpty());
}

TEST(ParseObservations, WhatIsNotUnderstoodIsLeftOut) {
  const std::string text =
      "node\t/a\n"
      "\n"
      "callback\t0\tmusic\t/images\t-\n"
      "callback\t1\ttimer\tsoon\t-\n"
      "callback\t2\ttopic\t/images\t-\n"
      "callback\tx\ttopic\t/images\t-\n"
      "callback\t3\ttopic\t/images\t-\t/proc\n"
      "callback\t4\ttopic\t/images\t-\t/proc\tmany\n"
      "run\t7\t1\t2\t3\t-\t-\n"
      "run\t2\t1\t2\n"
      "run\t2\t1\t-2\t3\t-\t-\n"
      "run\t2\t1\t2\t3\t-\t-\n"
      "run\t2\t1\t5\t30";
  const auto callbacks = parse_observations(text);
  ASSERT_THAT(callbacks, SizeIs(1));
  EXPECT_EQ(callbacks[0].ros_node, "/a");
  EXPECT_EQ(callbacks[0].name, "/images");
  EXPECT_THAT(callbacks[0].runs, ElementsAre(ObservedRun{1, 2ns, 3ns, "", {}})) << "not the one that is torn";
}

}  // namespace
}  // namespace catan_ros
