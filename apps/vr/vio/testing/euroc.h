// Reads a sequence of the EuRoC MAV data set (Burri et al., 2016), for tests and benchmarks: the folder that has mav0.
//
// Times count from the first picture. Units: sensors.h. Thread safety: no state.
#pragma once

#include <string>
#include <vector>

#include "catan/result.h"
#include "sensors.h"

namespace ctn::vr::testing {

struct EurocPicture {
  double time = 0.0;
  std::string file;
};

struct Euroc {
  std::vector<EurocPicture> pictures;
  std::vector<ImuSample> samples;
  std::vector<State> truth;
};

// The left camera of the data set, as its calibration says.
CameraModel euroc_camera();

// Errors (kEnvironment): a file is missing or has something else in it.
Result<Euroc> read_euroc(const std::string& folder);

}  // namespace ctn::vr::testing
