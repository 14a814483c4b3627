// A scan that tells the map something new, with where it was taken: GL makes them, GM draws them.
//
// Units: metres, radians. Thread safety: values; shared ones never change.
#pragma once

#include <memory>
#include <vector>

#include "geometry.h"
#include "scan_filter.h"

namespace ctn::navigation {

struct Keyframe {
  Pose pose;  // in the map's frame
  SharedScan scan;
  bool outdated = false;  // newer ones show the same place from the same side: GM leaves it out
};
using SharedKeyframes = std::shared_ptr<const std::vector<Keyframe>>;

}  // namespace ctn::navigation
