// `catan ros bind`: from programs that run to an app file that `catan plan` and `catan ros run` take as it is.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <filesystem>
#include <string>
#include <thread>

#include "ros1/test/programs.h"

namespace catan_ros {
namespace {

using std::chrono::seconds;
using testing::AllOf;
using testing::AnyOf;
using testing::HasSubstr;
using testing::Not;

class BindTest : public ProgramsTest {
 protected:
  int start_bind(const std::string& arguments) {
    return start("bind", std::string(CATAN_COMMAND) + " ros bind " + arguments);
  }
};

// And run, by the test of the commands in docs/ros1.md.
TEST_F(BindTest, WhatItWritesIsPlannedAsItIs) {
  write_launcher({"source --timer 20 --burn 1 --out /images --counts source.json",
                  "heavy --in /images --burn 30 --out /things --counts heavy.json",
                  "light --in /things --beside /orders --burn 2 --counts light.json"});
  write_talker("/orders", "Int64");
  start("talker", "/usr/bin/python3 talker.py");
  ASSERT_EQ(wait(start_bind("--seconds 3 -- ./launch.sh"), seconds{60}), 0) << text_of(path("bind.err"));
  const std::string app = text_of(path("app.yaml"));
  EXPECT_THAT(app,
              AllOf(HasSubstr("  source: { fallback_rate: 50Hz, max_rate: 50Hz, ros: { node: /source, timer: 20ms }"),
                    HasSubstr("  heavy: { ros: { node: /heavy, topic: /images } }   # std_msgs/Int64"),
                    HasSubstr("ros: { node: /light, topic: /things } }"), HasSubstr("# /orders of /talker"),
                    HasSubstr("  source_to_light.things: [source, heavy, light.things]\n"),
                    HasSubstr("response_time: [source, heavy, light.things]"),
                    AnyOf(HasSubstr("  light: [light.orders, light.things]\n"),
                          HasSubstr("  light: [light.things, light.orders]\n"))))
      << "its spinner calls one after the other";
  EXPECT_THAT(app, Not(HasSubstr("timer: 100ms"))) << "which does nothing";
  EXPECT_THAT(text_of(path("bind.err")), HasSubstr("not observed, so external where they take part: /talker (Python)"));

  const std::string plan =
      std::string(CATAN_COMMAND) + " plan app.yaml --costs costs.yaml --effort 0.1 --cores 2 --json";
  EXPECT_EQ(wait(start("plan", plan), seconds{60}), 0) << text_of(path("plan.err"));
  EXPECT_TRUE(Json::parse(text_of(path("plan.out")), nullptr, false).is_object());
}

// Of the newest message alone, half of them would be.
TEST_F(BindTest, OfTwoDriversNoMessageIsLost) {
  write_launcher({"left --timer 20 --out /joints --counts left.json",
                  "right --timer 20 --out /joints --counts right.json",
                  "reader --in /joints --out /state --counts reader.json"});
  ASSERT_EQ(wait(start_bind("--seconds 3 -- ./launch.sh"), seconds{60}), 0) << text_of(path("bind.err"));
  EXPECT_THAT(text_of(path("app.yaml")), AllOf(HasSubstr("  reader: { input: queue, "),
                                               HasSubstr("each message counts: /left, /right send them\n")));

  std::filesystem::remove(path("reader.json"));
  const int run = start("run", std::string(CATAN_COMMAND) + " ros run app.yaml --scheduler default -- ./launch.sh");
  ASSERT_TRUE(counts("reader", "calls", 100)) << text_of(path("run.err"));
  const auto sent = [&] { return counted("left", "calls") + counted("right", "calls"); };
  const long sent_before = sent();
  const long got_before = counted("reader", "calls");
  std::this_thread::sleep_for(seconds{4});
  EXPECT_GE(counted("reader", "calls") - got_before, (sent() - sent_before) * 9 / 10);
  end(run, SIGTERM);
}

TEST_F(BindTest, WhatWasSeenUntilItIsStoppedCounts) {
  write_launcher({"source --timer 20 --burn 1 --out /images --counts source.json"});
  const int bind = start_bind("--seconds 600 --output my+robot.yaml --costs robot.costs -- ./launch.sh");
  ASSERT_TRUE(counts("source", "calls", 20)) << text_of(path("bind.err"));
  EXPECT_EQ(end(bind, SIGINT), 0) << text_of(path("bind.err"));
  EXPECT_THAT(text_of(path("my+robot.yaml")), HasSubstr("app: my_robot\n"));
  EXPECT_THAT(text_of(path("robot.costs")), HasSubstr("source: { cost: "));
  EXPECT_THAT(text_of(path("bind.out")), HasSubstr("next: catan plan my+robot.yaml --costs robot.costs --cores N"));
}

TEST_F(BindTest, WhatIsWrongIsToldWithWhatToDo) {
  const std::string no_master = std::string("env ROS_MASTER_URI=http://localhost:1 ") + CATAN_COMMAND + " ros bind";
  EXPECT_EQ(wait(start("bind", no_master + " -- true"), seconds{20}), 1);
  EXPECT_THAT(text_of(path("bind.err")),
              HasSubstr("no ROS master answers at http://localhost:1; start roscore, or roslaunch"));
  EXPECT_EQ(wait(start_bind("-- ./nothing-of-that-name"), seconds{20}), 2);
  EXPECT_EQ(wait(start_bind("-- true"), seconds{20}), 1);
  EXPECT_THAT(text_of(path("bind.err")),
              HasSubstr("no callback of a roscpp program was called before COMMAND ended; "));

  write("app.yaml", "mine\n");
  EXPECT_EQ(wait(start_bind("-- touch started"), seconds{20}), 2);
  EXPECT_THAT(text_of(path("bind.err")), HasSubstr("'app.yaml' is there already; name another file with --output"));
  EXPECT_EQ(wait(start_bind("--costs app.yaml --overwrite -- touch started"), seconds{20}), 2);
  EXPECT_FALSE(std::filesystem::exists(path("started")));
  EXPECT_EQ(text_of(path("app.yaml")), "mine\n");
}

TEST_F(BindTest, ThatOnlyPythonRunsIsTold) {
  write_talker("/orders", "Int64");
  const int bind = start_bind("-- /usr/bin/python3 talker.py");
  for (int tries = 0; tries < 400 && !std::filesystem::exists(path("talks")); ++tries) {
    std::this_thread::sleep_for(Milliseconds{50});
  }
  EXPECT_EQ(end(bind, SIGINT), 1);
  EXPECT_THAT(text_of(path("bind.err")), HasSubstr("no callback of a roscpp program was called before it was stopped; "
                                                   "the master knows /talker (Python); "));
  EXPECT_FALSE(std::filesystem::exists(path("app.yaml")));
}

}  // namespace
}  // namespace catan_ros
