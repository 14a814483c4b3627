#include "os/linux/poller.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <set>
#include <thread>

#include "os/linux/forked_process.h"
#include "os/linux/linux_os.h"
#include "os/linux/process.h"
#include "os/testing/conformance.h"
#include "os/testing/requires_real_time.h"

namespace ctn::os {
namespace {

using namespace std::chrono_literals;
using conformance::kTimeout;
using testing::ElementsAre;
using testing::IsEmpty;

Descriptor event(unsigned count) { return Descriptor(::eventfd(count, EFD_CLOEXEC | EFD_NONBLOCK)); }

class PollerTest : public testing::Test {
 protected:
  TimePoint soon() { return os_->now() + kTimeout; }

  std::unique_ptr<Os> os_ = make_linux_os();
  std::unique_ptr<Poller> poller_ = Poller::make().value();
};

TEST_F(PollerTest, TellsWhoIsReadableAgainAndAgain) {
  const Descriptor quiet = event(0);
  const Descriptor loud = event(1);
  ASSERT_TRUE(poller_->add(quiet, 7).ok());
  ASSERT_TRUE(poller_->add(loud, Poller::kKeys - 1).ok());
  EXPECT_THAT(poller_->wait(kNever), ElementsAre(Poller::kKeys - 1));
  EXPECT_THAT(poller_->wait(soon()), ElementsAre(Poller::kKeys - 1));
  poller_->remove(loud);
  EXPECT_THAT(poller_->wait(os_->now() + 1ms), IsEmpty());
  ASSERT_TRUE(poller_->add(loud, 8).ok());
  EXPECT_THAT(poller_->wait(kNever), ElementsAre(8));
}

TEST_F(PollerTest, DeadlineIsNotEarlyAndPassesOnce) {
  const TimePoint deadline = os_->now() + 3ms;
  EXPECT_THAT(poller_->wait(deadline), IsEmpty());
  EXPECT_GE(os_->now(), deadline);
  EXPECT_THAT(poller_->wait(os_->now() - 1s), IsEmpty());
  EXPECT_THAT(poller_->wait(TimePoint{}), IsEmpty());
  EXPECT_THAT(poller_->wait(TimePoint{Nanos{-5}}), IsEmpty());
  const TimePoint later = os_->now() + 3ms;
  EXPECT_THAT(poller_->wait(later), IsEmpty());
  EXPECT_GE(os_->now(), later);
}

// Whose call takes no deadline.
TEST_F(PollerTest, OnAnOlderKernelDeadlinesAreTheSame) {
  poller_ = Poller::make(false).value();
  const TimePoint deadline = os_->now() + 3ms;
  EXPECT_THAT(poller_->wait(deadline), IsEmpty());
  EXPECT_GE(os_->now(), deadline);
  EXPECT_THAT(poller_->wait(os_->now() - 1s), IsEmpty());
  const Descriptor loud = event(1);
  ASSERT_TRUE(poller_->add(loud, 3).ok());
  EXPECT_THAT(poller_->wait(soon()), ElementsAre(3));
  EXPECT_THAT(poller_->wait(kNever), ElementsAre(3)) << "an earlier deadline is taken back";
  poller_->remove(loud);
  poller_->wake();
  EXPECT_THAT(poller_->wait(kNever), IsEmpty());
}

TEST_F(PollerTest, IsWokenFromAnyThreadOnce) {
  std::thread waker([&] {
    std::this_thread::sleep_for(5ms);
    poller_->wake();
    poller_->wake();
  });
  EXPECT_THAT(poller_->wait(kNever), IsEmpty());
  waker.join();
  poller_->wake();
  EXPECT_THAT(poller_->wait(kNever), IsEmpty());
  const TimePoint deadline = os_->now() + 3ms;
  EXPECT_THAT(poller_->wait(deadline), IsEmpty());
  EXPECT_GE(os_->now(), deadline);
}

TEST_F(PollerTest, WhoIsAddedMeanwhileIsHeard) {
  const Descriptor loud = event(1);
  std::thread adder([&] {
    std::this_thread::sleep_for(5ms);
    EXPECT_TRUE(poller_->add(loud, 9).ok());
  });
  EXPECT_THAT(poller_->wait(soon()), ElementsAre(9));
  adder.join();
}

TEST_F(PollerTest, NobodyIsStarved) {
  std::vector<Descriptor> all;
  for (Poller::Key key = 0; key < 200; ++key) {
    all.push_back(event(1));
    ASSERT_TRUE(poller_->add(all.back(), key).ok());
  }
  std::set<Poller::Key> heard;
  for (int i = 0; i < 8; ++i) {
    const auto& keys = poller_->wait(soon());
    EXPECT_LE(keys.size(), 64U);
    heard.insert(keys.begin(), keys.end());
  }
  EXPECT_EQ(heard.size(), 200U);
}

TEST_F(PollerTest, EndOfAProcessIsHeard) {
  ForkedProcess child([] { return ::pause(); });
  const Descriptor watched = watch_process(child.process());
  CATAN_REQUIRE(watched.valid(), "needs a kernel with pidfd_open (Linux 5.3)");
  ASSERT_TRUE(poller_->add(watched, 5).ok());
  EXPECT_THAT(poller_->wait(os_->now() + 2ms), IsEmpty());
  child.end(SIGKILL);
  EXPECT_THAT(poller_->wait(soon()), ElementsAre(5));
}

TEST_F(PollerTest, WhatCannotBeAddedIsAnError) {
  const Status added = poller_->add(Descriptor(), 1);
  ASSERT_FALSE(added.ok());
  EXPECT_EQ(added.error().kind(), ErrorKind::kEnvironment);
}

}  // namespace
}  // namespace ctn::os
