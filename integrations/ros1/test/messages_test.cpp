// What `catan ros run` tells of bindings that cannot be, or name what is not there.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <string>

#include "ros1/test/programs.h"

namespace catan_ros {
namespace {

using std::chrono::seconds;
using testing::AllOf;
using testing::HasSubstr;

class MessagesTest : public ProgramsTest {
 protected:
  std::string told() const { return text_of(path("run.err")) + text_of(path("run.out")); }
};

// Else the laser would wait for the answer within its run, and the service for the end of that.
TEST_F(MessagesTest, AServiceBehindItsCallerIsRefusedBeforeAnythingStarts) {
  write("app.yaml", R"(catan: 1
app: asking
nodes: { ask: { fallback_rate: 10Hz }, answer: {} }
edges: [ ask -> answer ]
subchains: { both: [ask, answer] }
objective: [ { response_time: [ask, answer], weight: 1 } ]
)");
  write("bind.yaml", R"(catan: 1
ros:
  ask: { node: /client, timer: 100ms }
  answer: { node: /server, service: /question }
)");
  EXPECT_EQ(wait(start_under_catan("-- touch started"), seconds{20}), 2);
  EXPECT_THAT(told(),
              HasSubstr("bind.yaml:4:11: answer: ros.service: in subchain 'both' it is triggered behind 'ask'"));
  EXPECT_FALSE(std::filesystem::exists(path("started")));
}

TEST_F(MessagesTest, WhatIsThereIsToldBesideWhatIsMissing) {
  write("app.yaml", R"(catan: 1
app: half
nodes:
  gone: { fallback_rate: 20Hz }
  misspelt: { fallback_rate: 20Hz }
  mistimed: { fallback_rate: 20Hz }
  third: { fallback_rate: 20Hz }
objective: [ { period: gone, weight: 1 }, { period: misspelt, weight: 1 }, { period: mistimed, weight: 1 },
             { period: third, weight: 1 } ]
)");
  write("bind.yaml", R"(catan: 1
ros:
  gone: { node: /nobody, topic: /data }
  misspelt: { node: /worker, topic: /dada }
  mistimed: { node: /worker, timer: 50ms }
  third: { node: /feed, timer: 30Hz }
)");
  // As a program has it that asks for 1.0 / 30 seconds.
  write_launcher({"feed --timer 33.3333333 --out /data --counts feed.json",
                  "worker --timer 20 --in /data --beside /ticks --service /save"});
  const int run = start_under_catan("--scheduler default --seconds 13 -- ./launch.sh");
  EXPECT_EQ(wait(run, seconds{60}), 0) << told();
  EXPECT_THAT(told(), AllOf(HasSubstr("its ROS node /nobody has not come (there are /feed, /worker)"),
                            HasSubstr("/worker has not asked for a subscription of /dada in 10 s, which is to be node "
                                      "misspelt: it has subscriptions of /data, /ticks; timers of 100 ms (10 Hz), "
                                      "20 ms (50 Hz); services /save; the others go on"),
                            HasSubstr("/worker has not asked for a timer of 50 ms (20 Hz) in 10 s")));
  EXPECT_THAT(told(), HasSubstr("subchain third runs: all of its nodes have registered"))
      << "whose timer is found by its rate";
}

}  // namespace
}  // namespace catan_ros
