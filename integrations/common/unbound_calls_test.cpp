#include "common/unbound_calls.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <thread>

namespace catan_ros {
namespace {

using namespace std::chrono_literals;

TEST(UnboundCallsTest, ThoseThatHaveBegunAreWaitedFor) {
  UnboundCalls calls;
  const std::atomic<bool> stop{false};
  calls.wait_for_ends(stop);  // there is none
  calls.begin();
  calls.begin();
  std::atomic<int> ended{0};
  std::thread other([&] {
    for (int call = 0; call < 2; ++call) {
      std::this_thread::sleep_for(5ms);
      const UnboundCalls::Ended at_end(calls);
      ++ended;
    }
  });
  calls.wait_for_ends(stop);
  EXPECT_EQ(ended, 2);
  other.join();
}

TEST(UnboundCallsTest, OneThatNeverEndsKeepsNobodyFromStopping) {
  UnboundCalls calls;
  std::atomic<bool> stop{false};
  calls.begin();
  std::thread other([&] {
    std::this_thread::sleep_for(5ms);
    stop.store(true);
  });
  calls.wait_for_ends(stop);
  other.join();
}

}  // namespace
}  // namespace catan_ros
