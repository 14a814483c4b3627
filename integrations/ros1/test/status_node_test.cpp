// `catan ros node` beside a real roscore, a real server and real programs; and sensors from a bag.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <string>
#include <thread>

#include "ros1/test/programs.h"

namespace catan_ros {
namespace {

using std::chrono::seconds;
using testing::HasSubstr;

constexpr const char* kWatchedApp = R"(catan: 1
app: watched
nodes:
  feed: { external: true }
  work: { fallback_rate: 20Hz, ros: { node: /work, topic: /data } }
  absent: { fallback_rate: 5Hz, ros: { node: /absent, topic: /data } }
edges: [ feed -> work, feed -> absent ]
objective:
  - { response_time: [feed, work], weight: 1, max: 500ms }
  - { period: absent, weight: 0.5 }
scheduler: { bootstrap: 300ms }
)";

class StatusNodeTest : public ProgramsTest {
 protected:
  StatusNodeTest() { write("app.yaml", kWatchedApp); }

  int serve() { return start("serve", std::string(CATAN_COMMAND) + " serve app.yaml --socket s"); }
  int show(const std::string& options) { return start("node", std::string(CATAN_COMMAND) + " ros node s " + options); }
  int join(const std::string& name, const std::string& arguments) {
    return start(name, std::string(CATAN_COMMAND) + " ros run app.yaml --socket s -- " + PLAIN_NODE + " " + name + " " +
                           arguments + " --counts " + name + ".json");
  }
  int listen() { return start("listen", std::string(STATUS_LISTENER) + " seen.json"); }
  int set(const std::string& settings) {
    return wait(start("set", std::string(STATUS_LISTENER) + " --set " + settings), seconds{20});
  }

  Json seen() const {
    const Json document = Json::parse(text_of(path("seen.json")), nullptr, false);
    return document.is_object() ? document : Json::object();
  }
  // Until what was published last is so.
  bool sees(const std::function<bool(const Json&)>& what, Milliseconds within = seconds{20}) const {
    const auto until = std::chrono::steady_clock::now() + within;
    while (std::chrono::steady_clock::now() < until) {
      if (what(seen())) return true;
      std::this_thread::sleep_for(Milliseconds{100});
    }
    return false;
  }
  static Json at(const Json& document, const std::string& pointer) {
    const Json::json_pointer to(pointer);
    return document.contains(to) ? document.at(to) : Json();
  }
};

TEST_F(StatusNodeTest, ToldAreTheStateThePlanAndResponseTimes) {
  serve();
  show("");
  listen();
  start_node("feed", "--timer 20 --out /data");
  join("work", "--in /data --burn 2");
  ASSERT_TRUE(sees([](const Json& told) {
    return at(told, "/diagnostics/catan: node work/message") == "runs" &&
           at(told, "/response_times").contains("/catan/response_time/feed_work/mean_ms");
  })) << seen()
      << text_of(path("node.err")) << text_of(path("serve.err"));
  const Json told = seen();
  EXPECT_EQ(at(told, "/diagnostics/catan: app/message").get<std::string>().substr(0, 18), "watched is running") << told;
  EXPECT_EQ(at(told, "/diagnostics/catan: node absent/level"), 2);
  EXPECT_EQ(at(told, "/diagnostics/catan: node absent/message"), "has not run");
  EXPECT_TRUE(at(told, "/diagnostics").contains("catan: chain feed -> work"));
  EXPECT_GT(at(told, "/response_times/~1catan~1response_time~1feed_work~1mean_ms").get<double>(), 1.0);
  EXPECT_EQ(at(told, "/live/app"), "watched");
  EXPECT_TRUE(sees([](const Json& all) { return all.contains("plan"); })) << "latched";
  EXPECT_EQ(at(told, "/settings/max_ms_feed_work"), 500.0);
  EXPECT_THAT(at(told, "/described/max_ms_feed_work").get<std::string>(), HasSubstr("feed -> work"));
  EXPECT_EQ(set("weight_feed_work=2"), 1) << "nothing can be changed unless that was asked for";
}

TEST_F(StatusNodeTest, SettingsAreChangedWhereThatIsAllowedAllOrNone) {
  serve();
  show("--allow-control");
  listen();
  start_node("feed", "--timer 20 --out /data");
  join("work", "--in /data --burn 2");
  ASSERT_TRUE(sees([](const Json& told) { return at(told, "/settings/weight_feed_work") == 1.0; }))
      << text_of(path("node.err"));
  EXPECT_EQ(set("weight_feed_work=2.5 max_ms_feed_work=0 min_rate_hz_work=4"), 0) << text_of(path("node.err"));
  EXPECT_TRUE(sees([](const Json& told) {
    return at(told, "/settings/weight_feed_work") == 2.5 && at(told, "/settings/max_ms_feed_work") == 0.0 &&
           at(told, "/settings/min_rate_hz_work") == 4.0;
  })) << seen();
  EXPECT_EQ(set("weight_feed_work=3 speed=1"), 1);
  EXPECT_THAT(text_of(path("node.err")), HasSubstr("there is no setting speed"));
  EXPECT_EQ(set("weight_feed_work=-1"), 1) << "the server refuses it";
  EXPECT_EQ(set("weight_feed_work=nan"), 1);
  EXPECT_EQ(at(seen(), "/settings/weight_feed_work"), 2.5);
}

TEST_F(StatusNodeTest, AnAppThatIsKilledIsToldAndFoundAgain) {
  show("");
  listen();
  ASSERT_TRUE(sees([](const Json& told) { return at(told, "/diagnostics/catan: app/level") == 2; }))
      << "there is none yet: " << text_of(path("node.err"));
  const int server = serve();
  ASSERT_TRUE(sees([](const Json& told) {
    return at(told, "/live/state") == "running" && at(told, "/diagnostics/catan: app/level") < 2;
  })) << seen();
  end(server, SIGKILL);
  ASSERT_TRUE(sees([](const Json& told) { return at(told, "/diagnostics/catan: app/message") == "watched is killed"; }))
      << seen();
  serve();
  EXPECT_TRUE(sees([](const Json& told) { return at(told, "/diagnostics/catan: app/level") < 2; }))
      << text_of(path("serve.err")) << text_of(path("node.err")) << seen();
}

// A node of roscpp stays unknown to a master that comes after the one that it registered with.
TEST_F(StatusNodeTest, RegistersWithANewMaster) {
  show("--allow-control");
  const int first = listen();
  const auto tells = [](const Json& told) { return at(told, "/diagnostics/catan: app/level") == 2; };
  ASSERT_TRUE(sees(tells)) << text_of(path("node.err"));
  end(first, SIGTERM);
  roscore().stop();
  std::filesystem::remove(path("seen.json"));
  roscore().start();
  listen();
  EXPECT_TRUE(sees(tells)) << text_of(path("node.err"));
  const std::string services =
      "/usr/bin/python3 -c \"import rosgraph; "
      "print(rosgraph.Master('/test').getSystemState()[2])\"";
  wait(start("services", services), seconds{20});
  EXPECT_THAT(text_of(path("services.out")), HasSubstr("/catan/set_parameters"));
}

// As a launch file starts it, in the package's folder.
TEST_F(StatusNodeTest, ALaunchFileStartsServerNodeAndPrograms) {
  write("robot.launch", R"(<launch>
  <include file="$(find catan)/launch/catan.launch">
    <arg name="app" value=")" +
                            path("app.yaml") + R"(" /><arg name="socket" value=")" + path("s") + R"(" />
  </include>
</launch>
)");
  ::setenv("ROS_PACKAGE_PATH", ROS1_PACKAGES, 1);
  ::setenv("PATH", (std::string(CATAN_FOLDER) + ":" + std::getenv("PATH")).c_str(), 1);
  const int launched = start("launch", "/usr/bin/python3 /usr/bin/roslaunch robot.launch");
  listen();
  EXPECT_TRUE(sees([](const Json& told) {
    return at(told, "/live/state") == "running" && at(told, "/diagnostics/catan: app/level") < 2;
  })) << seen()
      << text_of(path("launch.err")) << text_of(path("launch.out"));
  end(launched, SIGINT);
  EXPECT_FALSE(std::filesystem::exists(path("s"))) << "the server has ended in order";
}

// A bag's messages are as good as a sensor's.
TEST_F(StatusNodeTest, SensorsMayComeFromABag) {
  write("make_bag.py",
        "import rosbag, rospy, std_msgs.msg\n"
        "with rosbag.Bag('sensors.bag', 'w') as bag:\n"
        "    for number in range(200):\n"
        "        bag.write('/data', std_msgs.msg.Int64(number), rospy.Time(1.0 + number * 0.02))\n");
  ASSERT_EQ(wait(start("make", "/usr/bin/python3 make_bag.py"), seconds{20}), 0) << text_of(path("make.err"));
  serve();
  show("");
  listen();
  join("work", "--in /data --burn 2");
  start("play", "/usr/bin/python3 /usr/bin/rosbag play --loop sensors.bag");
  EXPECT_TRUE(counts("work", "calls", 60)) << text_of(path("play.err")) << text_of(path("play.out"));
  EXPECT_TRUE(sees([](const Json& told) {
    return at(told, "/response_times").contains("/catan/response_time/feed_work/p95_ms");
  })) << seen();
}

}  // namespace
}  // namespace catan_ros
