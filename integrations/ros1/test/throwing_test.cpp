// Programs whose callbacks throw, under `catan ros run`.
#include <gtest/gtest.h>
#include <signal.h>

#include <string>

#include "ros1/test/programs.h"

namespace catan_ros {
namespace {

class ThrowingTest : public ProgramsTest {
 protected:
  // It catches what comes out of spinOnce(), and goes on.
  void catches_all_of(const std::string& callback, const std::string& worker) {
    write_app_of_work("fallback_rate: 50Hz");
    write_binding_of_work("/worker", "bind.yaml", callback);
    write_launcher(
        {"feed --timer 20 --out /data", "worker " + worker + " --spin-once --throw-every 5 --counts worker.json"});
    const int run = start_under_catan("--scheduler default -- ./launch.sh");
    EXPECT_TRUE(counts("worker", "thrown", 10)) << text_of(path("run.err"));
    EXPECT_GE(counted("worker", "calls"), 50) << "it is called again after each";
    EXPECT_EQ(counted("worker", "overlaps"), 0);
    EXPECT_EQ(end(run, SIGTERM), 128 + SIGTERM) << text_of(path("run.err"));
  }
};

TEST_F(ThrowingTest, WhatASubscriptionsCallbackThrowsTheProgramCatches) {
  catches_all_of("topic: /data", "--in /data");
}

TEST_F(ThrowingTest, WhatATimersCallbackThrowsTheProgramCatches) { catches_all_of("timer: 20ms", "--timer 20"); }

}  // namespace
}  // namespace catan_ros
