#include "common/binding.h"

#include <gtest/gtest.h>

namespace catan_ros {
namespace {

using namespace std::chrono_literals;

std::vector<Binding> some_bindings() {
  Binding scan{.node = "scan", .ros_node = "/laser", .kind = Binding::Kind::kTimer, .period = 50ms};
  scan.runs_by_itself = true;
  Binding match{.node = "GL", .ros_node = "/localiser", .name = "/scan"};
  match.takes_all = true;
  match.predecessors = {"scan", "odometry"};
  match.output_topics = {"/pose", "/map"};
  match.successors = {"GP", "NC"};
  Binding save{.node = "save", .ros_node = "/localiser", .kind = Binding::Kind::kService, .name = "/save"};
  save.always_gives_output = true;
  save.is_behind = true;
  Binding loop{.node = "show", .ros_node = "timewarp", .kind = Binding::Kind::kLoop};
  Binding turn{.node = "turn", .ros_node = "/manager", .nodelet = "/turn", .name = "/image"};
  return {scan, match, save, loop, turn};
}

TEST(Bindings, AreTheSameAsText) {
  const auto read = parse_bindings(to_text(some_bindings()));
  ASSERT_TRUE(read);
  EXPECT_EQ(*read, some_bindings());
  EXPECT_TRUE(parse_bindings("")->empty());
}

TEST(Bindings, OtherTextIsNone) {
  for (const char* text : {"GL", "GL\t/l\t-\ttopic\t/scan\t-\t-\t-", "GL\t/l\ttopic\t/scan\t-\t-\t-\t-",
                           "GL\t/l\t-\tsubject\t/scan\t-\t-\t-\t-", "GL\t/l\t-\ttimer\tsoon\t-\t-\t-\t-",
                           "GL\t/l\t-\ttimer\t-5\t-\t-\t-\t-", "GL\t/l\t-\ttopic\t/scan\tfast\t-\t-\t-"}) {
    EXPECT_FALSE(parse_bindings(text)) << text;
  }
}

TEST(Bindings, AreFoundByWhatTheFrameworkKnows) {
  const std::vector<Binding> own = bindings_of(some_bindings(), "/localiser");
  ASSERT_EQ(own.size(), 2U);
  EXPECT_EQ(find_named(own, Binding::Kind::kTopic, "/scan", ""), &own[0]);
  EXPECT_EQ(find_named(own, Binding::Kind::kService, "/save", ""), &own[1]);
  EXPECT_EQ(find_named(own, Binding::Kind::kService, "/scan", ""), nullptr);
  EXPECT_EQ(find_timer(own, 50ms, ""), nullptr);
  EXPECT_NE(find_timer(bindings_of(some_bindings(), "/laser"), 50ms, ""), nullptr);
}

// A program makes its timer of 1.0 / 30; people write what they like.
TEST(Bindings, ATimerIsFoundByItsPeriodToAThousandth) {
  const std::vector<Binding> own{{.node = "a", .ros_node = "/n", .kind = Binding::Kind::kTimer, .period = 33'333us},
                                 {.node = "b", .ros_node = "/n", .kind = Binding::Kind::kTimer, .period = 33'340us}};
  EXPECT_EQ(find_timer(own, 33'333'333ns, ""), &own[0]);
  EXPECT_EQ(find_timer(own, 33'340us, ""), &own[1]) << "which is exact";
  EXPECT_EQ(find_timer(own, 33'380us, ""), nullptr);
  EXPECT_EQ(find_timer(own, 33'290us, ""), nullptr);
}

TEST(Bindings, ThatNameANodeletAreOfThatOneAlone) {
  const std::vector<Binding> own{
      {.node = "any", .ros_node = "/manager", .name = "/image"},
      {.node = "turn", .ros_node = "/manager", .nodelet = "/turn", .name = "/image"},
      {.node = "tick", .ros_node = "/manager", .nodelet = "/turn", .kind = Binding::Kind::kTimer, .period = 50ms}};
  EXPECT_EQ(find_named(own, Binding::Kind::kTopic, "/image", "/turn"), &own[1]);
  EXPECT_EQ(find_named(own, Binding::Kind::kTopic, "/image", "/scale"), &own[0]) << "which names none";
  EXPECT_EQ(find_named(own, Binding::Kind::kTopic, "/image", ""), &own[0]);
  EXPECT_EQ(find_timer(own, 50ms, "/turn"), &own[2]);
  EXPECT_EQ(find_timer(own, 50ms, "/scale"), nullptr);
  EXPECT_EQ(find_timer(own, 50ms, ""), nullptr);
}

TEST(Bindings, WhatIsPublishedForSuccessorsIsOutput) {
  const std::vector<Binding> all = some_bindings();
  EXPECT_TRUE(all[1].gives_output_on("/pose"));
  EXPECT_FALSE(all[1].gives_output_on("/diagnostics"));
  EXPECT_TRUE(all[2].gives_output_on("/diagnostics")) << "no successor says what it takes";
}

}  // namespace
}  // namespace catan_ros
