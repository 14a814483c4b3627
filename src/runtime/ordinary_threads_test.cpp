#include "runtime/ordinary_threads.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "base/testing/times.h"

namespace ctn::runtime {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using testing::ElementsAre;
using testing::IsEmpty;

constexpr os::ThreadId kWorker{7};
constexpr os::ThreadId kHelper{8};

// Looks once in a period, at threads that wait and run for so long in between.
class OrdinaryThreadsTest : public testing::Test {
 protected:
  OrdinaryThreadsTest() { look(); }

  void passes(os::ThreadId thread, Nanos waited, Nanos ran) {
    for (OrdinaryThreads::Sample& sample : threads_) {
      if (sample.thread != thread) continue;
      sample.ready += waited;
      sample.cpu += ran;
    }
  }
  std::vector<OrdinaryThreads::Waiting> look() {
    now_ += OrdinaryThreads::kPeriod;
    return ordinary_.look(now_, threads_).threads;
  }
  // How often it is told in so many periods, in which the worker waits for so long each.
  int told_in(int periods, Nanos waited) {
    int told = 0;
    for (int period = 0; period < periods; ++period) {
      passes(kWorker, waited, milliseconds{10});
      told += look().empty() ? 0 : 1;
    }
    return told;
  }

  std::vector<OrdinaryThreads::Sample> threads_{{kWorker, seconds{100}, seconds{3}}, {kHelper, Nanos{0}, Nanos{0}}};
  TimePoint now_ = at(seconds{1000});
  OrdinaryThreads ordinary_;
};

TEST_F(OrdinaryThreadsTest, WhatWasBeforeTheFirstLookIsNotCounted) { EXPECT_THAT(look(), IsEmpty()); }

TEST_F(OrdinaryThreadsTest, MostOfTheTimeIsHalfOfItAndMore) {
  passes(kWorker, milliseconds{2499}, milliseconds{100});
  EXPECT_THAT(look(), IsEmpty());
  passes(kWorker, milliseconds{2500}, milliseconds{100});
  EXPECT_THAT(look(), ElementsAre(OrdinaryThreads::Waiting{kWorker, milliseconds{2500}, milliseconds{100}}));
}

TEST_F(OrdinaryThreadsTest, WhoSleepsOrRunsDoesNotWait) {
  passes(kHelper, Nanos{0}, seconds{5});
  EXPECT_THAT(look(), IsEmpty());
}

TEST_F(OrdinaryThreadsTest, TheLongestWaitIsToldFirst) {
  passes(kWorker, seconds{3}, seconds{1});
  passes(kHelper, seconds{4}, Nanos{0});
  EXPECT_THAT(look(), ElementsAre(OrdinaryThreads::Waiting{kHelper, seconds{4}, Nanos{0}},
                                  OrdinaryThreads::Waiting{kWorker, seconds{3}, seconds{1}}));
}

// A thread that got no CPU for 12 s: Linux counts all of it when the thread runs.
TEST_F(OrdinaryThreadsTest, AWaitThatBeganBeforeTheLastLookCountsFromThere) {
  EXPECT_THAT(look(), IsEmpty());
  passes(kWorker, seconds{12}, milliseconds{1});
  EXPECT_THAT(look(), ElementsAre(OrdinaryThreads::Waiting{kWorker, seconds{5}, milliseconds{1}}));
}

TEST_F(OrdinaryThreadsTest, IsToldOnceHoweverLongItLasts) { EXPECT_EQ(told_in(1000, seconds{4}), 1); }

TEST_F(OrdinaryThreadsTest, IsToldAgainWhenItHasEndedForHalfAMinuteAndComesBack) {
  EXPECT_EQ(told_in(2, seconds{4}), 1);
  EXPECT_EQ(told_in(5, seconds{2}), 0);
  EXPECT_EQ(told_in(1, seconds{4}), 0) << "it had ended for 25 s";
  EXPECT_EQ(told_in(6, seconds{2}), 0);
  EXPECT_EQ(told_in(2, seconds{4}), 1);
}

TEST_F(OrdinaryThreadsTest, ThreadsThatWaitByTurnsAreToldOfOnce) {
  int told = 0;
  for (int period = 0; period < 100; ++period) {
    passes(period % 2 == 0 ? kWorker : kHelper, seconds{4}, seconds{1});
    told += look().empty() ? 0 : 1;
  }
  EXPECT_EQ(told, 1);
}

TEST_F(OrdinaryThreadsTest, AThreadThatIsNewOrComesBackCountsFromThenOn) {
  const OrdinaryThreads::Sample fresh{os::ThreadId{9}, seconds{4}, Nanos{0}};
  threads_.push_back(fresh);
  EXPECT_THAT(look(), IsEmpty()) << "it may have waited long before";
  threads_.pop_back();
  EXPECT_THAT(look(), IsEmpty());
  threads_.push_back(fresh);
  threads_.back().ready = seconds{8};
  EXPECT_THAT(look(), IsEmpty()) << "a node had it meanwhile";
}

TEST_F(OrdinaryThreadsTest, AThreadWithTheNumberOfOneThatEndedIsAnother) {
  threads_.front() = {kWorker, seconds{104}, seconds{1}};
  EXPECT_THAT(look(), IsEmpty()) << "it has used less CPU time than the one before";
}

TEST(OrdinaryThreadsMessage, SaysWhoWaitsHowLongAndWhatToDo) {
  const OrdinaryThreads::News news{seconds{5},
                                   {{kHelper, milliseconds{4630}, milliseconds{180}}, {kWorker, seconds{3}, Nanos{0}}}};
  const auto name = [](os::ThreadId thread) { return std::string(thread == kWorker ? "worker" : "bad\n"); };
  EXPECT_EQ(notice_of("program planner", news, name),
            "threads of program planner that no node has wait for a CPU most of the time: nodes go before them. "
            "Of the last 5.0 s bad\\x0a (thread 8) waited for 4.6 s and ran for 0.2 s, worker (thread 7) waited for "
            "3.0 s and ran for 0.0 s. Bind what they do to a node, give the nodes a max_rate, or leave a CPU free of "
            "nodes (--cpus)");
}

TEST(OrdinaryThreadsMessage, NamesAFewOfMany) {
  OrdinaryThreads::News news{seconds{5}, {}};
  for (int thread = 1; thread <= 8; ++thread) news.threads.push_back({os::ThreadId{thread}, seconds{4}, Nanos{0}});
  const std::string text = notice_of("p", news, [](os::ThreadId) { return "pool"; });
  EXPECT_THAT(text, testing::HasSubstr("pool (thread 5) waited for 4.0 s and ran for 0.0 s, and 3 more. Bind"));
  EXPECT_THAT(text, testing::Not(testing::HasSubstr("thread 6")));
  EXPECT_THAT(notice_of("p", news, [](os::ThreadId) { return ""; }), testing::HasSubstr("5.0 s (thread 1) waited"));
}

}  // namespace
}  // namespace ctn::runtime
