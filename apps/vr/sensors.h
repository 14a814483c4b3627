// What the headset's inertial unit and camera report, and what is told of its pose: the values that pass from a world,
// or from a data set, to the nodes.
//
// Frames. The world's z axis is up. The body is the inertial unit: its axes are those of the IMU. The camera looks
// along its z axis, with x to the right and y down, as in OpenCV. A pose is where a frame lies in another one, and is
// named after both: world_from_body takes a point that is given in the body's frame to the world's.
//
// Units: metres, seconds since the world or the data set began, radians, pixels. Thread safety: values.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace ctn::vr {

inline constexpr double kGravity = 9.81;  // m/s^2, along the world's -z

struct ImuSample {
  double time = 0.0;
  Eigen::Vector3d angular_rate = Eigen::Vector3d::Zero();  // rad/s, in the body's frame
  // Specific force in m/s^2, in the body's frame: at rest it points upwards, and its length is kGravity.
  Eigen::Vector3d acceleration = Eigen::Vector3d::Zero();
};

struct Pose {
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
};

inline Eigen::Vector3d transformed(const Pose& frame, const Eigen::Vector3d& point) {
  return frame.orientation * point + frame.position;
}

// transformed(world_from_body, body_from_camera) is world_from_camera.
inline Pose transformed(const Pose& frame, const Pose& pose) {
  return {(frame.orientation * pose.orientation).normalized(), transformed(frame, pose.position)};
}

inline Pose inverse(const Pose& frame) {
  const Eigen::Quaterniond back = frame.orientation.conjugate();
  return {back, -(back * frame.position)};
}

// Of a camera that looks where the body's x axis points, upright where that is.
inline Eigen::Quaterniond looking_forward() {
  Eigen::Matrix3d axes;  // columns: the camera's right, down and forward in the body's frame
  axes << 0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0;
  return Eigen::Quaterniond(axes);
}

// A pinhole camera with radial and tangential distortion, as OpenCV and EuRoC define it. A point in the camera's frame
// is divided by its z to (x, y); with r^2 = x^2 + y^2 and d = 1 + k1 r^2 + k2 r^4,
//   x' = d x + 2 p1 x y + p2 (r^2 + 2 x^2)
//   y' = d y + p1 (r^2 + 2 y^2) + 2 p2 x y
// the pixel is (fx x' + cx, fy y' + cy). The centre of the upper left pixel is (0, 0).
struct CameraModel {
  int width = 640;
  int height = 480;
  double fx = 400.0;
  double fy = 400.0;
  double cx = 319.5;
  double cy = 239.5;
  double k1 = 0.0;
  double k2 = 0.0;
  double p1 = 0.0;
  double p2 = 0.0;
  Pose body_from_camera;
};

// What is known of the body at an instant, or was true of it.
struct State {
  double time = 0.0;
  Pose pose;                                           // world from body
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  // m/s, in the world's frame
  Eigen::Vector3d gyro_bias = Eigen::Vector3d::Zero();
  Eigen::Vector3d accelerometer_bias = Eigen::Vector3d::Zero();
};

}  // namespace ctn::vr
