// Which tracks between two pictures can be of points that stand still: two-point RANSAC.
//
// The rotation between the pictures is known from gyroscopes. What is left of a feature's motion must then be along a
// line through the point of the picture that the camera moved towards. Two features settle a direction of translation;
// the direction that agrees with the largest number of features within a tolerance wins, and the others are outliers.
// A feature that did not move but by the rotation agrees with every direction.
//
// Reference: Troiani et al., "2-point-based outlier rejection for camera-IMU systems", 2014.
//
// Units: feature_track.h. Thread safety: no state; draws are from `seed`, so the same arguments give the same result.
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "vio/work.h"

namespace ctn::vr {

struct MotionVote {
  std::vector<char> inlier;  // of each track
  Work work;
};

// `now_from_before` turns a direction in the camera's frame of before into that of now.
MotionVote vote(const std::vector<Eigen::Vector2d>& before, const std::vector<Eigen::Vector2d>& now,
                const Eigen::Quaterniond& now_from_before, double tolerance, std::uint64_t seed);

}  // namespace ctn::vr
