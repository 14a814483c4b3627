// The robot's square on the local map: whether it touches what does not move.
//
// Units: metres. Thread safety: no state.
#pragma once

#include <initializer_list>
#include <optional>

#include "geometry.h"
#include "local_mapper.h"
#include "work.h"

namespace ctn::navigation {

// Less than from any cell to another: whoever keeps it is in the cell of no obstacle.
inline constexpr double kInNoObstacle = 1e-6;

// Whether anything is nearer to the robot's outline than `margin`; one below 0 lets it overlap. `room` becomes the
// distance from the robot's centre to the nearest obstacle, if that is less.
bool touches_static(const LocalMap& map, const Pose& pose, double margin, double& room, Work& work);

// The first of the margins that the pose keeps; none: it keeps none of them.
std::optional<double> margin_kept(const LocalMap& map, const Pose& pose, std::initializer_list<double> margins,
                                  Work& work);

// The distance from the robot's outline to a point; 0 within.
double distance_from_outline(const Pose& pose, Point point);

}  // namespace ctn::navigation
