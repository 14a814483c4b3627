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

  static std::string in_package(const std::string& file) {
    return std::string(NAVIGATION_PACKAGES) + "/catan_navigation/" + file;
  }
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
  // How many runs of `from` were taken by runs of `node`.
  long taken(const std::string& node, const std::string& from) {
    const std::string query =
        "SELECT COUNT(DISTINCT consumed.last) FROM consumed JOIN nodes AS reader ON reader.id = consumed.node JOIN "
        "nodes "
        "AS sender ON sender.id = consumed.predecessor WHERE reader.name = '" +
        node + "' AND sender.name = '" + from + "'";
    wait(start("taken", "sqlite3 run.catan \"" + query + "\""), seconds{10});
    const std::string text = text_of(path("taken.out"));
    return text.empty() ? -1 : std::stol(text);
  }
};

TEST_F(DriveOverRosTest, WithRatesSetByHandItDrivesWithoutCatan) {
  ASSERT_EQ(wait(start("launch", launch("seconds:=6")), seconds{60}), 0) << told("launch");
  EXPECT_GT(figure("way_m"), 0.5) << told("launch");
  EXPECT_GE(figure("contacts"), 0.0);
  // From a scan to a velocity: a period of LM and one of LP, or two each under load.
  EXPECT_GT(figure("scan_age_ms_mean"), 20.0);
  EXPECT_LT(figure("scan_age_ms_mean"), 800.0);
  EXPECT_GT(figure("staleness_ms_p95"), 0.0);
  EXPECT_THAT(told("launch"), testing::HasSubstr("way_m"));
}

TEST_F(DriveOverRosTest, UnderCatanEachNodeIsScheduledAndItsDataIsFollowedThroughTopics) {
  const int run = start("run", std::string(CATAN_COMMAND) + " ros run " + in_package("robot.yaml") + " --bind " +
                                   in_package("bind.yaml") + " --json --record run.catan -- sh -c 'exec " +
                                   launch("hand_set:=false seconds:=9") + " > launch.out'");
  ASSERT_EQ(wait(run, seconds{90}), 0) << told("run");
  EXPECT_GT(figure("way_m"), 0.5) << told("run");
  EXPECT_GT(figure("staleness_ms_p95"), 0.0);

  const Json report = Json::parse(text_of(path("run.out")));
  for (const char* const name : {"laser", "odometry", "scan", "LM", "LP", "GL", "GM", "GP", "NC"}) {
    EXPECT_GT(node(report, name)["compute_ms"]["count"].get<long>(), 2) << name << "\n" << told("run");
    EXPECT_THAT(text_of(path("run.err")), testing::Not(testing::HasSubstr(std::string("node ") + name + " has not")));
  }
  ASSERT_EQ(report["chains"].size(), 4U);
  for (const Json& chain : report["chains"]) EXPECT_GT(chain["response_ms"]["count"].get<long>(), 0) << chain;

  // What is published for the topic that the next node is bound to, and what it keeps of others.
  EXPECT_GT(taken("scan", "laser"), 50);
  EXPECT_GT(taken("LM", "scan"), 50);
  EXPECT_GT(taken("LM", "odometry"), 50) << "kept";
  EXPECT_GT(taken("LP", "LM"), 50);
  EXPECT_GT(taken("LP", "NC"), 10) << "kept";
  EXPECT_GT(taken("GL", "scan"), 50);
  EXPECT_GT(taken("GM", "GL"), 0);
  EXPECT_GT(taken("GP", "GM"), 0) << "kept";
  EXPECT_GT(taken("GP", "GL"), 2);
  EXPECT_GT(taken("NC", "GP"), 0) << "kept";
  EXPECT_GT(taken("NC", "GL"), 10);

  // A velocity is as old as the record says, by the stamps that went along: to the world and back it is further.
  const double latency = report["chains"][0]["latency_ms"]["mean"].get<double>();
  EXPECT_GT(figure("scan_age_ms_mean"), 0.5 * latency);
  EXPECT_LT(figure("scan_age_ms_mean"), 2.0 * latency + 30.0);
}

}  // namespace
}  // namespace catan_ros
