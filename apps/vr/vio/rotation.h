// Rotations as vectors: their length is the angle in radians, their direction the axis.
//
// Thread safety: no state.
#pragma once

#include <cmath>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace ctn::vr {

// cross_matrix(a) * b is the cross product of a and b.
inline Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& a) {
  Eigen::Matrix3d matrix;
  matrix << 0.0, -a.z(), a.y(), a.z(), 0.0, -a.x(), -a.y(), a.x(), 0.0;
  return matrix;
}

inline Eigen::Quaterniond rotation(const Eigen::Vector3d& vector) {
  const double angle = vector.norm();
  // sin(angle / 2) / angle, by its series where the quotient would be 0 / 0.
  const double scale = angle < 1e-6 ? 0.5 - angle * angle / 48.0 : std::sin(0.5 * angle) / angle;
  return Eigen::Quaterniond(std::cos(0.5 * angle), scale * vector.x(), scale * vector.y(), scale * vector.z())
      .normalized();
}

// The shorter way: at most pi.
inline Eigen::Vector3d rotation_vector(const Eigen::Quaterniond& rotation) {
  const double sign = rotation.w() < 0.0 ? -1.0 : 1.0;
  const double sine = rotation.vec().norm();
  if (sine < 1e-12) return 2.0 * sign * rotation.vec();
  return 2.0 * std::atan2(sine, sign * rotation.w()) / sine * sign * rotation.vec();
}

// Of the body's forward direction (x) about the world's vertical.
inline double yaw_of(const Eigen::Quaterniond& orientation) {
  const Eigen::Matrix3d matrix = orientation.toRotationMatrix();
  return std::atan2(matrix(1, 0), matrix(0, 0));
}

}  // namespace ctn::vr
