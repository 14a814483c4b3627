// Where the wheels say that the robot was at an instant: a laser's driver gets scans and odometry as messages, which
// come by different ways, and gives with each scan the odometry of its instant.
//
// Where that has not come yet, the robot is taken to have gone on since the newest one before it as it did, which over
// 20 ms is right to less than a millimetre.
//
// Units: as the values. Thread safety: one thread at a time.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <optional>

#include "sensors.h"

namespace ctn::navigation::ros1 {

class OdometryHistory {
 public:
  static constexpr std::size_t kKept = 16;

  void add(const Odometry& odometry);
  // None: nothing is known that is not newer.
  std::optional<Odometry> at(std::chrono::nanoseconds stamp) const;

 private:
  std::array<Odometry, kKept> kept_{};
  std::size_t added_ = 0;
};

}  // namespace ctn::navigation::ros1
