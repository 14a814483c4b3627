#include "getting_free.h"

#include <gtest/gtest.h>

namespace ctn::navigation {
namespace {

constexpr Velocity kBack{-0.2, 0.7};

// A base that is told something 50 times a second.
class Base {
 public:
  explicit Base(GettingFree& getting_free) : getting_free_(getting_free) { feel({}, {}); }

  // For so long it is told `told`, and its wheels turn by `counted`.
  void drive(double seconds, const Velocity& told, const Velocity& counted) {
    for (double until = now_ + seconds; now_ < until - 1e-9;) {
      now_ += kStep;
      pose_ = transformed(pose_, Pose{counted.linear * kStep, 0.0, counted.angular * kStep});
      feel(told, counted);
    }
  }

 private:
  static constexpr double kStep = 0.02;

  void feel(const Velocity& told, const Velocity& counted) {
    const std::chrono::nanoseconds stamp(static_cast<std::int64_t>(1e9 * (now_ + 10.0)));
    getting_free_.feel({stamp, pose_, counted}, told);
  }

  GettingFree& getting_free_;
  double now_ = 0.0;
  Pose pose_;
};

TEST(GettingFree, HeldFromBehindItGoesAheadAndDoesNotBackUpForAWhile) {
  GettingFree getting_free;
  Base base(getting_free);
  base.drive(GettingFree::kHeldFor - 0.1, kBack, {});
  EXPECT_EQ(getting_free.speed(), std::nullopt);
  EXPECT_TRUE(getting_free.may_back_up());
  base.drive(0.2, kBack, {});
  ASSERT_EQ(getting_free.speed(), GettingFree::kSpeed);
  EXPECT_FALSE(getting_free.may_back_up());
  base.drive(0.9 * GettingFree::kWay / GettingFree::kSpeed, {GettingFree::kSpeed, 0.0}, {GettingFree::kSpeed, 0.0});
  EXPECT_EQ(getting_free.speed(), GettingFree::kSpeed);
  base.drive(0.3 * GettingFree::kWay / GettingFree::kSpeed, {GettingFree::kSpeed, 0.0}, {GettingFree::kSpeed, 0.0});
  EXPECT_EQ(getting_free.speed(), std::nullopt) << "it is free";
  EXPECT_FALSE(getting_free.may_back_up());
  base.drive(GettingFree::kNotBackFor, {0.5, 0.0}, {0.5, 0.0});
  EXPECT_TRUE(getting_free.may_back_up());
}

TEST(GettingFree, HeldFromAheadItGoesBack) {
  GettingFree getting_free;
  Base base(getting_free);
  base.drive(GettingFree::kHeldFor + 0.02, {0.0, 1.0}, {});
  ASSERT_EQ(getting_free.speed(), GettingFree::kSpeed);
  base.drive(GettingFree::kHeldFor + 0.02, {GettingFree::kSpeed, 0.0}, {});
  EXPECT_EQ(getting_free.speed(), -GettingFree::kSpeed);
  base.drive(GettingFree::kHeldFor + 0.02, {-GettingFree::kSpeed, 0.0}, {});
  EXPECT_EQ(getting_free.speed(), GettingFree::kSpeed) << "in turn";
}

TEST(GettingFree, GivesUpWhereItMayNotGoOn) {
  GettingFree getting_free;
  Base base(getting_free);
  base.drive(GettingFree::kHeldFor + 0.02, kBack, {});
  ASSERT_NE(getting_free.speed(), std::nullopt);
  base.drive(GettingFree::kGiveUp, {}, {});
  EXPECT_EQ(getting_free.speed(), std::nullopt);
}

TEST(GettingFree, WhatStandsAsToldOrMovesLateIsNotHeld) {
  GettingFree getting_free;
  Base base(getting_free);
  base.drive(3.0, {}, {});
  EXPECT_EQ(getting_free.speed(), std::nullopt);
  for (int i = 0; i < 5; ++i) {
    base.drive(0.6, kBack, {});
    base.drive(0.2, kBack, kBack);
  }
  EXPECT_EQ(getting_free.speed(), std::nullopt);
}

TEST(GettingFree, WhatWasCountedBeforeTellsNothing) {
  GettingFree getting_free;
  const Odometry odometry{std::chrono::seconds(1), {}, {}};
  for (int i = 0; i < 1000; ++i) getting_free.feel(odometry, kBack);
  getting_free.feel({std::chrono::seconds(5), {}, {}}, kBack);
  EXPECT_EQ(getting_free.speed(), std::nullopt);
}

}  // namespace
}  // namespace ctn::navigation
