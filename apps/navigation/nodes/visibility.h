// Whether a scan saw through a place where another one hit something: then something has moved, or the two are not from
// where they are said to be (as in F. Pomerleau et al., "Long-term 3D Map Maintenance in Dynamic Environments", 2014).
//
// Units: metres, radians. Thread safety: no state.
#pragma once

#include <cstddef>
#include <vector>

#include "geometry.h"
#include "scan_filter.h"

namespace ctn::navigation {

inline constexpr std::size_t kBeamsForPoint = 7;  // that are looked at to say what a scan says of a place

enum class Seen { kUnknown, kFree, kOther };

// What `scan` says of a place, as seen from its robot. kFree: the beams around all end well beyond it. kOther: they go
// there, or end before it. kUnknown: out of its view, or a beam hit nothing.
Seen seen(const CleanScan& scan, const Point& place);

// Leaves out the points that lie where the scan saw through. They were seen from `from`, itself as seen from the robot
// of `scan`.
void remove_free(const CleanScan& scan, const Pose& from, std::vector<Point>& points);

// How many of the points, seen from `from` as above, can be judged by the scan, and how many of those lie where it saw
// through.
struct Conflict {
  std::size_t judged = 0;
  std::size_t free = 0;
};
Conflict conflict(const CleanScan& scan, const Pose& from, const std::vector<Point>& points);

}  // namespace ctn::navigation
