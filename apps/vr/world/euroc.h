// Reads data sets in the format of EuRoC (Burri et al., 2016): what a real inertial unit and camera recorded, and what
// was true, in place of a world's.
//
//   mav0/imu0/data.csv                          time, angular rate, acceleration
//   mav0/cam0/data.csv, sensor.yaml, data/      time, name of a picture; the camera; the pictures
//   mav0/state_groundtruth_estimate0/data.csv   time, position, orientation (w x y z), velocity, biases; may be missing
//
// Times of files are nanoseconds of some clock; here they are seconds since the first inertial sample. Lines that begin
// with # are comments. Everything else that is not as it should be is an error with its file and line.
//
// Units: as in sensors.h. Thread safety: values.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "catan/result.h"
#include "sensors.h"
#include "world/trajectory.h"

namespace ctn::vr::world {

struct PictureFile {
  double time = 0.0;
  std::string path;
};

struct Euroc {
  std::int64_t origin = 0;  // nanoseconds in the files at time 0
  std::vector<ImuSample> imu;
  std::vector<PictureFile> pictures;
  CameraModel camera;
  std::vector<State> truth;        // empty: the data set has none
  std::vector<std::string> files;  // that were read: all but the pictures
};

inline constexpr std::size_t kMaxEurocBytes = std::size_t{256} << 20U;  // of one file

// `folder`: that has mav0 in it, or mav0 itself. Errors: kCaller, all that is wrong with the files (of each the first
// few); kEnvironment, where one cannot be read.
Result<Euroc> read_euroc(const std::string& folder);

std::vector<TimedPose> poses_of(const std::vector<State>& states);

// The parts, from texts; `file` names them in errors.
struct TimedImu {
  std::int64_t nanoseconds = 0;
  ImuSample sample;  // its time is not set
};
Result<std::vector<TimedImu>> parse_euroc_imu(std::string_view text, const std::string& file);
struct TimedName {
  std::int64_t nanoseconds = 0;
  std::string name;
};
Result<std::vector<TimedName>> parse_euroc_pictures(std::string_view text, const std::string& file);
struct TimedState {
  std::int64_t nanoseconds = 0;
  State state;  // its time is not set
};
Result<std::vector<TimedState>> parse_euroc_truth(std::string_view text, const std::string& file);
Result<CameraModel> parse_euroc_camera(std::string_view text, const std::string& file);

}  // namespace ctn::vr::world
