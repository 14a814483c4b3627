// How uncertain a pose in the plane is: the covariance of x, y and heading, or its inverse, the information.
//
// Units: metres, radians. Thread safety: values.
#pragma once

#include <cmath>

#include "geometry.h"

namespace ctn::navigation {

// Symmetric. All zero is, of information, nothing known; of a covariance, no doubt.
struct PoseMatrix {
  double xx = 0.0;
  double xy = 0.0;
  double xh = 0.0;
  double yy = 0.0;
  double yh = 0.0;
  double hh = 0.0;

  friend bool operator==(const PoseMatrix&, const PoseMatrix&) = default;
};

// Of independent errors, given by their standard deviations.
inline PoseMatrix covariance_of(double along_x, double along_y, double heading) {
  return {along_x * along_x, 0.0, 0.0, along_y * along_y, 0.0, heading * heading};
}

inline PoseMatrix operator+(const PoseMatrix& a, const PoseMatrix& b) {
  return {a.xx + b.xx, a.xy + b.xy, a.xh + b.xh, a.yy + b.yy, a.yh + b.yh, a.hh + b.hh};
}

// With `of` the error of a pose and `matrix` its information: the squared Mahalanobis distance.
inline double squared(const PoseMatrix& matrix, const Pose& of) {
  return matrix.xx * of.x * of.x + matrix.yy * of.y * of.y + matrix.hh * of.heading * of.heading +
         2.0 * (matrix.xy * of.x * of.y + matrix.xh * of.x * of.heading + matrix.yh * of.y * of.heading);
}

// The matrix is along the axes of a frame that is turned by `angle` in another frame: the same along that one's axes.
inline PoseMatrix turned(const PoseMatrix& matrix, double angle) {
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  return {c * c * matrix.xx - 2.0 * c * s * matrix.xy + s * s * matrix.yy,
          c * s * (matrix.xx - matrix.yy) + (c * c - s * s) * matrix.xy,
          c * matrix.xh - s * matrix.yh,
          s * s * matrix.xx + 2.0 * c * s * matrix.xy + c * c * matrix.yy,
          s * matrix.xh + c * matrix.yh,
          matrix.hh};
}

// Of information the covariance, and the other way round. Precondition: positive definite.
inline PoseMatrix inverse(const PoseMatrix& m) {
  const double xx = m.yy * m.hh - m.yh * m.yh;
  const double xy = m.xh * m.yh - m.xy * m.hh;
  const double xh = m.xy * m.yh - m.xh * m.yy;
  const double determinant = m.xx * xx + m.xy * xy + m.xh * xh;
  return {xx / determinant,
          xy / determinant,
          xh / determinant,
          (m.xx * m.hh - m.xh * m.xh) / determinant,
          (m.xy * m.xh - m.xx * m.yh) / determinant,
          (m.xx * m.yy - m.xy * m.xy) / determinant};
}

}  // namespace ctn::navigation
