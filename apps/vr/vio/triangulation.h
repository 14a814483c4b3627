// Where a feature is, from the pictures in which it was seen and the poses of the camera at their times.
//
// The point is written in the frame of the first camera as (a, b, 1) / distance, by the inverse of its distance along
// the camera's axis: in this form its image changes almost linearly with what is unknown, however far it is. A first
// inverse distance comes from linear least squares, all three from Gauss-Newton after that.
//
// Where the views tell too little about the distance it may come out as a limit, 0.1 m or 40 m. Such a feature still
// tells how the camera turned. It must not be left out: a filter that only hears of the features that agree with how
// far it believes to have moved believes so ever more.
//
// Reference: Montiel et al., "Unified inverse depth parametrization for monocular SLAM", 2006.
//
// Units: metres, feature_track.h. Thread safety: no state.
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "sensors.h"
#include "vio/work.h"

namespace ctn::vr {

struct View {
  Pose world_from_camera;
  Eigen::Vector2d point = Eigen::Vector2d::Zero();
};

struct Triangulation {
  std::optional<Eigen::Vector3d> point;  // in the world's frame; nothing if no point fits
  Work work;
};

// `noise`: of the views' points, standard deviation.
Triangulation triangulate(const std::vector<View>& views, double noise);

}  // namespace ctn::vr
