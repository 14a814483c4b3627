#include "program/exchange.h"

#include <gtest/gtest.h>

#include <memory>
#include <thread>

namespace ctn::program {
namespace {

TEST(Newest, GivesTheNewest) {
  Newest<int> newest;
  EXPECT_EQ(newest.read(), 0);
  newest.write(1);
  newest.write(2);
  EXPECT_EQ(newest.read(), 2);
  EXPECT_EQ(newest.read(), 2);
  newest.write(3);
  EXPECT_EQ(newest.read(), 3);
}

TEST(Newest, NeverGoesBackBetweenThreads) {
  constexpr int kLast = 20000;
  Newest<std::shared_ptr<const int>> newest;
  newest.write(std::make_shared<const int>(0));
  std::jthread writer([&newest] {
    for (int i = 1; i <= kLast; ++i) newest.write(std::make_shared<const int>(i));
  });
  int seen = 0;
  while (seen < kLast) {
    const int value = *newest.read();
    ASSERT_GE(value, seen);
    seen = value;
  }
}

TEST(Events, ComeInOrderAndAreCountedWhereTheyAreLost) {
  Events<int> events;
  EXPECT_EQ(events.take(), std::nullopt);
  const int more = static_cast<int>(Events<int>::kCapacity) + 3;
  for (int i = 0; i < more; ++i) events.write(i);
  EXPECT_EQ(events.lost(), 3U);
  for (int i = 0; i < more - 3; ++i) ASSERT_EQ(events.take(), i);
  EXPECT_EQ(events.take(), std::nullopt);
  events.write(7);
  EXPECT_EQ(events.take(), 7);
}

}  // namespace
}  // namespace ctn::program
