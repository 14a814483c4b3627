// The robot in its world as programs of ROS see it: readings come when they are due, and what nodes send counts from
// when it comes. What is measured of the drive is as in the app (run/drive.h), reactions aside: the local map behind a
// velocity is not sent here.
//
// Whatever comes, readings that were due before are given first, each with the stamp of its instant.
//
// Units: metres, radians; times since the world began. Thread safety: one thread.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <utility>

#include "run/drive.h"
#include "world/world_file.h"

namespace ctn::navigation::ros1 {

class Simulator {
 public:
  using Give = std::function<void(const run::Reading&)>;

  Simulator(const world::WorldFile& world, std::uint64_t seed, Give give)
      : drive_(world, seed), give_(std::move(give)) {}

  // When the next reading is due.
  std::chrono::nanoseconds next_due() const { return next_; }
  // Times must not decrease. A reading is late by as much as `now` is after it was due.
  void advance(std::chrono::nanoseconds now);

  // --- What the nodes send, when it comes; `stamp`: of the scan, or the odometry, that it goes back to ---
  void move(std::chrono::nanoseconds now, const Velocity& velocity, std::chrono::nanoseconds stamp);
  void guided(std::chrono::nanoseconds now, const Pose& pose, std::chrono::nanoseconds stamp);
  void planned(std::chrono::nanoseconds now, std::shared_ptr<const Path> path);

  // The drive has ended: the goal is reached, or nothing is left to explore.
  bool over() const { return drive_.over(); }
  run::Findings findings() const { return drive_.findings(); }
  std::chrono::nanoseconds latest() const { return late_; }  // of all readings

 private:
  run::Drive drive_;
  Give give_;
  std::chrono::nanoseconds next_{};
  std::chrono::nanoseconds late_{};
};

}  // namespace ctn::navigation::ros1
