#include "ros1/navigation/simulator.h"

#include <algorithm>

namespace ctn::navigation::ros1 {

void Simulator::advance(std::chrono::nanoseconds now) {
  for (; next_ <= now; next_ += world::kSensorPeriod) {
    give_(*drive_.laser(next_));
    late_ = std::max(late_, now - next_);
  }
  drive_.advance(now);
}

void Simulator::move(std::chrono::nanoseconds now, const Velocity& velocity, std::chrono::nanoseconds stamp) {
  advance(now);
  drive_.move({now, velocity, nullptr, stamp});
}

void Simulator::guided(std::chrono::nanoseconds now, const Pose& pose, std::chrono::nanoseconds stamp) {
  advance(now);
  drive_.guided({now, stamp, pose});
}

void Simulator::planned(std::chrono::nanoseconds now, std::shared_ptr<const Path> path) {
  advance(now);
  drive_.planned({now, std::move(path), nullptr});
}

}  // namespace ctn::navigation::ros1
