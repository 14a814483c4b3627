// The robot's square on the local map: whether it touches what does not move.
//
// Units: metres. Thread safety: no state.
#pragma once

#include "geometry.h"
#include "local_mapper.h"
#include "work.h"

namespace ctn::navigation {

// Whether anything is nearer to the robot's outline than `margin`; with 0, whether the outline is in the cell of an
// obstacle; one below 0 lets it overlap. `room` becomes the distance from the robot's centre to the nearest obstacle,
// if that is less.
bool touches_static(const LocalMap& map, const Pose& pose, double margin, double& room, Work& work);

// The distance from the robot's outline to a point; 0 within.
double distance_from_outline(const Pose& pose, Point point);

}  // namespace ctn::navigation
