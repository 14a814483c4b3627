// Whether a scan saw through a place where another one hit something: then something has moved, or the two are not from
// where they are said to be (as in F. Pomerleau et al., "Long-term 3D Map Maintenance in Dynamic Environments", 2014).
//
// Units: metres, radians. Thread safety: functions are pure; one thread an object.
#pragma once

#include <cstddef>
#include <vector>

#include "geometry.h"
#include "keyframe.h"
#include "scan_filter.h"
#include "work.h"

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

// Of each keyframe its points, without those that one of the five keyframes before or after it saw through: what did
// not move.
class StillPoints {
 public:
  // Of keyframes that are new since the last call; the others are those of then. `work`: the beams that were looked at.
  void add(const std::vector<Keyframe>& keyframes, Work& work);

  const std::vector<Point>& operator[](std::size_t keyframe) const { return points_[keyframe]; }

 private:
  std::vector<std::vector<Point>> points_;  // by keyframe, each as seen from its robot
};

}  // namespace ctn::navigation
