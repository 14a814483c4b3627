#include "world/trajectory.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>

#include "program/random.h"
#include "world/jet.h"

namespace ctn::vr::world {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kDegree = kPi / 180.0;
constexpr double kRest = 1.0;                 // seconds, at the beginning
constexpr double kPeakOfMinimumJerk = 1.875;  // its highest speed over its mean speed
constexpr std::uint64_t kWalks = 11;          // streams of random numbers
constexpr std::uint64_t kGaze = 12;
constexpr std::uint64_t kSway = 13;

// From the neck to the inertial unit in front of the forehead, in the head's axes.
const Eigen::Vector3d kFromNeck{0.12, 0.0, 0.14};

// Of the bob: people take some two steps a second, and their heads go up and down by some two centimetres.
constexpr double kStepsPerSecond = 1.8;
constexpr double kBob = 0.018;

// Sway of x, y, z in metres and of yaw, pitch, roll in radians: three sines each, about these frequencies.
constexpr std::array<double, 6> kSwayOf{0.003, 0.003, 0.001, 0.15 * kDegree, 0.15 * kDegree, 0.1 * kDegree};
constexpr std::array<double, 3> kSwayHertz{0.31, 0.73, 1.37};
constexpr std::array<double, 3> kSwayShare{1.0, 0.5, 0.25};

// The highest rate that the sway of yaw, pitch and roll adds.
double sway_rate() {
  double shares = 0.0;
  for (std::size_t i = 0; i < 3; ++i) shares += kSwayShare[i] * 2.0 * kPi * kSwayHertz[i];
  return shares * std::hypot(kSwayOf[3], kSwayOf[4]) + shares * kSwayOf[5];
}

Jet sway(const double* phases, double amplitude, double time) {
  Jet sum;
  for (std::size_t i = 0; i < 3; ++i) {
    const double rate = 2.0 * kPi * kSwayHertz[i];
    sum = sum + amplitude * kSwayShare[i] * sin(Jet{rate * time + phases[i], rate, 0.0});
  }
  return sum;
}

// How much of a movement is done: from 0 to 1 with least jerk, at rest at both ends.
Jet done(double start, double duration, double time) {
  const double x = (time - start) / duration;
  if (x <= 0.0) return {};
  if (x >= 1.0) return constant(1.0);
  return {x * x * x * (10.0 - 15.0 * x + 6.0 * x * x), 30.0 * x * x * (1.0 - x) * (1.0 - x) / duration,
          60.0 * x * (1.0 - x) * (1.0 - 2.0 * x) / (duration * duration)};
}

// 1 in the middle of a movement, 0 at its ends, with continuous second derivatives.
Jet underway(double start, double duration, double time) {
  const double x = (time - start) / duration;
  if (x <= 0.0 || x >= 1.0) return {};
  const Jet along{x, 1.0 / duration, 0.0};
  const Jet bump = 4.0 * (along * (constant(1.0) - along));
  const Jet square = bump * bump;
  return square * square;
}

// The last element that has begun by then, or none.
template <class Movement>
const Movement* last_begun(const std::vector<Movement>& movements, double time) {
  const auto after =
      std::ranges::upper_bound(movements, time, {}, [](const Movement& movement) { return movement.start; });
  return after == movements.begin() ? nullptr : &*std::prev(after);
}

double wrapped_angle(double angle) { return std::remainder(angle, 2.0 * kPi); }

Eigen::Quaterniond exponential(const Eigen::Vector3d& rotation) {
  const double angle = rotation.norm();
  const double half = angle / 2.0;
  const double scale = angle < 1e-6 ? 0.5 - angle * angle / 48.0 : std::sin(half) / angle;
  const Eigen::Vector3d imaginary = scale * rotation;
  return {std::cos(half), imaginary.x(), imaginary.y(), imaginary.z()};
}

// The shorter of both ways.
Eigen::Vector3d logarithm(Eigen::Quaterniond q) {
  if (q.w() < 0.0) q.coeffs() = -q.coeffs();
  const double sine = q.vec().norm();
  if (sine < 1e-9) return 2.0 * q.vec();
  return 2.0 * std::atan2(sine, q.w()) / sine * q.vec();
}

}  // namespace

HeadTrajectory::HeadTrajectory(const HeadOptions& options) : options_(options) {
  assert(options.duration > 0.0 && options.reach_x > 0.0 && options.reach_y > 0.0 && options.max_turn_rate >= 0.5);
  const program::Noise noise(options.seed, kSway);
  for (std::size_t i = 0; i < std::size(phases_); ++i) phases_[i] = 2.0 * kPi * noise.uniform(i);
  add_walks();
  add_gaze_shifts();
}

void HeadTrajectory::add_walks() {
  program::Draws draws(options_.seed, kWalks);
  const auto somewhere = [&]() -> Eigen::Vector2d {
    const double x = draws.between(-options_.reach_x, options_.reach_x);
    return {x, draws.between(-options_.reach_y, options_.reach_y)};
  };
  Eigen::Vector2d here = somewhere();
  // One more than there is time for, so that there is always one: a walk that has not begun says where the head is.
  for (double time = kRest + draws.between(0.0, 1.0);;) {
    const Eigen::Vector2d there = somewhere();
    const double mean_speed = draws.between(0.3, 0.75);
    const double duration = std::max(0.6, (there - here).norm() / mean_speed);
    walks_.push_back({time, duration, here, there});
    if (time > options_.duration) return;
    time += duration + draws.between(0.2, 2.0);
    here = there;
  }
}

void HeadTrajectory::add_gaze_shifts() {
  program::Draws draws(options_.seed, kGaze);
  const double fastest = options_.max_turn_rate - sway_rate();
  double yaw = draws.between(-kPi, kPi);
  double pitch = draws.between(-5.0, 15.0) * kDegree;
  for (double time = kRest + draws.between(0.0, 1.0);;) {
    const Walk* walk = last_begun(walks_, time);
    const bool walking = walk != nullptr && time < walk->start + walk->duration;
    double target = yaw + draws.between(-120.0, 120.0) * kDegree;
    if (walking) {  // people look about where they go
      const Eigen::Vector2d way = walk->to - walk->from;
      target = std::atan2(way.y(), way.x()) + draws.between(-50.0, 50.0) * kDegree;
    }
    const double yaw_by = wrapped_angle(target - yaw);
    const double pitch_by = draws.between(-20.0, 30.0) * kDegree - pitch;
    const double peak = fastest * draws.between(0.2, 1.0);
    const double duration = std::max(0.25, kPeakOfMinimumJerk * std::hypot(yaw_by, pitch_by) / peak);
    gaze_shifts_.push_back({time, duration, yaw, pitch, yaw_by, pitch_by});
    if (time > options_.duration) return;
    yaw += yaw_by;
    pitch += pitch_by;
    time += duration + draws.between(0.1, 1.2);
  }
}

Motion HeadTrajectory::at(double time) const {
  const double when = std::clamp(time, 0.0, options_.duration);
  const Walk* begun_walk = last_begun(walks_, when);
  const Walk& walk = begun_walk != nullptr ? *begun_walk : walks_.front();
  const GazeShift* begun_shift = last_begun(gaze_shifts_, when);
  const GazeShift& shift = begun_shift != nullptr ? *begun_shift : gaze_shifts_.front();

  const Jet walked = done(walk.start, walk.duration, when);
  const double step_rate = 2.0 * kPi * kStepsPerSecond;
  const Jet bob =
      kBob * (underway(walk.start, walk.duration, when) * sin(Jet{step_rate * (when - walk.start), step_rate, 0.0}));
  const Jet turned = done(shift.start, shift.duration, when);

  std::array<Jet, 6> swayed;
  for (std::size_t i = 0; i < 6; ++i) swayed[i] = sway(phases_ + 3 * i, kSwayOf[i], when);
  const Jet yaw = constant(shift.yaw) + shift.yaw_by * turned + swayed[3];
  const Jet pitch = constant(shift.pitch) + shift.pitch_by * turned + swayed[4];
  const Jet roll = swayed[5];
  const Eigen::Vector2d way = walk.to - walk.from;
  std::array<Jet, 3> at{constant(walk.from.x()) + way.x() * walked + swayed[0],
                        constant(walk.from.y()) + way.y() * walked + swayed[1],
                        constant(options_.height) + bob + swayed[2]};

  // Yaw about z, then pitch about the new y, then roll about the new x: the columns of the rotation that the way from
  // the neck has a part in (its y is 0).
  const Jet cy = cos(yaw);
  const Jet sy = sin(yaw);
  const Jet cp = cos(pitch);
  const Jet sp = sin(pitch);
  const Jet cr = cos(roll);
  const Jet sr = sin(roll);
  const std::array<Jet, 3> forwards{cy * cp, sy * cp, constant(0.0) - sp};
  const std::array<Jet, 3> upwards{cy * sp * cr + sy * sr, sy * sp * cr - cy * sr, cp * cr};
  for (std::size_t i = 0; i < 3; ++i) at[i] = at[i] + kFromNeck.x() * forwards[i] + kFromNeck.z() * upwards[i];

  Motion motion;
  motion.pose.orientation = Eigen::AngleAxisd(yaw.value, Eigen::Vector3d::UnitZ()) *
                            Eigen::AngleAxisd(pitch.value, Eigen::Vector3d::UnitY()) *
                            Eigen::AngleAxisd(roll.value, Eigen::Vector3d::UnitX());
  motion.pose.position = {at[0].value, at[1].value, at[2].value};
  if (when != time) return motion;
  motion.velocity = {at[0].first, at[1].first, at[2].first};
  motion.acceleration = {at[0].second, at[1].second, at[2].second};
  motion.angular_rate = {roll.first - yaw.first * sp.value, pitch.first * cr.value + yaw.first * cp.value * sr.value,
                         yaw.first * cp.value * cr.value - pitch.first * sr.value};
  return motion;
}

RecordedTrajectory::RecordedTrajectory(std::span<const TimedPose> poses, const Eigen::Vector3d& offset) {
  assert(poses.size() >= 2);
  const double begin = poses.front().time;
  duration_ = poses.back().time - begin;
  assert(duration_ > 0.0);
  // Poses of a data set are rounded to micrometres: were they all controls, the acceleration would show it.
  constexpr double kSpacing = 0.025;
  std::vector<double> distances;
  for (std::size_t i = 1; i < poses.size(); ++i) distances.push_back(poses[i].time - poses[i - 1].time);
  const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
  std::nth_element(distances.begin(), middle, distances.end());
  const auto pieces = static_cast<std::size_t>(std::max(1.0, std::round(duration_ / std::max(kSpacing, *middle))));
  spacing_ = duration_ / static_cast<double>(pieces);

  std::size_t next = 1;
  for (std::size_t i = 0; i <= pieces; ++i) {
    const double time = begin + spacing_ * static_cast<double>(i);
    while (next + 1 < poses.size() && poses[next].time < time) ++next;
    const TimedPose& before = poses[next - 1];
    const TimedPose& after = poses[next];
    const double share = std::clamp((time - before.time) / (after.time - before.time), 0.0, 1.0);
    const Pose between{before.pose.orientation.slerp(share, after.pose.orientation).normalized(),
                       before.pose.position + share * (after.pose.position - before.pose.position) + offset};
    controls_.push_back(between);
  }
  controls_.insert(controls_.begin(), controls_.front());
  controls_.push_back(controls_.back());
  controls_.push_back(controls_.back());
}

Motion RecordedTrajectory::at(double time) const {
  const double when = std::clamp(time, 0.0, duration_);
  const std::size_t pieces = controls_.size() - 4;
  const std::size_t piece = std::min(static_cast<std::size_t>(when / spacing_), pieces);
  const double u = when / spacing_ - static_cast<double>(piece);
  const double per = 1.0 / spacing_;
  const std::array<Jet, 3> shares{
      Jet{(5.0 + u * (3.0 + u * (-3.0 + u))) / 6.0, (1.0 + u * (-2.0 + u)) / 2.0 * per, (u - 1.0) * per * per},
      Jet{(1.0 + u * (3.0 + u * (3.0 - 2.0 * u))) / 6.0, (0.5 + u * (1.0 - u)) * per, (1.0 - 2.0 * u) * per * per},
      Jet{u * u * u / 6.0, u * u / 2.0 * per, u * per * per}};

  Motion motion;
  motion.pose = controls_[piece];
  for (std::size_t i = 0; i < 3; ++i) {
    const Pose& from = controls_[piece + i];
    const Pose& to = controls_[piece + i + 1];
    const Eigen::Vector3d by = to.position - from.position;
    motion.pose.position += shares[i].value * by;
    motion.velocity += shares[i].first * by;
    motion.acceleration += shares[i].second * by;
    const Eigen::Vector3d turn = logarithm(from.orientation.conjugate() * to.orientation);
    const Eigen::Quaterniond turned = exponential(shares[i].value * turn);
    motion.pose.orientation = motion.pose.orientation * turned;
    motion.angular_rate = turned.conjugate() * motion.angular_rate + shares[i].first * turn;
  }
  motion.pose.orientation.normalize();
  if (when != time) return {motion.pose, {0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}};
  return motion;
}

}  // namespace ctn::vr::world
