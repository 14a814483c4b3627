#include "common/asked_callbacks.h"

#include <gtest/gtest.h>

namespace catan_ros {
namespace {

using namespace std::chrono_literals;

Binding missing(const std::string& nodelet = {}) {
  return {.node = "work", .ros_node = "/worker", .nodelet = nodelet, .name = "/dada"};
}

TEST(AskedCallbacks, AreToldByKindEachOnce) {
  AskedCallbacks asked;
  EXPECT_EQ(asked.text_for(missing()), "it has no callbacks of topics, timers or services");
  asked.note(Binding::Kind::kTopic, "/ticks", "");
  asked.note_timer(33'333'333ns, "");
  asked.note(Binding::Kind::kTopic, "/data", "");
  asked.note(Binding::Kind::kTopic, "/data", "");
  EXPECT_EQ(asked.text_for(missing()), "it has subscriptions of /data, /ticks; timers of 33.3333 ms (30 Hz)");
  asked.note(Binding::Kind::kService, "/save", "");
  EXPECT_EQ(asked.text_for(missing()),
            "it has subscriptions of /data, /ticks; timers of 33.3333 ms (30 Hz); services /save");
}

TEST(AskedCallbacks, OfManySomeAreTold) {
  AskedCallbacks asked;
  for (char letter = 'a'; letter < 'a' + 15; ++letter) asked.note(Binding::Kind::kTopic, std::string("/") + letter, "");
  EXPECT_EQ(asked.text_for(missing()),
            "it has subscriptions of /a, /b, /c, /d, /e, /f, /g, /h, /i, /j, /k, /l and 3 more");
}

TEST(AskedCallbacks, OfANodeletThatIsNamedThoseOfItAlone) {
  AskedCallbacks asked;
  EXPECT_EQ(asked.text_for(missing("/proc")), "no callback of a nodelet is known there");
  asked.note(Binding::Kind::kTopic, "/images", "/proc");
  asked.note(Binding::Kind::kTopic, "/other", "/view");
  EXPECT_EQ(asked.text_for(missing("/proc")), "it has subscriptions of /images");
  EXPECT_EQ(asked.text_for(missing("/porc")), "of nodelets there are /proc, /view");
  EXPECT_EQ(asked.text_for(missing()), "it has subscriptions of /images, /other");
}

// A program may subscribe again and again for as long as it runs.
TEST(AskedCallbacks, OnceAllIsToldNothingIsKept) {
  AskedCallbacks asked;
  asked.note(Binding::Kind::kTopic, "/before", "");
  asked.finish();
  asked.note(Binding::Kind::kTopic, "/after", "/proc");
  asked.note_timer(20ms, "");
  EXPECT_EQ(asked.text_for(missing()), "it has no callbacks of topics, timers or services");
  EXPECT_EQ(asked.text_for(missing("/proc")), "no callback of a nodelet is known there");
}

}  // namespace
}  // namespace catan_ros
