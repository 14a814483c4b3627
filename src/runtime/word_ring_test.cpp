#include "runtime/word_ring.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <array>
#include <deque>
#include <thread>

namespace ctn::runtime {
namespace {

std::array<std::uint64_t, 2> record(std::uint64_t number) { return {number, ~number}; }

TEST(WordRing, RefusesWhatDoesNotFitAndCountsIt) {
  WordRing ring(2, 2);
  EXPECT_TRUE(ring.push(record(1)));
  EXPECT_TRUE(ring.push(record(2)));
  EXPECT_FALSE(ring.push(record(3)));
  EXPECT_EQ(ring.lost(), 1U);
}

RC_GTEST_PROP(WordRingProperty, IsAQueueThatRefusesWhenFull, ()) {
  const auto capacity = *rc::gen::inRange<std::size_t>(1, 9);
  WordRing ring(capacity, 2);
  std::deque<std::uint64_t> expected;
  std::uint64_t number = 0;
  for (const bool push :
       *rc::gen::container<std::vector<bool>>(rc::gen::weightedElement<bool>({{4, true}, {1, false}}))) {
    if (push) {
      ++number;
      const bool fits = expected.size() < capacity;
      RC_ASSERT(ring.push(record(number)) == fits);
      if (fits) expected.push_back(number);
    } else {
      ring.drain([&](std::span<const std::uint64_t> words) {
        RC_ASSERT(words[0] == expected.front());
        RC_ASSERT(words[1] == ~words[0]);
        expected.pop_front();
      });
      RC_ASSERT(expected.empty());
    }
  }
}

TEST(WordRing, HandsEveryRecordOverBetweenTwoThreads) {
  constexpr std::uint64_t kRecords = 200000;
  WordRing ring(64, 2);
  std::thread producer([&] {
    for (std::uint64_t number = 1; number <= kRecords; ++number) {
      while (!ring.push(record(number))) std::this_thread::yield();
    }
  });
  std::uint64_t last = 0;
  while (last < kRecords) {
    ring.drain([&](std::span<const std::uint64_t> words) {
      ASSERT_EQ(words[0], last + 1);
      ASSERT_EQ(words[1], ~words[0]);
      last = words[0];
    });
  }
  producer.join();
}

}  // namespace
}  // namespace ctn::runtime
