#include "runtime/report_check.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <limits>

#include "config/testing/apps.h"

namespace ctn::runtime {
namespace {

using namespace std::chrono_literals;

constexpr TimePoint kNow{10s};

class ReportCheckTest : public ::testing::Test {
 protected:
  record::Run run(std::uint64_t number, Nanos begin, Nanos end) const {
    record::Run run;
    run.node = node;
    run.number = number;
    run.begin = TimePoint{begin};
    run.end = TimePoint{end};
    run.cpu = end - begin;
    return run;
  }
  bool believes(record::Run said) { return check.accept(said, kNow); }

  graph::App app = tracker_app();
  NodeId node = *app.graph.find_node("detect");
  ReportCheck check{app.graph};
};

TEST_F(ReportCheckTest, BelievesRunsThatFollowEachOther) {
  EXPECT_TRUE(believes(run(1, 1s, 2s)));
  EXPECT_TRUE(believes(run(2, 2s, 3s)));
  EXPECT_TRUE(believes(run(9, 4s, 4s))) << "reports may be lost, and runs may cost nothing";
  EXPECT_EQ(check.rejected(), 0U);
}

TEST_F(ReportCheckTest, DisbelievesWhatCannotBe) {
  ASSERT_TRUE(believes(run(5, 1s, 2s)));
  EXPECT_FALSE(believes(run(5, 3s, 4s))) << "twice";
  EXPECT_FALSE(believes(run(4, 3s, 4s))) << "backwards";
  EXPECT_FALSE(believes(run(6, 1500ms, 4s))) << "two at once";
  EXPECT_FALSE(believes(run(6, 4s, 3s))) << "ended before it began";
  EXPECT_FALSE(believes(run(6, 3s, 11s))) << "in the future";
  EXPECT_FALSE(believes(run(std::numeric_limits<std::uint64_t>::max(), 3s, 4s)));
  record::Run lie = run(6, 3s, 4s);
  lie.cpu = 65s;
  EXPECT_FALSE(believes(lie));
  lie.cpu = Nanos{-1};
  EXPECT_FALSE(believes(lie));
  lie.cpu = 1s;
  lie.wait = 1001ms;
  EXPECT_FALSE(believes(lie)) << "longer than it took";
  lie.wait = Nanos{-1};
  EXPECT_FALSE(believes(lie));
  lie.wait = Nanos{0};
  lie.elapsed = 1001ms;
  EXPECT_FALSE(believes(lie)) << "longer than it took";
  lie.elapsed = Nanos{0};
  lie.threads = 2;
  EXPECT_FALSE(believes(lie)) << "more than max_threads";
  lie.threads = 0;
  EXPECT_FALSE(believes(lie));
  lie.threads = 1;
  lie.mode = 1;
  EXPECT_FALSE(believes(lie)) << "a mode that the node has not";
  EXPECT_EQ(check.rejected(), 14U);
  EXPECT_TRUE(believes(run(6, 3s, 4s))) << "nothing of it was kept";
}

TEST_F(ReportCheckTest, LeavesOutWhatCannotHaveBeenConsumed) {
  record::Run said = run(1, 1s, 2s);
  said.consumed = {{node, 5, 4}, {node, 1, 3}, {node, 1, std::numeric_limits<std::uint64_t>::max()}};
  ASSERT_TRUE(check.accept(said, kNow));
  ASSERT_EQ(said.consumed.size(), 1U);
  EXPECT_EQ(said.consumed[0].last, 3U);
}

TEST_F(ReportCheckTest, TakesNoMoreThanANodeCanRun) {
  std::int64_t believed = 0;
  for (std::uint64_t number = 1; number <= 3 * ReportCheck::kMaxRuns; ++number) {
    if (believes(run(number, Nanos(number), Nanos(number)))) ++believed;
  }
  EXPECT_LE(believed, 2 * ReportCheck::kMaxRuns);
}

// Whatever is said, what is believed is a history that could have been.
RC_GTEST_PROP(ReportCheckProperty, WhatIsAcceptedIsAHistory, ()) {
  const graph::App app = tracker_app();
  ReportCheck check(app.graph);
  std::uint64_t number = 0;
  TimePoint end{};
  for (int step = 0; step < 50; ++step) {
    record::Run run;
    run.node = *app.graph.find_node("plan");
    run.number = *rc::gen::oneOf(rc::gen::inRange<std::uint64_t>(0, 60), rc::gen::arbitrary<std::uint64_t>());
    run.begin =
        TimePoint{Nanos{*rc::gen::oneOf(rc::gen::inRange<std::int64_t>(0, 100), rc::gen::arbitrary<std::int64_t>())}};
    run.end =
        TimePoint{Nanos{*rc::gen::oneOf(rc::gen::inRange<std::int64_t>(0, 100), rc::gen::arbitrary<std::int64_t>())}};
    run.cpu = Nanos{*rc::gen::arbitrary<std::int64_t>()};
    run.mode = *rc::gen::inRange<std::uint32_t>(0, 2);
    if (!check.accept(run, TimePoint{1s})) continue;
    RC_ASSERT(run.number > number && run.begin >= end && run.end >= run.begin && run.end <= TimePoint{1s} + 1ms);
    RC_ASSERT(run.cpu >= Nanos{0} && run.mode == 0U);
    number = run.number;
    end = run.end;
  }
}

}  // namespace
}  // namespace ctn::runtime
