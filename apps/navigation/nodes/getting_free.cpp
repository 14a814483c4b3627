#include "getting_free.h"

#include <algorithm>
#include <cmath>

namespace ctn::navigation {
namespace {

constexpr double kLongestPause = 1.0;
// What is told counts from here on, and what is counted up to there means that the wheels stand.
constexpr double kToldSpeed = 0.08;  // m/s
constexpr double kToldTurn = 0.15;   // rad/s
constexpr double kStandsSpeed = 0.02;
constexpr double kStandsTurn = 0.05;

}  // namespace

void GettingFree::feel(const Odometry& counted, const Velocity& told) {
  const double seconds = stamp_ ? std::chrono::duration<double>(counted.stamp - *stamp_).count() : 0.0;
  stamp_ = counted.stamp;
  if (seconds <= 0.0 || seconds > kLongestPause) return;
  not_back_for_ = std::max(0.0, not_back_for_ - seconds);
  if (speed_) {
    getting_free_ += seconds;
    if (distance(position(counted.pose), from_) >= kWay || getting_free_ >= kGiveUp) speed_.reset();
  }
  const bool should_move = std::abs(told.linear) >= kToldSpeed || std::abs(told.angular) >= kToldTurn;
  const bool stands =
      std::abs(counted.velocity.linear) <= kStandsSpeed && std::abs(counted.velocity.angular) <= kStandsTurn;
  held_ = should_move && stands ? held_ + seconds : 0.0;
  if (held_ < kHeldFor) return;
  held_ = 0.0;
  const bool ahead_is_held = speed_ && told == Velocity{kSpeed, 0.0};
  speed_ = ahead_is_held ? -kSpeed : kSpeed;
  from_ = position(counted.pose);
  getting_free_ = 0.0;
  not_back_for_ = kNotBackFor;
}

}  // namespace ctn::navigation
