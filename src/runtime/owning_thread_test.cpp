#include "runtime/owning_thread.h"

#include <gtest/gtest.h>

#include <vector>

#include "os/fake/fake_os.h"

namespace ctn::runtime {
namespace {

using std::chrono::milliseconds;

class OwningThreadTest : public ::testing::Test {
 protected:
  using Steps = std::vector<TimePoint>;

  void start() {
    thread.start("steps", [this](Steps& steps) {
      EXPECT_TRUE(thread.is_current());
      while (thread.sleep_until(fake.now() + milliseconds{10})) steps.push_back(fake.now());
    });
  }

  os::FakeOs fake;
  OwningThread<Steps> thread{fake};
};

TEST_F(OwningThreadTest, ItsStateIsTheOwnersBeforeAndAfter) {
  thread.idle().push_back(TimePoint{});
  start();
  fake.sleep_until(TimePoint{milliseconds{25}});
  thread.request_stop();
  thread.join();
  EXPECT_EQ(thread.idle(), (Steps{TimePoint{}, TimePoint{milliseconds{10}}, TimePoint{milliseconds{20}}}));
  EXPECT_FALSE(thread.is_current());
}

TEST_F(OwningThreadTest, AWakeIsNotLostWhileItDoesNotSleep) {
  thread.wake();
  thread.start("steps", [this](Steps& steps) {
    while (thread.sleep_until(fake.now() + milliseconds{10})) {
      steps.push_back(fake.now());
      fake.sleep_until(fake.now() + milliseconds{2});
    }
  });
  fake.sleep_until(TimePoint{milliseconds{5}});
  thread.wake();
  fake.sleep_until(TimePoint{milliseconds{6}});
  thread.wake();
  fake.sleep_until(TimePoint{milliseconds{8}});
  thread.request_stop();
  thread.join();
  EXPECT_EQ(thread.idle(), (Steps{TimePoint{milliseconds{5}}, TimePoint{milliseconds{7}}}));
}

}  // namespace
}  // namespace ctn::runtime
