// The threads that a program has more under `catan ros run`.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <string>

#include "ros1/test/programs.h"

namespace catan_ros {
namespace {

class ThreadsTest : public ProgramsTest {
 protected:
  // How many threads of programs under Catan have that name.
  int threads_called(const std::string& name) {
    wait(start("threads", "grep -slx " + name + " /proc/[0-9]*/task/[0-9]*/comm"), std::chrono::seconds{10});
    const std::string found = text_of(path("threads.out"));
    return static_cast<int>(std::count(found.begin(), found.end(), '\n'));
  }
};

// In a program of one node it would be a thread of the node's: one more whose CPU time each run looks at.
TEST_F(ThreadsTest, TheOneThatTellsWhatIsMissingEndsWhenAllIsThere) {
  write_app_of_work("fallback_rate: 20Hz");
  write_binding_of_work("/worker");
  write_launcher({"feed --timer 20 --out /data", "worker --in /data --counts worker.json"});
  start_under_catan("--scheduler default -- ./launch.sh");
  ASSERT_TRUE(counts("worker", "calls", 10, std::chrono::seconds{8})) << text_of(path("run.err"));
  EXPECT_EQ(threads_called("catan-missing"), 0);
  EXPECT_GE(threads_called("catan-link"), 1) << "else threads are not found by their names";
}

}  // namespace
}  // namespace catan_ros
