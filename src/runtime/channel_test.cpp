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
void write_in_run(C& channel, std::uint64_t number, T value) {
  auto run = run_number(number, 0);
  channel.write(run, value);
  RunAccess::finish_writes(run);
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
    for (std::uint64_t number = 1; number <= kRuns; ++number) write_in_run(channel, number, Pair{number, number});
  });
  std::uint64_t last = 0;
  for (std::uint64_t number = 1; last < kRuns; ++number) {
    auto run = run_number(number, 1);
    const Pair* pair = channel.read(run);
    if (pair == nullptr) continue;
    ASSERT_EQ(pair->a, pair->b);
    ASSERT_EQ(pair->a, RunAccess::inputs(run)[0].last);
    ASSERT_GE(pair->a, last);
    last = pair->a;
  }
  writer.join();
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
