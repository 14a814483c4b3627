// What is outside of the headset's nodes: the room, how the head really moves, and what the sensors say of that; or a
// data set in place of the last two. Made before a run, and not changed by it.
//
// Where the truth is known, tracking begins with the true state: the headset has lain still before. After that the
// nodes have no part of the truth.
//
// Times are nanoseconds since the first inertial sample. Thread safety: immutable.
#pragma once

#include <chrono>
#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "catan/result.h"
#include "run/options.h"
#include "sensors.h"
#include "world/euroc.h"
#include "world/imu.h"
#include "world/room.h"
#include "world/trajectory.h"

namespace ctn::vr::run {

class Surroundings {
 public:
  // `imu_period`: of the inertial unit's own clock. Errors: those of reading a data set.
  static Result<std::unique_ptr<const Surroundings>> make(const Options& options, std::chrono::nanoseconds imu_period);

  const world::Room& room() const { return room_; }
  const CameraModel& camera() const { return camera_; }  // that tracks
  const CameraModel& eye() const { return eye_; }        // what the wearer sees
  const CameraModel& frames() const { return frames_; }  // what Render draws: a little more

  std::size_t samples() const;
  // Of the last sample: later, nothing more comes.
  std::chrono::nanoseconds end() const;
  // How many have been taken by then.
  std::size_t samples_by(std::chrono::nanoseconds now) const;
  ImuSample sample(std::size_t index) const;

  // Those of a data set.
  const std::vector<world::PictureFile>& pictures() const { return pictures_; }

  // Of the body; none where a data set does not say it, as before the begin of its truth and after its end. Of the
  // eye's camera, where the body's is known.
  std::optional<Pose> truth(std::chrono::nanoseconds time) const;
  std::optional<Pose> true_eye(std::chrono::nanoseconds time) const;
  const std::optional<State>& start() const { return start_; }

 private:
  Surroundings(const Options& options, std::chrono::nanoseconds imu_period);
  void simulate(const Options& options);
  Status read(const Options& options);

  std::chrono::nanoseconds imu_period_;
  world::Room room_;
  CameraModel camera_;
  CameraModel eye_;
  CameraModel frames_;
  std::unique_ptr<world::Trajectory> trajectory_;
  double trajectory_begins_ = 0.0;   // seconds since the first inertial sample
  std::unique_ptr<world::Imu> imu_;  // of the simulated headset
  std::vector<ImuSample> recorded_;  // of a data set
  std::vector<world::PictureFile> pictures_;
  std::optional<State> start_;
};

}  // namespace ctn::vr::run
