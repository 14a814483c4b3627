// The robot drives over a real roscore, its nodes in processes of their own, started by the launch file: with rates
// that are set by hand, and under Catan.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include <chrono>
#include <string>

#include "ros1/test/programs.h"

namespace catan_ros {
namespace {

using std::chrono::seconds;

class DriveOverRosTest : public ProgramsTest {
 protected:
  DriveOverRosTest() { ::setenv("ROS_PACKAGE_PATH", NAVIGATION_PACKAGES, 1); }

  std::string launch(const std::string& arguments) const {
    return "/usr/bin/python3 /usr/bin/roslaunch catan_navigation navigation.launch figures:=" + path("figures.json") +
           " " + arguments;
  }
  // A figure of the world's; negative: there was nothing to measure.
  double figure(const std::string& name) const {
    const Json document = Json::parse(text_of(path("figures.json")), nullptr, false);
    if (!document.is_object() || !document["figures"].contains(name)) return -1.0;
    const Json& value = document["figures"][name];
    return value.is_number() ? value.get<double>() : -1.0;
  }
  std::string told(const std::string& name) const {
    return text_of(path(name + ".out")) + text_of(path(name + ".err"));
  }
};

TEST_F(DriveOverRosTest, WithRatesSetByHandItDrivesWithoutCatan) {
  ASSERT_EQ(wait(start("launch", launch("seconds:=15")), seconds{60}), 0) << told("launch");
  // GM works five seconds after it has begun, and until then there is nowhere to go.
  EXPECT_GT(figure("way_m"), 0.3) << told("launch");
  EXPECT_GE(figure("contacts"), 0.0);
  // From a scan to a velocity: a period of LM and one of LP, or two each under load.
  EXPECT_GT(figure("scan_age_ms_mean"), 20.0);
  EXPECT_LT(figure("scan_age_ms_mean"), 800.0);
  EXPECT_GT(figure("staleness_ms_p95"), 0.0);
  EXPECT_THAT(told("launch"), testing::HasSubstr("way_m"));
}

// GP and the robot need each other: GM, which GP may follow, gives a map when there are new keyframes, and there are
// none before the robot moves, which needs a path. Which node follows which differs from plan to plan.
TEST_F(DriveOverRosTest, UnderCatanItHasAPathSoon) {
  const std::string package = std::string(NAVIGATION_PACKAGES) + "/catan_navigation";
  const int run = start("run", std::string(CATAN_COMMAND) + " ros run " + package + "/robot.yaml --bind " + package +
                                   "/bind.yaml --json --record run.catan -- " + launch("hand_set:=false seconds:=15"));
  ASSERT_EQ(wait(run, seconds{90}), 0) << told("run");
  EXPECT_GT(figure("way_m"), 0.3) << told("run");
  EXPECT_THAT(told("run"), testing::Not(testing::HasSubstr("node GP has not run")));
}

}  // namespace
}  // namespace catan_ros
