#include "sim/reservation_server.h"

#include <gtest/gtest.h>

namespace ctn::sim {
namespace {

using namespace std::chrono_literals;

TimePoint at(Nanos time) { return TimePoint{} + 1s + time; }

// 3 ms in each 10 ms, the first of which begins at 0.
ReservationServer woken_server() {
  ReservationServer server(3ms, 10ms);
  server.wake(at(0ms));
  return server;
}

TEST(ReservationServer, BeginsAPeriodWhenItsThreadWakes) {
  const ReservationServer server = woken_server();
  EXPECT_TRUE(server.may_run());
  EXPECT_EQ(server.deadline(), at(10ms));
  EXPECT_EQ(server.budget(), 3ms);
}

TEST(ReservationServer, WaitsForTheEndOfItsPeriodWhenItsBudgetIsSpent) {
  ReservationServer server = woken_server();
  EXPECT_FALSE(server.ran(2ms));
  EXPECT_TRUE(server.ran(1ms));
  EXPECT_FALSE(server.may_run());
  server.wake(at(5ms));
  server.replenish(at(9ms));
  EXPECT_FALSE(server.may_run());
  server.replenish(at(10ms));
  EXPECT_TRUE(server.may_run());
  EXPECT_EQ(server.deadline(), at(20ms));
  EXPECT_EQ(server.budget(), 3ms);
}

TEST(ReservationServer, WhatItRanTooLongIsTakenOff) {
  ReservationServer server = woken_server();
  EXPECT_TRUE(server.ran(4ms));
  server.replenish(at(10ms));
  EXPECT_EQ(server.budget(), 2ms);
  EXPECT_EQ(server.deadline(), at(20ms));
}

// 2 of 3 ms are left. At 3 ms, with 7 to go, that is less than 3 in 10: it may go on. At 4 ms, with 6 to go, it is
// more.
TEST(ReservationServer, KeepsWhatIsLeftOnlyWithinItsBandwidth) {
  ReservationServer server = woken_server();
  server.ran(1ms);
  ReservationServer other = server;
  server.wake(at(3ms));
  EXPECT_EQ(server.budget(), 2ms);
  EXPECT_EQ(server.deadline(), at(10ms));
  other.wake(at(4ms));
  EXPECT_EQ(other.budget(), 3ms);
  EXPECT_EQ(other.deadline(), at(14ms));
}

// Whatever its thread does, it never gets more than its bandwidth over a long time, and one period's worth.
TEST(ReservationServer, KeepsToItsBandwidth) {
  ReservationServer server(3ms, 10ms);
  Nanos used{0};
  for (Nanos now{0}; now < 10s; now += 1ms) {
    server.replenish(at(now));
    if (now % 7ms == 0ms) server.wake(at(now));
    if (!server.may_run() || server.budget() <= 0ms || now % 5ms == 4ms) continue;
    used += 1ms;
    server.ran(1ms);
  }
  EXPECT_LE(used, 3s + 3ms);
  EXPECT_GE(used, 2s);
}

}  // namespace
}  // namespace ctn::sim
