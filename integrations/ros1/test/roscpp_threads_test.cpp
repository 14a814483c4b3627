// What threads that roscpp makes for itself are scheduled as.
#include <gtest/gtest.h>

#include <chrono>
#include <cstdlib>
#include <string>
#include <thread>

#include "ros1/test/programs.h"

namespace catan_ros {
namespace {

using std::chrono::seconds;

using RoscppThreadsTest = ProgramsTest;

// Three nodelets in one process: each callback has a thread of its own, and what roscpp's network and timers do is for
// all of them.
TEST_F(RoscppThreadsTest, AreScheduledInAProgramWithSeveralNodes) {
  if (wait(start("allowed", "chrt --fifo 1 true"), seconds{10}) != 0) {
    GTEST_SKIP() << "needs the permission to set real-time levels";
  }
  write_app_of_nodelets("max_rate: 50Hz");
  write_script(std::string("echo $$ >process\nexec ") + NODELETS + " --counts nodelets.json --log follow.log\n");
  const int run = start_under_catan("--json --seconds 8 -- ./launch.sh");
  ASSERT_TRUE(counts("nodelets", "calls", 20)) << text_of(path("run.err"));
  // Real-time ones: the nodes' own, and more.
  constexpr long kNodes = 3;
  long real_time = 0;
  for (int look = 0; look < 20 && real_time <= kNodes; ++look) {
    wait(start("look", "sh -c 'ps -L -o cls= -p $(cat process) | grep -c -e FF -e RR'"), seconds{10});
    real_time = std::atol(text_of(path("look.out")).c_str());
    std::this_thread::sleep_for(std::chrono::milliseconds{100});
  }
  EXPECT_GT(real_time, kNodes);
  ASSERT_EQ(wait(run, seconds{60}), 0) << text_of(path("run.err"));
  EXPECT_GT(counted("nodelets", "calls"), 40);
}

}  // namespace
}  // namespace catan_ros
