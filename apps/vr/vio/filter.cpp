#include "vio/filter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/QR>

#include "vio/rotation.h"
#include "vio/triangulation.h"

namespace ctn::vr {
namespace {

using Body = Eigen::Matrix<double, Filter::kBodyErrors, Filter::kBodyErrors>;

// Where each error of the body is.
constexpr Eigen::Index kOrientation = 0;
constexpr Eigen::Index kPosition = 3;
constexpr Eigen::Index kVelocity = 6;
constexpr Eigen::Index kGyroBias = 9;
constexpr Eigen::Index kAccelerometerBias = 12;

constexpr std::size_t kMinSightings = 3;
constexpr double kGate = 2.326;  // standard normal quantile of 99 %: a good feature in a hundred is rejected

// At rest: what the inertial unit may measure beyond gravity and biases, and how far features may move.
constexpr double kRestAcceleration = 0.25;  // m/s^2
constexpr double kRestAngularRate = 0.05;   // rad/s
constexpr double kRestWay = 0.4;            // pixels from keyframe to keyframe, or
constexpr double kRestNoise = 2.5;          // standard deviations of what noise does
constexpr std::size_t kMinRestFeatures = 8;
constexpr double kRestSeconds = 0.25;        // for so long
constexpr double kRestVelocityNoise = 0.02;  // m/s
constexpr double kRestRateNoise = 0.01;      // rad/s

// When features contradict the state.
constexpr double kMemory = 100.0;        // features: one that came to an end so many ago counts for 1/e
constexpr double kContradiction = 0.92;  // of them rejected
constexpr double kMinJudged = 40.0;
constexpr double kContradicted = 0.3;  // seconds of a gap that is as bad

// What a head may do while nothing is measured, standard deviations.
constexpr double kUnknownSpeed = 1.0;  // m/s
constexpr double kUnknownTurn = 1.0;   // rad/s
constexpr double kTiltAfterGap = 0.2;  // rad, of a tilt that one accelerometer sample tells

const Eigen::Vector3d kUp = Eigen::Vector3d::UnitZ();

std::uint64_t product(Eigen::Index a, Eigen::Index b, Eigen::Index c) {
  return static_cast<std::uint64_t>(a) * static_cast<std::uint64_t>(b) * static_cast<std::uint64_t>(c);
}

// The 99 % quantile of chi-square, by Wilson and Hilferty's approximation.
double chi_square_limit(Eigen::Index degrees) {
  const double spread = 2.0 / (9.0 * static_cast<double>(degrees));
  const double root = 1.0 - spread + kGate * std::sqrt(spread);
  return static_cast<double>(degrees) * root * root * root;
}

// How errors pass through a step from `before` to `after`; `first` has position and velocity at the begin as they were
// first estimated.
Body transition(const State& first, const State& before, const State& after) {
  const double step = after.time - before.time;
  const Eigen::Vector3d velocity_change = after.velocity - first.velocity + kGravity * step * kUp;
  const Eigen::Vector3d position_change =
      after.pose.position - first.pose.position - step * first.velocity + 0.5 * kGravity * step * step * kUp;
  const Eigen::Matrix3d turn =
      before.pose.orientation.slerp(0.5, after.pose.orientation).toRotationMatrix();  // halfway
  const Eigen::Matrix3d identity = Eigen::Matrix3d::Identity();
  Body matrix = Body::Identity();
  matrix.block<3, 3>(kOrientation, kGyroBias) = -step * turn;
  matrix.block<3, 3>(kPosition, kOrientation) = -cross_matrix(position_change);
  matrix.block<3, 3>(kPosition, kVelocity) = step * identity;
  matrix.block<3, 3>(kPosition, kGyroBias) = step * step / 6.0 * cross_matrix(velocity_change) * turn;
  matrix.block<3, 3>(kPosition, kAccelerometerBias) = -0.5 * step * step * turn;
  matrix.block<3, 3>(kVelocity, kOrientation) = -cross_matrix(velocity_change);
  matrix.block<3, 3>(kVelocity, kGyroBias) = 0.5 * step * cross_matrix(velocity_change) * turn;
  matrix.block<3, 3>(kVelocity, kAccelerometerBias) = -step * turn;
  return matrix;
}

// Noise is the same in all directions, so it does not matter how the body is turned.
Body step_noise(const ImuNoise& noise, double step) {
  const Eigen::Matrix3d identity = Eigen::Matrix3d::Identity();
  const double gyro = noise.gyro * noise.gyro * step;
  const double accelerometer = noise.accelerometer * noise.accelerometer * step;
  Body matrix = Body::Zero();
  matrix.block<3, 3>(kOrientation, kOrientation) = gyro * identity;
  matrix.block<3, 3>(kVelocity, kVelocity) = accelerometer * identity;
  matrix.block<3, 3>(kPosition, kPosition) = accelerometer * step * step / 3.0 * identity;
  matrix.block<3, 3>(kPosition, kVelocity) = 0.5 * accelerometer * step * identity;
  matrix.block<3, 3>(kVelocity, kPosition) = 0.5 * accelerometer * step * identity;
  matrix.block<3, 3>(kGyroBias, kGyroBias) = noise.gyro_walk * noise.gyro_walk * step * identity;
  matrix.block<3, 3>(kAccelerometerBias, kAccelerometerBias) =
      noise.accelerometer_walk * noise.accelerometer_walk * step * identity;
  return matrix;
}

// Rounding makes products a little unsymmetric.
Body symmetric(const Body& matrix) { return 0.5 * (matrix + matrix.transpose()); }

double square(double value) { return value * value; }

}  // namespace

Filter::Filter(const CameraModel& model, const FilterSettings& settings) : model_(model), settings_(settings) {
  settings_.window = std::max<std::size_t>(settings_.window, 4);
}

void Filter::start(const State& state, const Uncertainty& uncertainty) {
  state_ = state;
  state_.pose.orientation.normalize();
  first_ = state_;
  window_.clear();
  tracks_.clear();
  rest_seconds_ = 0.0;
  judged_ = 0.0;
  rejected_ = 0.0;
  started_ = true;
  const Eigen::Matrix3d identity = Eigen::Matrix3d::Identity();
  covariance_ = Eigen::MatrixXd::Zero(kBodyErrors, kBodyErrors);
  covariance_.block<3, 3>(kOrientation, kOrientation).diagonal() << square(uncertainty.tilt), square(uncertainty.tilt),
      square(uncertainty.yaw);
  covariance_.block<3, 3>(kPosition, kPosition) = square(uncertainty.position) * identity;
  covariance_.block<3, 3>(kVelocity, kVelocity) = square(uncertainty.velocity) * identity;
  covariance_.block<3, 3>(kGyroBias, kGyroBias) = square(uncertainty.gyro_bias) * identity;
  covariance_.block<3, 3>(kAccelerometerBias, kAccelerometerBias) = square(uncertainty.accelerometer_bias) * identity;
  if (uncertainty.tilt_from_accelerometer) {
    const Eigen::Matrix3d tilt_by_bias = cross_matrix(kUp) * state_.pose.orientation.toRotationMatrix() / kGravity;
    const Eigen::Matrix3d bias = covariance_.block<3, 3>(kAccelerometerBias, kAccelerometerBias);
    covariance_.block<3, 3>(kOrientation, kOrientation) += tilt_by_bias * bias * tilt_by_bias.transpose();
    covariance_.block<3, 3>(kOrientation, kAccelerometerBias) = tilt_by_bias * bias;
    covariance_.block<3, 3>(kAccelerometerBias, kOrientation) = bias * tilt_by_bias.transpose();
    covariance_ = Eigen::MatrixXd(symmetric(covariance()));
  }
}

// Nothing is known of the motion in between: the body may be anywhere near, turned by any yaw. Up is where the
// accelerometer says; biases are still what they were.
void Filter::restart_after_gap(double seconds) {
  State state = state_;
  state.velocity.setZero();
  Eigen::Vector3d up = Eigen::Vector3d::Zero();
  if (!history_.samples().empty()) {
    up = state.pose.orientation * (history_.samples().back().acceleration - state.accelerometer_bias);
  }
  if (up.norm() > 0.5 * kGravity && up.norm() < 1.5 * kGravity) {
    state.pose.orientation = Eigen::Quaterniond::FromTwoVectors(up, kUp) * state.pose.orientation;
  }
  const Body before = covariance();
  const double yaw = std::min(3.0, kUnknownTurn * seconds);
  const double way = std::min(1e3, kUnknownSpeed * seconds);
  start(state, {.tilt = kTiltAfterGap, .yaw = yaw, .position = way, .velocity = kUnknownSpeed});
  covariance_(kOrientation + 2, kOrientation + 2) += before(kOrientation + 2, kOrientation + 2);
  covariance_.block<3, 3>(kPosition, kPosition) += before.block<3, 3>(kPosition, kPosition);
  covariance_.bottomRightCorner<6, 6>() = before.bottomRightCorner<6, 6>();
}

void Filter::propagate(double time, Work& work) {
  const std::vector<ImuSample> steps = history_.between(state_.time, time);
  Body matrix = Body::Identity();
  Body noise = Body::Zero();
  double gap = steps.empty() ? time - state_.time : time - history_.samples().back().time;
  for (std::size_t i = 1; i < steps.size(); ++i) {
    const double step = steps[i].time - steps[i - 1].time;
    if (!(step > 0.0)) continue;
    if (step > kMaxStep) gap = std::max(gap, step);
    const State next = moved(state_, steps[i - 1], steps[i]);
    const Body by_step = transition(first_, state_, next);
    matrix = by_step * matrix;
    noise = by_step * noise * by_step.transpose() + step_noise(settings_.imu, step);
    state_ = next;
    first_ = next;
  }
  state_.time = time;
  first_ = state_;
  if (!steps.empty()) work.samples += steps.size() - 1;
  if (steps.empty() || gap > kMaxStep) {
    restart_after_gap(gap);
    return;
  }
  const Eigen::Index errors = covariance_.rows();
  const Eigen::Index others = errors - kBodyErrors;
  const Body body = covariance();
  covariance_.topLeftCorner<kBodyErrors, kBodyErrors>() = symmetric(matrix * body * matrix.transpose() + noise);
  if (others > 0) {
    const Eigen::MatrixXd cross = matrix * covariance_.topRightCorner(kBodyErrors, others);
    covariance_.topRightCorner(kBodyErrors, others) = cross;
    covariance_.bottomLeftCorner(others, kBodyErrors) = cross.transpose();
  }
  work.multiply_adds += product(kBodyErrors, kBodyErrors, others);
}

void Filter::add_to_window(bool keyframe) {
  window_.push_back({picture_, state_.time, keyframe, state_.pose, first_.pose});
  const Eigen::Index errors = covariance_.rows();
  covariance_.conservativeResize(errors + kPoseErrors, errors + kPoseErrors);
  // Orientation and position are the first errors of the body.
  const Eigen::MatrixXd rows = covariance_.topLeftCorner(kPoseErrors, errors);
  covariance_.bottomLeftCorner(kPoseErrors, errors) = rows;
  covariance_.topRightCorner(errors, kPoseErrors) = rows.transpose();
  covariance_.bottomRightCorner<kPoseErrors, kPoseErrors>() = rows.leftCols(kPoseErrors);
}

void Filter::drop_from_window(std::size_t index) {
  const std::uint64_t picture = window_[index].id;
  window_.erase(window_.begin() + static_cast<std::ptrdiff_t>(index));
  for (auto& [feature, track] : tracks_) {
    std::erase_if(track.sightings, [&](const Sighting& sighting) { return sighting.picture == picture; });
  }
  const Eigen::Index errors = covariance_.rows();
  const Eigen::Index begin = kBodyErrors + kPoseErrors * static_cast<Eigen::Index>(index);
  const Eigen::Index after = errors - begin - kPoseErrors;
  if (after > 0) {
    const Eigen::MatrixXd lower = covariance_.bottomRows(after);
    covariance_.middleRows(begin, after) = lower;
    const Eigen::MatrixXd right = covariance_.rightCols(after);
    covariance_.middleCols(begin, after) = right;
  }
  covariance_.conservativeResize(errors - kPoseErrors, errors - kPoseErrors);
}

bool Filter::samples_look_at_rest(const std::vector<ImuSample>& steps) const {
  if (steps.size() < 2) return false;
  return std::all_of(steps.begin(), steps.end(), [&](const ImuSample& sample) {
    const double force = (sample.acceleration - state_.accelerometer_bias).norm() - kGravity;
    return std::abs(force) <= kRestAcceleration && (sample.angular_rate - state_.gyro_bias).norm() <= kRestAngularRate;
  });
}

// Since the last keyframe.
bool Filter::features_look_at_rest(const std::vector<Observation>& observations) const {
  // Ways along x, along y and away from the centre: medians, which are nearly zero if what moves is only noise.
  std::array<std::vector<double>, 3> ways;
  for (const Observation& observation : observations) {
    const auto track = tracks_.find(observation.feature);
    if (track == tracks_.end() || !track->second.in_keyframe) continue;
    const Sighting& before = *track->second.in_keyframe;
    if (before.picture != keyframe_) continue;
    const Eigen::Vector2d way = observation.point - before.point;
    ways[0].push_back(way.x());
    ways[1].push_back(way.y());
    ways[2].push_back(way.dot(before.point.normalized()));
  }
  if (ways[0].size() < kMinRestFeatures) return false;
  // What noise does to a median of differences: its deviation is 1.25 times that of a mean.
  const double noise = 1.25 * std::sqrt(2.0 / static_cast<double>(ways[0].size())) * settings_.pixel_noise;
  const double limit = std::max(kRestWay, kRestNoise * noise) / model_.fx;
  return std::all_of(ways.begin(), ways.end(), [&](std::vector<double>& values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return std::abs(*middle) < limit;
  });
}

// From keyframe to keyframe, since from picture to picture hardly anything moves if there are many. Between keyframes
// what was found at the last one holds, unless the inertial samples say otherwise.
bool Filter::looks_at_rest(const std::vector<ImuSample>& steps, const std::vector<Observation>& observations,
                           bool keyframe) const {
  if (!samples_look_at_rest(steps)) return false;
  return keyframe ? features_look_at_rest(observations) : rest_seconds_ > 0.0;
}

std::vector<double> Filter::window_times() const {
  std::vector<double> times;
  for (const WindowPose& pose : window_) times.push_back(pose.time);
  return times;
}

Filter::Outcome Filter::update(double time, const std::vector<Observation>& observations, bool keyframe) {
  Outcome outcome;
  if (!started_ || !std::isfinite(time) || time <= state_.time) return outcome;
  outcome.taken = true;
  ++picture_;
  const double seconds = time - state_.time;
  const std::vector<ImuSample> steps = history_.between(state_.time, time);
  rest_seconds_ = looks_at_rest(steps, observations, keyframe) ? rest_seconds_ + seconds : 0.0;
  outcome.at_rest = rest_seconds_ > kRestSeconds;
  if (keyframe) keyframe_ = picture_;
  propagate(time, outcome.work);
  history_.forget_before(time - 1.0);
  add_to_window(keyframe);
  for (const Observation& observation : observations) {
    if (!observation.point.allFinite()) continue;
    Track& track = tracks_[observation.feature];
    if (track.seen == picture_) continue;  // twice in one picture
    track.sightings.push_back({picture_, observation.point});
    track.seen = picture_;
    if (keyframe) track.in_keyframe = track.sightings.back();
  }
  if (outcome.at_rest) {
    // The window keeps the poses from before, from which features can be triangulated.
    correct_by_rest(outcome);
    if (window_.size() > 1) drop_from_window(window_.size() - 2);
  }
  correct_by_features(outcome);
  if (judged_ >= kMinJudged && rejected_ >= kContradiction * judged_) restart_after_gap(kContradicted);
  if (window_.size() >= settings_.window) drop_from_window(0);
  if (window_.size() > 1 && !window_[window_.size() - 2].keyframe) drop_from_window(window_.size() - 2);
  return outcome;
}

std::optional<Filter::Equations> Filter::equations_of(const Track& track, Work& work) const {
  struct Seen {
    std::size_t index;  // in the window
    Eigen::Vector2d point;
  };
  std::vector<Seen> seen;
  std::vector<View> views;
  for (const Sighting& sighting : track.sightings) {
    const auto pose =
        std::find_if(window_.begin(), window_.end(), [&](const WindowPose& one) { return one.id == sighting.picture; });
    if (pose == window_.end()) continue;
    seen.push_back({static_cast<std::size_t>(pose - window_.begin()), sighting.point});
    views.push_back({transformed(pose->pose, model_.body_from_camera), sighting.point});
  }
  if (seen.size() < kMinSightings) return std::nullopt;
  const Triangulation triangulation = triangulate(views, point_noise());
  work += triangulation.work;
  if (!triangulation.point) return std::nullopt;
  const Eigen::Vector3d& point = *triangulation.point;

  const auto rows = static_cast<Eigen::Index>(2 * seen.size());
  const Eigen::Index columns = kPoseErrors * static_cast<Eigen::Index>(window_.size());
  Eigen::MatrixXd by_poses = Eigen::MatrixXd::Zero(rows, columns);
  Eigen::Matrix<double, Eigen::Dynamic, 3> by_point(rows, 3);
  Eigen::VectorXd residual(rows);
  const Eigen::Matrix3d camera_from_body = model_.body_from_camera.orientation.conjugate().toRotationMatrix();
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(2 * i);
    const Eigen::Index column = kPoseErrors * static_cast<Eigen::Index>(seen[i].index);
    const WindowPose& pose = window_[seen[i].index];
    const Eigen::Vector3d now = transformed(inverse(views[i].world_from_camera), point);
    const Eigen::Vector3d first = transformed(inverse(transformed(pose.first, model_.body_from_camera)), point);
    if (!(now.z() > 1e-2) || !(first.z() > 1e-2)) return std::nullopt;
    residual.segment<2>(row) = seen[i].point - now.hnormalized();
    Eigen::Matrix<double, 2, 3> projection;
    projection << 1.0, 0.0, -first.x() / first.z(), 0.0, 1.0, -first.y() / first.z();
    projection = projection * camera_from_body * pose.first.orientation.conjugate().toRotationMatrix() / first.z();
    by_point.middleRows<2>(row) = projection;
    by_poses.block<2, 3>(row, column) = projection * cross_matrix(point - pose.first.position);
    by_poses.block<2, 3>(row, column + 3) = -projection;
  }
  // What is orthogonal to the three columns of the point: all but the first three rows, after their QR decomposition.
  const Eigen::HouseholderQR<Eigen::Matrix<double, Eigen::Dynamic, 3>> decomposition(by_point);
  by_poses.applyOnTheLeft(decomposition.householderQ().adjoint());
  residual.applyOnTheLeft(decomposition.householderQ().adjoint());
  work.multiply_adds += product(6, rows, columns);
  return Equations{by_poses.bottomRows(rows - 3) / point_noise(), residual.tail(rows - 3) / point_noise()};
}

bool Filter::passes(const Equations& equations, Work& work) const {
  const Eigen::Index rows = equations.matrix.rows();
  const Eigen::Index columns = equations.matrix.cols();
  const Eigen::MatrixXd by_covariance = equations.matrix * covariance_.bottomRightCorner(columns, columns);
  Eigen::MatrixXd expected = by_covariance * equations.matrix.transpose();
  expected.diagonal().array() += 1.0;
  work.multiply_adds += product(rows, columns, columns) + product(rows, rows, columns);
  const Eigen::LLT<Eigen::MatrixXd> root(expected);
  if (root.info() != Eigen::Success) return false;
  const double distance = root.matrixL().solve(equations.residual).squaredNorm();
  return distance < chi_square_limit(rows);
}

void Filter::correct_by_features(Outcome& outcome) {
  struct Finished {
    std::size_t length;
    std::uint64_t feature;
  };
  std::vector<Finished> finished;
  const bool full = window_.size() >= settings_.window;
  for (auto track = tracks_.begin(); track != tracks_.end();) {
    const bool lost = track->second.seen != picture_;
    const bool whole =
        full && !track->second.sightings.empty() && track->second.sightings.front().picture == window_.front().id;
    if (lost && track->second.sightings.size() < kMinSightings) {
      track = tracks_.erase(track);
      continue;
    }
    if (lost || whole) finished.push_back({track->second.sightings.size(), track->first});
    ++track;
  }
  std::stable_sort(finished.begin(), finished.end(),
                   [](const Finished& a, const Finished& b) { return a.length > b.length; });

  std::vector<Equations> accepted;
  Eigen::Index rows = 0;
  for (const Finished& one : finished) {
    const auto track = tracks_.find(one.feature);
    if (accepted.size() < settings_.max_features && one.length >= kMinSightings) {
      std::optional<Equations> equations = equations_of(track->second, outcome.work);
      judged_ = 1.0 + judged_ * (1.0 - 1.0 / kMemory);
      rejected_ *= 1.0 - 1.0 / kMemory;
      if (equations && passes(*equations, outcome.work)) {
        rows += equations->matrix.rows();
        accepted.push_back(std::move(*equations));
      } else {
        ++outcome.rejected;
        rejected_ += 1.0;
      }
    }
    // What was used may not be used again.
    if (track->second.seen != picture_) {
      tracks_.erase(track);
    } else {
      track->second.sightings.clear();
    }
  }
  outcome.used = accepted.size();
  if (accepted.empty()) return;

  const Eigen::Index columns = covariance_.cols() - kBodyErrors;
  Eigen::MatrixXd matrix(rows, columns);
  Eigen::VectorXd residual(rows);
  Eigen::Index row = 0;
  for (const Equations& equations : accepted) {
    matrix.middleRows(row, equations.matrix.rows()) = equations.matrix;
    residual.segment(row, equations.residual.size()) = equations.residual;
    row += equations.matrix.rows();
  }
  if (rows > columns) {
    Eigen::HouseholderQR<Eigen::MatrixXd> decomposition(matrix);
    residual.applyOnTheLeft(decomposition.householderQ().adjoint());
    outcome.work.multiply_adds += product(rows, columns, columns);
    matrix = Eigen::MatrixXd(decomposition.matrixQR().topRows(columns).triangularView<Eigen::Upper>());
    residual.conservativeResize(columns);
  }
  if (!correct(matrix, residual, kBodyErrors, outcome.work)) outcome.used = 0;
}

// Velocity and angular rate are zero.
void Filter::correct_by_rest(Outcome& outcome) {
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(6, kBodyErrors);
  Eigen::VectorXd residual(6);
  matrix.block<3, 3>(0, kVelocity) = Eigen::Matrix3d::Identity() / kRestVelocityNoise;
  residual.head<3>() = -state_.velocity / kRestVelocityNoise;
  const Eigen::Vector3d rate = history_.between(state_.time - 1e-6, state_.time).back().angular_rate;
  matrix.block<3, 3>(3, kGyroBias) = Eigen::Matrix3d::Identity() / kRestRateNoise;
  residual.tail<3>() = (rate - state_.gyro_bias) / kRestRateNoise;
  correct(matrix, residual, 0, outcome.work);
}

bool Filter::correct(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& residual, Eigen::Index first_column,
                     Work& work) {
  const Eigen::Index rows = matrix.rows();
  const Eigen::Index columns = matrix.cols();
  const Eigen::Index errors = covariance_.rows();
  const Eigen::MatrixXd cross = covariance_.middleCols(first_column, columns) * matrix.transpose();
  Eigen::MatrixXd expected = matrix * cross.middleRows(first_column, columns);
  expected.diagonal().array() += 1.0;
  work.multiply_adds += product(errors, columns, rows) + product(rows, columns, rows) + product(rows, rows, rows) / 6 +
                        product(errors, rows, rows) / 2 + product(errors, errors, rows) / 2;
  const Eigen::LLT<Eigen::MatrixXd> root(expected);
  if (root.info() != Eigen::Success) return false;
  // With expected = L L^T, half = cross L^-T: the gain times the residual is half L^-1 residual, and half half^T is
  // what the covariance loses. Written so, it stays symmetric.
  const Eigen::MatrixXd half = root.matrixL().solve(cross.transpose()).transpose();
  const Eigen::VectorXd correction = half * root.matrixL().solve(residual);
  if (!correction.allFinite() || !half.allFinite()) return false;
  covariance_.selfadjointView<Eigen::Lower>().rankUpdate(half, -1.0);
  covariance_.triangularView<Eigen::StrictlyUpper>() = covariance_.transpose();
  apply(correction);
  return true;
}

void Filter::apply(const Eigen::VectorXd& errors) {
  const auto turned = [](const Pose& pose, const Eigen::Vector3d& orientation, const Eigen::Vector3d& position) {
    return Pose{(rotation(orientation) * pose.orientation).normalized(), pose.position + position};
  };
  state_.pose = turned(state_.pose, errors.segment<3>(kOrientation), errors.segment<3>(kPosition));
  state_.velocity += errors.segment<3>(kVelocity);
  state_.gyro_bias += errors.segment<3>(kGyroBias);
  state_.accelerometer_bias += errors.segment<3>(kAccelerometerBias);
  for (std::size_t i = 0; i < window_.size(); ++i) {
    const Eigen::Index at = kBodyErrors + kPoseErrors * static_cast<Eigen::Index>(i);
    window_[i].pose = turned(window_[i].pose, errors.segment<3>(at), errors.segment<3>(at + 3));
  }
}

}  // namespace ctn::vr
