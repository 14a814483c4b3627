// What right bindings mean. What wrong ones in an app file are told is in tests/malformed.
#include "config/ros_binding.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "config/app_file.h"

namespace ctn::config {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

constexpr std::string_view kRosApp = R"(catan: 1
app: robot
nodes:
  scan: { ros: { node: /laser, timer: 50ms } }
  GL: { ros: { node: /localiser, topic: /scan } }
  GP: {}
  base: { external: true }
edges: [scan -> GL -> GP -> base]
objective: [{ response_time: [scan, GL, GP, base], weight: 1 }]
)";

graph::App ros_app() {
  auto app = parse_app(kRosApp, "app.yaml");
  EXPECT_TRUE(app.ok()) << app.error().message();
  return std::move(*app);
}

std::string refused(std::string_view bind_text) {
  const auto bindings = ros_bindings(kRosApp, "app.yaml", ros_app(), bind_text, "bind.yaml");
  return bindings.ok() ? "accepted" : bindings.error().message();
}

TEST(RosBinding, OfTheAppFile) {
  const graph::App app = ros_app();
  const auto bindings = ros_bindings(kRosApp, "app.yaml", app);
  ASSERT_TRUE(bindings.ok()) << bindings.error().message();
  ASSERT_EQ(bindings->size(), 2U);
  EXPECT_EQ((*bindings)[0].node, *app.graph.find_node("scan"));
  EXPECT_EQ((*bindings)[0].callback.kind, RosCallback::Kind::kTimer);
  EXPECT_EQ((*bindings)[0].callback.period, 50ms);
  EXPECT_EQ((*bindings)[1].callback.node, "/localiser");
  EXPECT_EQ((*bindings)[1].callback.kind, RosCallback::Kind::kTopic);
  EXPECT_EQ((*bindings)[1].callback.name, "/scan");
}

// Two nodelets of one manager take one topic.
TEST(RosBinding, NodeletsOfOneManagerAreToldApart) {
  constexpr std::string_view kBindFile =
      "catan: 1\nros:\n"
      "  scan: { node: /manager, nodelet: /camera, timer: 50ms }\n"
      "  GL: { node: /manager, nodelet: /left, topic: /scan }\n"
      "  GP: { node: /manager, topic: /scan }\n";
  const graph::App app = ros_app();
  const auto bindings = ros_bindings(kRosApp, "app.yaml", app, kBindFile, "bind.yaml");
  ASSERT_TRUE(bindings.ok()) << bindings.error().message();
  ASSERT_EQ(bindings->size(), 3U);
  EXPECT_EQ((*bindings)[0].callback.nodelet, "/camera");
  EXPECT_EQ((*bindings)[0].callback.kind, RosCallback::Kind::kTimer);
  EXPECT_EQ((*bindings)[1].callback.nodelet, "/left");
  EXPECT_EQ((*bindings)[2].callback.nodelet, "") << "whichever is the first";
  EXPECT_FALSE((*bindings)[1].callback.same_as((*bindings)[2].callback));

  const Status ros2 = check_without_nodelets(*bindings, app);
  ASSERT_FALSE(ros2.ok());
  EXPECT_THAT(ros2.error().message(),
              testing::AllOf(HasSubstr("bind.yaml:3:9: scan: ros.nodelet: ROS 2 has no nodelets"),
                             HasSubstr("bind.yaml:4:7: GL: ros.nodelet"), testing::Not(HasSubstr("bind.yaml:5"))));
  EXPECT_TRUE(check_without_nodelets({(*bindings)[2]}, app).ok());
}

TEST(RosBinding, CallbacksOfTopicsNeedInput) {
  const graph::App app = ros_app();
  const auto needs = [&](const char* name) { return app.graph.node(*app.graph.find_node(name)).needs_input; };
  EXPECT_TRUE(needs("GL"));
  EXPECT_FALSE(needs("scan")) << "a timer's";
  EXPECT_FALSE(needs("GP")) << "of no program of ROS";
  const auto bound = ros_bindings(kRosApp, "app.yaml", app,
                                  "catan: 1\nros:\n  GP: { node: /planner, topic: /pose }\n"
                                  "  GL: { node: /localiser, service: /localise }\n",
                                  "bind.yaml");
  ASSERT_TRUE(bound.ok()) << bound.error().message();
  EXPECT_THAT(nodes_needing_input(*bound), testing::ElementsAre(*app.graph.find_node("GP")));
}

TEST(RosBinding, FunctionsInTheirPlaceNeedNone) {
  const auto app = parse_app(kRosApp, "app.yaml", RunBy::kFunctions);
  ASSERT_TRUE(app.ok()) << app.error().message();
  for (const graph::Node& node : app->graph.nodes()) EXPECT_FALSE(node.needs_input) << node.name;
}

TEST(RosBinding, ABindFileComesFirst) {
  const graph::App app = ros_app();
  const auto bindings = ros_bindings(kRosApp, "app.yaml", app,
                                     "catan: 1\nros:\n  GP: { node: /planner, service: /plan }\n"
                                     "  GL: { node: /other, topic: /scan }\n",
                                     "bind.yaml");
  ASSERT_TRUE(bindings.ok()) << bindings.error().message();
  ASSERT_EQ(bindings->size(), 3U);
  EXPECT_EQ((*bindings)[1].callback.node, "/other");
  EXPECT_EQ((*bindings)[2].callback.kind, RosCallback::Kind::kService);
  EXPECT_EQ((*bindings)[2].callback.name, "/plan");
}

TEST(RosBinding, ATimerIsNamedByItsPeriodOrItsRate) {
  const auto period_of = [](const std::string& timer) {
    const auto bindings = ros_bindings(kRosApp, "app.yaml", ros_app(),
                                       "catan: 1\nros: { GP: { node: /p, timer: " + timer + " } }\n", "bind.yaml");
    EXPECT_TRUE(bindings.ok()) << bindings.error().message();
    return bindings.ok() ? bindings->back().callback.period : Nanos{0};
  };
  EXPECT_EQ(period_of("30Hz"), Nanos{33'333'333});
  EXPECT_EQ(period_of("33.333ms"), Nanos{33'333'000});
  EXPECT_THAT(refused("catan: 1\nros: { GP: { node: /p, timer: 0Hz } }\n"),
              HasSubstr("bind.yaml:2:31: ros.GP.timer: "));
}

// Whoever calls it waits for the answer, and in its subchain the service waits for whoever calls it.
TEST(RosBinding, AServiceBehindAnotherProgramInItsSubchainIsRefused) {
  constexpr std::string_view kApp = R"(catan: 1
app: robot
nodes: { scan: {}, GL: {}, GP: {} }
edges: [scan -> GL -> GP]
subchains: { all: [scan, GL, GP] }
objective: [{ response_time: [scan, GL, GP], weight: 1 }]
)";
  const auto app = parse_app(kApp, "app.yaml");
  ASSERT_TRUE(app.ok()) << app.error().message();
  const auto check = [&](std::string_view bind_text) {
    const auto bindings = ros_bindings(kApp, "app.yaml", *app, bind_text, "bind.yaml");
    EXPECT_TRUE(bindings.ok()) << bindings.error().message();
    const Status fits = bindings.ok() ? check_services(*bindings, *app) : Status(bindings.error());
    return fits.ok() ? "accepted" : fits.error().message();
  };
  EXPECT_THAT(check("catan: 1\nros:\n"
                    "  scan: { node: /laser, timer: 50ms }\n"
                    "  GP: { node: /planner, service: /plan }\n"),
              testing::AllOf(HasSubstr("bind.yaml:4:7: GP: ros.service: in subchain 'all' it is triggered behind "
                                       "'scan': if scan calls /plan, both wait for each other for ever"),
                             HasSubstr("leave 'GP' out of the subchain")));
  EXPECT_THAT(check("catan: 1\nros:\n"
                    "  GL: { node: /manager, nodelet: /one, topic: /scan }\n"
                    "  GP: { node: /manager, nodelet: /other, service: /plan }\n"),
              HasSubstr("behind 'GL'"));
  EXPECT_EQ(check("catan: 1\nros:\n"
                  "  scan: { node: /planner, service: /scan }\n"
                  "  GL: { node: /localiser, topic: /scan }\n"),
            "accepted")
      << "at the head of its subchain";
  EXPECT_EQ(check("catan: 1\nros:\n"
                  "  GL: { node: /planner, topic: /scan }\n"
                  "  GP: { node: /planner, service: /plan }\n"),
            "accepted")
      << "in one program data goes by memory";
}

// The planner may have any subchain follow any other, unless the app file says by what it is triggered.
TEST(RosBinding, AServiceThatOutputsOfItsCallerMayTriggerIsRefused) {
  const auto check = [](const std::string& service, const std::string& caller, const std::string& bound) {
    const std::string text = "catan: 1\napp: robot\nnodes: { scan: " + caller + ", GL: {}, GP: " + service +
                             " }\nedges: [scan -> GP, GL -> GP]\nsubchains: {}\n"
                             "objective: [{ response_time: [GL, GP], weight: 1 }]\n";
    const auto app = parse_app(text, "app.yaml");
    EXPECT_TRUE(app.ok()) << app.error().message();
    if (!app.ok()) return std::string();
    const auto bindings =
        ros_bindings(text, "app.yaml", *app,
                     "catan: 1\nros:\n  GP: { node: /planner, service: /plan }\n  " + bound + "\n", "bind.yaml");
    EXPECT_TRUE(bindings.ok()) << bindings.error().message();
    const Status fits = bindings.ok() ? check_services(*bindings, *app) : Status(bindings.error());
    return fits.ok() ? std::string("accepted") : fits.error().message();
  };
  const std::string gl = "GL: { node: /localiser, topic: /scan }";
  EXPECT_EQ(check("{}", "{}", gl),
            "bind.yaml:3:7: GP: ros.service: outputs of 'GL' may trigger it: if GL calls /plan, both wait for each "
            "other for ever; write trigger: time in nodes.GP");
  EXPECT_EQ(check("{ trigger: time }", "{}", gl), "accepted");
  EXPECT_EQ(check("{}", "{}", "GL: { node: /planner, topic: /scan }"), "accepted") << "of the same program";
  const std::string scan = "scan: { node: /laser, timer: 50ms }";
  const std::string unscheduled = "{ unscheduled: true, period: 50ms }";
  EXPECT_THAT(check("{}", unscheduled, scan), HasSubstr("outputs of 'scan' may trigger it"));
  EXPECT_THAT(check("{ trigger: arrival }", unscheduled, scan), HasSubstr("outputs of 'scan' may trigger it"));
  EXPECT_EQ(check("{ trigger: arrival }", unscheduled, gl), "accepted") << "GL cannot trigger it";
  EXPECT_EQ(check("{ trigger: time }", unscheduled, scan), "accepted");
}

TEST(RosBinding, WhatIsWrongWithABindFileIsToldWithItsPlace) {
  EXPECT_THAT(refused("catan: 1\nros: { none: { node: /a, topic: /b } }\n"),
              HasSubstr("bind.yaml:2:8: ros.none: app robot has no node 'none'"));
  EXPECT_THAT(refused("catan: 1\nros: { base: { node: /a, topic: /b } }\n"), HasSubstr("an external node"));
  EXPECT_THAT(
      refused("catan: 1\nros: { GP: { node: /localiser, topic: /scan }, GL: { node: /localiser, topic: /scan } }\n"),
      HasSubstr("nodes 'GP' and 'GL' are the same callback"));
  EXPECT_THAT(refused("catan: 1\nros: { GP: { node: planner, topic: /b } }\n"),
              HasSubstr("'planner' is not the full name of anything in ROS"));
  EXPECT_THAT(refused("catan: 1\nros: { GP: { node: /p, nodelet: proc, topic: /b } }\n"),
              HasSubstr("bind.yaml:2:33: ros.GP.nodelet: 'proc' is not the full name of anything in ROS"));
  EXPECT_THAT(refused("catan: 1\nros: { GP: { nodelet: /proc, topic: /b } }\n"), HasSubstr("the ROS node is missing"));
  EXPECT_THAT(refused("catan: 1\nros: { GP: { node: /p, topic: /b, timer: 1s } }\n"),
              HasSubstr("one of topic, timer and service"));
  EXPECT_THAT(refused("ros: {}\n"), HasSubstr("the version of the format is missing"));
  EXPECT_THAT(refused("catan: 1\n"), HasSubstr("the callbacks are missing"));
  EXPECT_THAT(refused("catan: 1\nros: { GP: { node: /p, topics: /b } }\n"), HasSubstr("topics"));
}

}  // namespace
}  // namespace ctn::config
