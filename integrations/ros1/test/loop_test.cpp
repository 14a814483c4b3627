// Programs that wait for callbacks in a loop of their own, under `catan ros run`.
#include <gtest/gtest.h>

#include <string>

#include "ros1/test/programs.h"

namespace catan_ros {
namespace {

class LoopTest : public ProgramsTest {
 protected:
  void start_with(const std::string& spinning, const std::string& rate) {
    write_app_of_work("fallback_rate: " + rate);
    write_binding_of_work("/worker");
    write_launcher({"feed --timer 5 --out /data", "worker --in /data --counts worker.json " + spinning});
    start_under_catan("--scheduler default -- ./launch.sh");
    ASSERT_TRUE(counts("worker", "calls", 20)) << text_of(path("run.err"));
  }
};

// It would work on what came up to ten seconds ago.
TEST_F(LoopTest, ItGoesOnWhenABoundCallbackWasCalled) {
  start_with("--loop-wait 10", "20Hz");
  EXPECT_TRUE(counts("worker", "worked", 40));
  EXPECT_EQ(counted("worker", "overlaps"), 0);
  EXPECT_LE(counted("worker", "worked"), counted("worker", "calls") + 1);
  EXPECT_LE(counted("worker", "loops"), 2 * counted("worker", "calls") + 5) << "and sleeps in between";
}

// ros::spin() has nothing to do then. It looks ten times a second whether to end, and as often calls a light timer.
TEST_F(LoopTest, RoscppsOwnLoopSleepsOn) {
  start_with("", "100Hz");
  ASSERT_GT(counted("worker", "sleeps"), 0);
  const long slept = counted("worker", "sleeps");
  const long called = counted("worker", "calls");
  ASSERT_TRUE(counts("worker", "calls", 300));
  EXPECT_LT(counted("worker", "sleeps") - slept, (counted("worker", "calls") - called) * 3 / 4);
}

}  // namespace
}  // namespace catan_ros
