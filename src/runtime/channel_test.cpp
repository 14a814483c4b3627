#include "catan/channel.h"

#include <gtest/gtest.h>

#include <thread>
#include <vector>

#include "base/run_access.h"

namespace ctn {
namespace {

Run run_number(std::uint64_t number, std::size_t inputs) {
  Run run;
  RunAccess::reset(run, number, inputs);
  return run;
}

template <class C, class T>
void write_in_run(C& channel, std::uint64_t number, T value, Nanos origin = Nanos{0}) {
  auto run = run_number(number, 0);
  channel.write(run, value);
  RunAccess::finish_writes(run, origin);
}

// The one input of a node, named "from".
std::vector<RunAccess::InputEdge> input_of(ChannelBase& channel, bool queue, Nanos max_age = ctn::Run::kNoInput,
                                           bool skips = false) {
  RunAccess::InputEdge edge;
  edge.from = "from";
  edge.queue = queue;
  edge.channel = &channel;
  edge.max_age = max_age;
  edge.skips = skips;
  return {edge};
}

Run run_at(std::uint64_t number, Nanos begin, const std::vector<RunAccess::InputEdge>& edges) {
  Run run = run_number(number, 1);
  RunAccess::begin(run, TimePoint{begin}, edges);
  return run;
}

TEST(Channel, GivesNothingBeforeTheFirstWrite) {
  Channel<int> channel(0);
  auto reader = run_number(1, 1);
  EXPECT_EQ(channel.read(reader), nullptr);
  EXPECT_EQ(RunAccess::inputs(reader)[0].first, 0U);
}

TEST(Channel, PublishesWhenTheRunEnds) {
  Channel<int> channel(0);
  auto writer = run_number(5, 0);
  channel.write(writer, 7);
  auto early = run_number(1, 1);
  EXPECT_EQ(channel.read(early), nullptr);
  RunAccess::finish_writes(writer);
  auto late = run_number(2, 1);
  ASSERT_NE(channel.read(late), nullptr);
  EXPECT_EQ(*channel.read(late), 7);
  EXPECT_EQ(RunAccess::inputs(late)[0].last, 5U) << "the run consumed run 5 of its predecessor";
}

TEST(Channel, GivesTheNewestAndTheSameThroughoutARun) {
  Channel<int> channel(0);
  write_in_run(channel, 1, 10);
  write_in_run(channel, 2, 20);
  auto reader = run_number(1, 1);
  EXPECT_EQ(*channel.read(reader), 20);
  write_in_run(channel, 3, 30);
  EXPECT_EQ(*channel.read(reader), 20);
  auto next = run_number(2, 1);
  EXPECT_EQ(*channel.read(next), 30);
}

TEST(Channel, DiscardsWhatASkippedRunWrote) {
  Channel<int> channel(0);
  write_in_run(channel, 1, 10);
  auto writer = run_number(2, 0);
  channel.write(writer, 20);
  writer.skip_output();
  RunAccess::finish_writes(writer);
  auto reader = run_number(1, 1);
  EXPECT_EQ(*channel.read(reader), 10);
}

TEST(Channel, NeverTearsAValueNorGoesBack) {
  struct Pair {
    std::uint64_t a = 0;
    std::uint64_t b = 0;
  };
  constexpr std::uint64_t kRuns = 200000;
  Channel<Pair> channel(0);
  std::thread writer([&] {
    for (std::uint64_t number = 1; number <= kRuns; ++number) {
      write_in_run(channel, number, Pair{number, number}, Nanos{static_cast<Nanos::rep>(number)});
    }
  });
  std::uint64_t last = 0;
  for (std::uint64_t number = 1; last < kRuns; ++number) {
    auto run = run_number(number, 1);
    const Pair* pair = channel.read(run);
    if (pair == nullptr) continue;
    ASSERT_EQ(pair->a, pair->b);
    ASSERT_EQ(pair->a, RunAccess::inputs(run)[0].last);
    ASSERT_EQ(Nanos{static_cast<Nanos::rep>(pair->a)}, RunAccess::inputs(run)[0].origin);
    ASSERT_GE(pair->a, last);
    last = pair->a;
  }
  writer.join();
}

TEST(Channel, AValueBringsItsOriginSoThatARunKnowsItsAge) {
  Channel<int> channel(0);
  const auto edges = input_of(channel, false);
  auto early = run_at(1, Nanos{50}, edges);
  EXPECT_EQ(early.age("from"), ctn::Run::kNoInput) << "nothing has come";
  write_in_run(channel, 1, 10, Nanos{70});
  write_in_run(channel, 2, 20, Nanos{90});
  auto run = run_at(2, Nanos{100}, edges);
  EXPECT_EQ(run.age("from"), Nanos{10});
  write_in_run(channel, 3, 30, Nanos{95});
  EXPECT_EQ(*channel.read(run), 20) << "to ask is to take";
  EXPECT_EQ(run.age("from"), Nanos{10});
  EXPECT_EQ(RunAccess::inputs(run)[0].last, 2U);
  EXPECT_EQ(run.age("form"), ctn::Run::kNoInput) << "a name that is misspelt is never fresh";
  auto next = run_at(3, Nanos{93}, edges);
  EXPECT_EQ(*channel.read(next), 30);
  EXPECT_EQ(next.age("from"), Nanos{0}) << "its source began after the run did";
}

TEST(Channel, ARunIsStaleWhenItsInputIsOlderThanTheLimit) {
  Channel<int> channel(0);
  const auto edges = input_of(channel, false, Nanos{30}, true);
  auto early = run_at(1, Nanos{50}, edges);
  EXPECT_FALSE(early.stale()) << "nothing is there that could be old";
  RunAccess::skip_if_stale(early);
  EXPECT_TRUE(RunAccess::emits(early));
  write_in_run(channel, 1, 10, Nanos{70});
  auto run = run_at(2, Nanos{100}, edges);
  EXPECT_FALSE(run.stale()) << "just as old as it may be";
  auto late = run_at(3, Nanos{101}, edges);
  EXPECT_TRUE(late.stale());
  RunAccess::skip_if_stale(late);
  EXPECT_FALSE(RunAccess::emits(late));
}

TEST(Channel, ARunOfWhichNothingIsKnownHasNoAges) {
  Channel<int> channel(0);
  auto run = run_number(1, 1);
  EXPECT_EQ(run.age("from"), ctn::Run::kNoInput);
  EXPECT_FALSE(run.stale());
}

TEST(QueueChannel, TheOldestThatARunTakesIsItsAge) {
  QueueChannel<int> queue(0);
  const auto edges = input_of(queue, true, Nanos{45});
  for (const int origin : {50, 60, 70}) write_in_run(queue, static_cast<std::uint64_t>(origin), origin, Nanos{origin});
  auto run = run_at(1, Nanos{100}, edges);
  EXPECT_EQ(run.age("from"), Nanos{50}) << "of what waits";
  EXPECT_TRUE(run.stale());
  EXPECT_EQ(RunAccess::inputs(run)[0].first, 0U) << "to ask takes nothing from a queue";
  EXPECT_EQ(queue.take(run), 50);
  EXPECT_EQ(queue.take(run), 60);
  EXPECT_EQ(run.age("from"), Nanos{50});
  auto next = run_at(2, Nanos{101}, edges);
  RunAccess::set_taken_before(next, 0, Nanos{50});
  EXPECT_EQ(next.age("from"), Nanos{31}) << "70 waits";
  EXPECT_EQ(queue.take(next), 70);
  EXPECT_EQ(next.age("from"), Nanos{31});
  auto last = run_at(3, Nanos{102}, edges);
  RunAccess::set_taken_before(last, 0, Nanos{70});
  EXPECT_FALSE(queue.take(last));
  EXPECT_EQ(last.age("from"), Nanos{32}) << "nothing is new: it still has what it took last";
}

TEST(QueueChannel, GivesAllSinceTheLastRunAndNotesTheRange) {
  QueueChannel<int> queue(0);
  for (int number = 1; number <= 3; ++number) write_in_run(queue, static_cast<std::uint64_t>(number), number * 10);
  auto reader = run_number(1, 1);
  std::vector<int> taken;
  while (const std::optional<int> value = queue.take(reader)) taken.push_back(*value);
  EXPECT_EQ(taken, (std::vector<int>{10, 20, 30}));
  EXPECT_EQ(RunAccess::inputs(reader)[0].first, 1U);
  EXPECT_EQ(RunAccess::inputs(reader)[0].last, 3U);
  auto next = run_number(2, 1);
  EXPECT_FALSE(queue.take(next));
  EXPECT_EQ(RunAccess::inputs(next)[0].first, 0U);
}

TEST(QueueChannel, CountsWhatItHadToDrop) {
  QueueChannel<int> queue(0);
  for (std::size_t number = 1; number <= QueueChannel<int>::kCapacity + 3; ++number) write_in_run(queue, number, 1);
  EXPECT_EQ(queue.dropped(), 3U);
}

}  // namespace
}  // namespace ctn
