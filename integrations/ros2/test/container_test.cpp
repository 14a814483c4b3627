// Components that nobody changed, loaded into the container: scheduled, left alone, and after the container has let go
// of them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <string>

#include <nlohmann/json.hpp>

#include "command_test.h"

namespace {

using ctn::test::Outcome;
using ctn::test::run_catan;
using nlohmann::json;
using testing::HasSubstr;

constexpr const char* kPair = R"(catan: 1
app: pair
nodes:
  talk: { fallback_rate: 50Hz, ros: { node: /talker, timer: 20ms } }
  listen: { ros: { node: /listener, topic: /numbers } }
edges: [talk -> listen]
subchains: { pair: [talk, listen] }
objective: [ { response_time: [talk, listen], weight: 1 } ]
)";

class ContainerTest : public testing::Test {
 protected:
  ContainerTest() {
    ::setenv("ROS_DOMAIN_ID", std::to_string(101 + ::getpid() % 100).c_str(), 1);
    ::setenv("ROS_LOCALHOST_ONLY", "1", 1);
    ::setenv("AMENT_PREFIX_PATH", (std::string(COMPONENTS_PREFIX) + ":" + before_).c_str(), 1);
    std::ofstream(folder_ + "pair.yaml") << kPair;
  }

  // `catan ros2 run`, for three seconds, of the container and what loads components.
  Outcome run(const std::string& scheduler, const std::string& container_options, const std::string& load_options) {
    std::ofstream(folder_ + "start.sh") << CONTAINER << " " << container_options << " &\n"
                                        << "container=$!\ntrap 'kill $container; wait $container; exit 0' TERM INT\n"
                                        << LOADER << " /ComponentManager catan_ros2_test " << load_options
                                        << " plain::Talker plain::Listener || echo 'not loaded' >&2\nwait $container\n";
    return run_catan("ros2 run pair.yaml --seconds 4 --json --scheduler " + scheduler + " -- sh start.sh", folder_);
  }
  static json node(const Outcome& outcome, const std::string& name) {
    const json report = json::parse(outcome.out, nullptr, false);
    EXPECT_TRUE(report.is_object()) << outcome.out << outcome.err;
    for (const json& one : report.is_object() ? report.value("nodes", json::array()) : json::array()) {
      if (one.value("node", one.value("name", "")) == name) return one;
    }
    ADD_FAILURE() << "no node " << name << " in " << outcome.out << outcome.err;
    return json::object();
  }

  const std::string folder_ = testing::TempDir();
  const std::string before_ = ::getenv("AMENT_PREFIX_PATH") != nullptr ? ::getenv("AMENT_PREFIX_PATH") : "";
};

TEST_F(ContainerTest, ComponentsAreScheduledUnchanged) {
  for (const char* options : {"", "--single-threaded"}) {
    const Outcome outcome = run("default", options, "");
    EXPECT_GT(node(outcome, "talk").value("runs", 0), 100) << outcome.err;
    EXPECT_GT(node(outcome, "listen").value("runs", 0), 100) << outcome.err;
    EXPECT_EQ(outcome.err.find("not loaded"), std::string::npos) << outcome.err;
  }
}

TEST_F(ContainerTest, MessagesWithinTheProcessReachTheirNode) {
  const Outcome outcome = run("default", "", "--intra-process");
  EXPECT_GT(node(outcome, "talk").value("runs", 0), 100) << outcome.err;
  EXPECT_GT(node(outcome, "listen").value("runs", 0), 50) << outcome.err;
}

TEST_F(ContainerTest, ComponentsThatAreLoadedAgainAreTheNodesAgain) {
  const Outcome outcome = run("default", "", "--again");
  EXPECT_GT(node(outcome, "listen").value("outputs", node(outcome, "listen").value("runs", 0)), 100) << outcome.err;
}

}  // namespace
