// The filter of VIO: fuses inertial samples with tracks of features into pose, velocity and biases.
//
// A multi-state constraint Kalman filter (MSCKF; Mourikis and Roumeliotis, 2007). Its state is that of the body now and
// the poses that it had at the last keyframes (keyframes.h) and the newest two pictures, the *window*. Inertial samples
// move the state; each picture adds its pose to the window, which that of a keyframe leaves once it is the oldest and
// room is needed, any other one after the next picture. A feature that is no longer seen, or has been seen throughout
// the window, is triangulated from all of its observations, which then constrain the poses that saw it. The feature
// itself is no part of the state: the equations are projected to where its position has no influence. What is left of
// all features' equations is compressed by a QR decomposition before the update. A chi-square test rejects features
// that contradict the state.
//
// Errors are small rotations in the world's frame (true = rotation(error) * estimate) and differences otherwise, in the
// order orientation, position, velocity, gyroscope's bias, accelerometer's bias, then orientation and position of each
// pose of the window, oldest first. The four directions of which nothing can be known (position, yaw) must stay so in
// the equations: Jacobians are taken where each pose and velocity was first estimated (Huang, Mourikis and Roumeliotis,
// 2010), since others would make the filter believe that it learns its yaw.
//
// If nearly all features contradict the state, it is the state that is wrong, or is believed too much: the filter
// starts anew from there, as it does after a gap in the inertial samples, with tilt and velocity uncertain.
//
// docs/vr-vio.md has the equations. Never a pose that is not finite, whatever the inputs. Units: sensors.h,
// feature_track.h. Thread safety: one thread an object.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "sensors.h"
#include "vio/feature_track.h"
#include "vio/imu_motion.h"
#include "vio/work.h"

namespace ctn::vr {

struct ImuNoise {                      // continuous-time densities
  double gyro = 1.7e-4;                // rad/s/sqrt(Hz)
  double accelerometer = 2.0e-3;       // m/s^2/sqrt(Hz)
  double gyro_walk = 2.0e-5;           // rad/s^2/sqrt(Hz)
  double accelerometer_walk = 3.0e-3;  // m/s^3/sqrt(Hz)
};

struct FilterSettings {
  ImuNoise imu{};
  double pixel_noise = 1.0;       // of a feature's position, standard deviation
  std::size_t window = 12;        // poses, at least 4
  std::size_t max_features = 40;  // that one update uses; the longest tracks come first
};

// Standard deviations of a state that is given.
struct Uncertainty {
  double tilt = 0.01;  // radians, roll and pitch
  double yaw = 1e-4;
  double position = 1e-4;
  double velocity = 0.02;
  double gyro_bias = 0.005;
  double accelerometer_bias = 0.1;
  // Tilt was read from the accelerometer, at rest: what is wrong with it is the accelerometer's bias.
  bool tilt_from_accelerometer = false;
};

class Filter {
 public:
  static constexpr Eigen::Index kBodyErrors = 15;
  static constexpr Eigen::Index kPoseErrors = 6;

  Filter(const CameraModel& model, const FilterSettings& settings);

  // (Re)starts from `state`, which must be finite. Samples that were added stay.
  void start(const State& state, const Uncertainty& uncertainty);
  bool started() const { return started_; }

  // False: it was refused (imu_motion.h).
  bool add(const ImuSample& sample) { return history_.add(sample); }

  struct Outcome {
    bool taken = false;        // false: not started, or not later than the state
    std::size_t used = 0;      // features that corrected the state
    std::size_t rejected = 0;  // that were finished, but could not be triangulated or failed the test
    bool at_rest = false;
    Work work;
  };
  // A picture of `time` with what the tracker found in it. `keyframe`: its pose stays in the window.
  Outcome update(double time, const std::vector<Observation>& observations, bool keyframe = true);

  const State& state() const { return state_; }
  const ImuHistory& history() const { return history_; }
  // Of the body's errors, in the order above.
  Eigen::Matrix<double, kBodyErrors, kBodyErrors> covariance() const {
    return covariance_.topLeftCorner<kBodyErrors, kBodyErrors>();
  }
  // With the window.
  const Eigen::MatrixXd& full_covariance() const { return covariance_; }
  // When the poses of the window were, in ascending order.
  std::vector<double> window_times() const;

 private:
  struct WindowPose {
    std::uint64_t id = 0;  // of the picture
    double time = 0.0;
    bool keyframe = true;
    Pose pose;   // world from body
    Pose first;  // as first estimated
  };
  struct Sighting {
    std::uint64_t picture = 0;
    Eigen::Vector2d point = Eigen::Vector2d::Zero();
  };
  struct Track {
    std::vector<Sighting> sightings;
    std::uint64_t seen = 0;               // the last picture
    std::optional<Sighting> in_keyframe;  // in the last one that saw it
  };
  struct Equations {  // residual = matrix * errors of the window + noise
    Eigen::MatrixXd matrix;
    Eigen::VectorXd residual;
  };

  void propagate(double time, Work& work);
  void restart_after_gap(double seconds);
  void add_to_window(bool keyframe);
  void drop_from_window(std::size_t index);
  bool samples_look_at_rest(const std::vector<ImuSample>& steps) const;
  bool features_look_at_rest(const std::vector<Observation>& observations) const;
  bool looks_at_rest(const std::vector<ImuSample>& steps, const std::vector<Observation>& observations,
                     bool keyframe) const;
  std::optional<Equations> equations_of(const Track& track, Work& work) const;
  bool passes(const Equations& equations, Work& work) const;
  void correct_by_features(Outcome& outcome);
  void correct_by_rest(Outcome& outcome);
  // `first_column`: of the errors that the matrix is about. Noise of the rows: independent, of variance 1.
  bool correct(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& residual, Eigen::Index first_column, Work& work);
  void apply(const Eigen::VectorXd& errors);
  double point_noise() const { return settings_.pixel_noise / model_.fx; }

  CameraModel model_;
  FilterSettings settings_;
  ImuHistory history_{2000};
  bool started_ = false;
  State state_;
  State first_;  // position and velocity as first estimated
  Eigen::MatrixXd covariance_;
  std::vector<WindowPose> window_;
  std::map<std::uint64_t, Track> tracks_;  // by feature
  std::uint64_t picture_ = 0;
  std::uint64_t keyframe_ = 0;  // the last one
  double rest_seconds_ = 0.0;
  double judged_ = 0.0;    // features that came to an end, those of long ago counting less
  double rejected_ = 0.0;  // of them
};

}  // namespace ctn::vr
