// Which run a message is of, where programs do not just take messages from sockets: nodelets, which share them, and
// synchronizers of message_filters, which keep them. And which of a manager's nodelets a callback is of.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <iterator>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "ros1/test/programs.h"

namespace catan_ros {
namespace {

using std::chrono::seconds;

class LineageTest : public ProgramsTest {
 protected:
  std::vector<double> numbers(const std::string& name) const {
    std::istringstream text(text_of(path(name)));
    return {std::istream_iterator<double>(text), {}};
  }
  // The runs of `from` that runs of `node` took, in their order.
  std::vector<double> taken(const std::string& node, const std::string& from) {
    const std::string query =
        "SELECT consumed.last FROM consumed JOIN nodes AS reader ON reader.id = consumed.node JOIN nodes AS sender ON "
        "sender.id = consumed.predecessor WHERE reader.name = '" +
        node + "' AND sender.name = '" + from + "' ORDER BY consumed.run";
    wait(start("taken", "sqlite3 run.catan \"" + query + "\""), seconds{10});
    return numbers("taken.out");
  }
  // Camera and detector of one manager, each bound by its nodelet, and the detector's timer; with more nodes, edges,
  // objectives and bindings as text.
  void write_app_of_a_manager(const std::string& nodes = {}, const std::string& edges = {},
                              const std::string& objectives = {}, const std::string& bindings = {}) {
    write("app.yaml",
          R"(catan: 1
app: nodelets
nodes: { camera: { fallback_rate: 50Hz }, detect: { fallback_rate: 50Hz }, tick: { fallback_rate: 100Hz })" +
              nodes + " }\nedges: [ camera -> detect" + edges +
              " ]\nobjective: [ { response_time: [camera, detect], weight: 1 }, { period: tick, weight: 1 }" +
              objectives + " ]\nscheduler: { bootstrap: 300ms }\n");
    write("bind.yaml", R"(catan: 1
ros:
  camera: { node: /manager, nodelet: /camera, timer: 20ms }
  detect: { node: /manager, nodelet: /detector, topic: /images }
  tick: { node: /manager, nodelet: /detector, timer: 5ms }
)" + bindings);
  }
  // How many of `values` are among the runs.
  static double part_found(const std::vector<double>& values, const std::vector<double>& runs) {
    const std::set<double> known(runs.begin(), runs.end());
    const auto found =
        std::count_if(values.begin(), values.end(), [&](double value) { return known.count(value) > 0; });
    return static_cast<double>(found) / static_cast<double>(values.size());
  }
};

TEST_F(LineageTest, NodeletsShareMessagesAndRunsAreKnown) {
  write_app_of_nodelets("fallback_rate: 100Hz", "fallback_rate: 30Hz");
  write_script(std::string("exec ") + NODELETS + " --counts nodelets.json --log follow.log\n");
  const int run = start_under_catan("--scheduler default --json --seconds 3 --record run.catan -- ./launch.sh");
  ASSERT_EQ(wait(run, seconds{60}), 0) << text_of(path("run.err"));
  EXPECT_GT(counted("nodelets", "calls"), 30);
  EXPECT_EQ(counted("nodelets", "overlaps"), 0) << "of one nodelet";
  EXPECT_EQ(counted("nodelets", "copies"), 0);
  const Json report = Json::parse(text_of(path("run.out")));
  EXPECT_GT(node(report, "detect")["compute_ms"]["p50"].get<double>(), 4.5);
  EXPECT_GT(report["chains"][0]["response_ms"]["count"].get<long>(), 20);

  const std::vector<double> messages = numbers("follow.log");  // the camera's run
  const std::vector<double> runs = taken("detect", "camera");
  ASSERT_GT(messages.size(), 30U);
  EXPECT_GE(part_found(messages, runs), 0.9);
  EXPECT_TRUE(std::is_sorted(runs.begin(), runs.end())) << "never an older one";
  EXPECT_GT(static_cast<double>(taken("follow", "detect").size()), 0.9 * static_cast<double>(messages.size()));
}

TEST_F(LineageTest, ANodeletThatIsLoadedAgainIsTheNodeAgain) {
  write_app_of_a_manager();
  write_script(std::string("exec ") + NODELETS + " --counts nodelets.json --log follow.log --reload\n");
  const int run = start_under_catan("--scheduler default --json --seconds 4 --record run.catan -- ./launch.sh");
  ASSERT_EQ(wait(run, seconds{60}), 0) << text_of(path("run.err"));
  EXPECT_GT(counted("nodelets", "reloaded"), 4);
  EXPECT_EQ(counted("nodelets", "gone_inside"), 0) << "unloading waits for a run that is under way";
  EXPECT_EQ(counted("nodelets", "overlaps"), 0);
  EXPECT_THAT(text_of(path("run.err")), testing::Not(testing::HasSubstr("there is another callback")));
  const std::vector<double> messages = numbers("follow.log");
  ASSERT_GT(messages.size(), 30U);
  EXPECT_GE(part_found(messages, taken("detect", "camera")), 0.9) << "all that it made were runs of the node";
}

// Its destructor stops the timer, which waits for no call, and takes from the timer's callback what that uses.
TEST_F(LineageTest, ANodeletIsNotUnloadedInACallbackOfItsTimer) {
  write_app_of_a_manager();
  write_script(std::string("exec ") + NODELETS + " --counts nodelets.json --log follow.log --reload-at-work\n");
  const int run = start_under_catan("--scheduler default --seconds 4 -- ./launch.sh");
  ASSERT_EQ(wait(run, seconds{60}), 0) << text_of(path("run.err"));
  EXPECT_GT(counted("nodelets", "reloaded"), 4);
  EXPECT_EQ(counted("nodelets", "gone_inside"), 0);
  EXPECT_EQ(counted("nodelets", "overlaps"), 0);
}

// Both subscribe to /images and have a timer of 5 ms, in one manager.
TEST_F(LineageTest, NodeletsOfOneManagerAreBoundApart) {
  write_app_of_a_manager(", watch: { fallback_rate: 50Hz }", ", camera -> watch",
                         ", { response_time: [camera, watch], weight: 1 }",
                         "  watch: { node: /manager, nodelet: /watcher, topic: /images }\n");
  write_script(std::string("exec ") + NODELETS + " --counts nodelets.json --log follow.log --watcher\n");
  const int run = start_under_catan("--scheduler default --json --seconds 3 --record run.catan -- ./launch.sh");
  ASSERT_EQ(wait(run, seconds{60}), 0) << text_of(path("run.err"));
  EXPECT_EQ(counted("nodelets", "overlaps"), 0) << "of one nodelet, the watcher's timer is not bound";
  EXPECT_GT(counted("nodelets", "calls"), 30);
  EXPECT_GT(counted("nodelets", "watched"), 30);
  const Json report = Json::parse(text_of(path("run.out")));
  EXPECT_GT(node(report, "detect")["compute_ms"]["p50"].get<double>(), 4.5);
  EXPECT_LT(node(report, "watch")["compute_ms"]["p50"].get<double>(), 4.5);
  EXPECT_LT(node(report, "tick")["compute_ms"]["p50"].get<double>(), 4.5);
  EXPECT_GT(node(report, "tick")["runs"].get<long>(), 100);
  EXPECT_THAT(text_of(path("run.err")), testing::Not(testing::HasSubstr("there is another callback")));
  EXPECT_GT(taken("detect", "camera").size(), 30U);
  EXPECT_GT(taken("watch", "camera").size(), 30U);
}

TEST_F(LineageTest, WhatNodeletsAreIsInferredApart) {
  write_script(std::string("exec ") + NODELETS + " --counts nodelets.json --log follow.log --watcher\n");
  const std::string bind = std::string(CATAN_COMMAND) + " ros bind --seconds 3 -- ./launch.sh";
  ASSERT_EQ(wait(start("bind", bind), seconds{60}), 0) << text_of(path("bind.err"));
  const std::string app = text_of(path("app.yaml"));
  EXPECT_THAT(app, testing::AllOf(testing::HasSubstr("  camera: {"),
                                  testing::HasSubstr("ros: { node: /manager, nodelet: /camera, timer: 20ms } }"),
                                  testing::HasSubstr("ros: { node: /manager, nodelet: /detector, topic: /images } }"),
                                  testing::HasSubstr("ros: { node: /manager, nodelet: /watcher, topic: /images } }"),
                                  testing::HasSubstr("ros: { node: /manager, nodelet: /follower, topic: /things } }"),
                                  testing::HasSubstr("ros: { node: /manager, nodelet: /detector, timer: 5ms } }")));
  EXPECT_THAT(text_of(path("bind.err")), testing::Not(testing::HasSubstr("cannot be told")));
}

// A node that has several inputs is bound to one of them; its program keeps the others until it runs.
TEST_F(LineageTest, WhoFeedsANodeByAnotherTopicThanItsBoundOneGivesOutput) {
  write("app.yaml", R"(catan: 1
app: joined
nodes: { fast: { fallback_rate: 50Hz }, slow: { fallback_rate: 20Hz }, join: { fallback_rate: 25Hz } }
edges: [ fast -> join, slow -> join ]
objective: [ { response_time: [slow, join], weight: 1 }, { response_time: [fast, join], weight: 1 } ]
scheduler: { bootstrap: 300ms }
)");
  write("bind.yaml", R"(catan: 1
ros:
  fast: { node: /fast, timer: 20ms }
  slow: { node: /slow, timer: 50ms }
  join: { node: /join, topic: /fast_data }
)");
  write_launcher({"fast --timer 20 --out /fast_data", "slow --timer 50 --out /slow_data",
                  "join --in /fast_data --beside /slow_data --out /joined --counts join.json"});
  const int run = start_under_catan("--scheduler default --json --seconds 3 --record run.catan -- ./launch.sh");
  ASSERT_EQ(wait(run, seconds{60}), 0) << text_of(path("run.err"));
  EXPECT_GT(counted("join", "beside"), 20) << "it gets them";
  const Json report = Json::parse(text_of(path("run.out")));
  for (const Json& chain : report["chains"]) EXPECT_GT(chain["response_ms"]["count"].get<long>(), 20) << chain;
  EXPECT_GT(taken("join", "slow").size(), 20U);
}

// The value of a message is the number of the run that sent it.
TEST_F(LineageTest, WhatSynchronizersHaveKeptIsKnown) {
  write("app.yaml", R"(catan: 1
app: pairs
nodes:
  source: { fallback_rate: 100Hz }
  mirror: { fallback_rate: 25Hz }
  fuse: { fallback_rate: 20Hz }
  fuse_near: { fallback_rate: 20Hz }
edges: [ source -> mirror -> fuse, source -> fuse, mirror -> fuse_near, source -> fuse_near ]
objective: [ { response_time: [source, mirror, fuse], weight: 1 }, { period: fuse_near, weight: 1 } ]
scheduler: { bootstrap: 300ms }
)");
  write("bind.yaml", R"(catan: 1
ros:
  source: { node: /source, timer: 10ms }
  mirror: { node: /mirror, topic: /left }
  fuse: { node: /fuse, topic: /right }
  fuse_near: { node: /fuse_near, topic: /right }
)");
  const std::string filters = FILTERS;
  write_script(filters + " source &\n" + filters + " mirror &\n" + filters + " fuse fuse.log &\n" + filters +
               " fuse_near fuse_near.log &\nwait\n");
  const int run = start_under_catan("--scheduler default --json --seconds 3 --record run.catan -- ./launch.sh");
  ASSERT_EQ(wait(run, seconds{60}), 0) << text_of(path("run.err"));
  for (const std::string name : {"fuse", "fuse_near"}) {
    std::vector<double> lefts;
    const std::vector<double> values = numbers(name + ".log");
    for (std::size_t index = 0; index + 1 < values.size(); index += 2) lefts.push_back(values[index]);
    ASSERT_GT(lefts.size(), 20U) << name;
    // Newer ones of the source were there when the run began; what it used is known nevertheless.
    EXPECT_GE(part_found(lefts, taken(name, "source")), 0.9) << name;
    EXPECT_GT(taken(name, "mirror").size(), 20U) << name;
  }
}

}  // namespace
}  // namespace catan_ros
