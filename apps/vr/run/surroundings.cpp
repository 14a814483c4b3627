#include "run/surroundings.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "drawing/cameras.h"
#include "run/clock.h"

namespace ctn::vr::run {
namespace {

using std::chrono::nanoseconds;

constexpr double kMargin = 0.05;  // of a frame about what the eye sees, on each side
constexpr double kHeight = 1.5;   // of where a data set begins, in the room
constexpr double kBeyond = 1.0;   // seconds of motion after the run

// The simulated headset's: as those of such devices, a lens that bends what is at the edges.
CameraModel simulated_camera() {
  CameraModel camera;
  camera.k1 = -0.28;
  camera.k2 = 0.07;
  camera.body_from_camera = {looking_forward(), Eigen::Vector3d::Zero()};
  return camera;
}

// What is true at the first inertial sample, or when it is known first after that. The truth may have been recorded
// earlier, when the head was elsewhere. Nothing: it was known before alone.
std::optional<State> first_state(const std::vector<State>& truth) {
  const auto after = std::find_if(truth.begin(), truth.end(), [](const State& state) { return state.time >= 0.0; });
  if (after == truth.end()) return std::nullopt;
  if (after == truth.begin() || after->time == 0.0) return *after;
  const State& before = *(after - 1);
  const double part = -before.time / (after->time - before.time);
  const auto between = [part](const Eigen::Vector3d& one, const Eigen::Vector3d& other) -> Eigen::Vector3d {
    return one + part * (other - one);
  };
  State state;
  state.pose.orientation = before.pose.orientation.slerp(part, after->pose.orientation);
  state.pose.position = between(before.pose.position, after->pose.position);
  state.velocity = between(before.velocity, after->velocity);
  state.gyro_bias = between(before.gyro_bias, after->gyro_bias);
  state.accelerometer_bias = between(before.accelerometer_bias, after->accelerometer_bias);
  return state;
}

}  // namespace

Result<std::unique_ptr<const Surroundings>> Surroundings::make(const Options& options, nanoseconds imu_period) {
  std::unique_ptr<Surroundings> made(new Surroundings(options, imu_period));
  if (options.dataset.empty()) {
    made->simulate(options);
  } else if (Status read = made->read(options); !read) {
    return read.error();
  }
  made->eye_ = drawing::eye_of(options.width, options.height);
  made->eye_.body_from_camera = made->camera_.body_from_camera;
  made->frames_ = drawing::with_margin(made->eye_, kMargin);
  return std::unique_ptr<const Surroundings>(std::move(made));
}

Surroundings::Surroundings(const Options& options, nanoseconds imu_period)
    : imu_period_(imu_period), room_(options.seed) {}

void Surroundings::simulate(const Options& options) {
  camera_ = simulated_camera();
  world::HeadOptions head;
  head.seed = options.seed;
  head.duration = options.seconds + kBeyond;
  trajectory_ = std::make_unique<world::HeadTrajectory>(head);
  imu_ = std::make_unique<world::Imu>(*trajectory_, options.seed, world::ImuNoise{}, 1.0 / in_seconds(imu_period_));
  start_ = imu_->truth(0);
}

Status Surroundings::read(const Options& options) {
  Result<world::Euroc> euroc = world::read_euroc(options.dataset);
  if (!euroc) return euroc.error();
  if (euroc->imu.empty() || euroc->pictures.empty()) {
    return Error::caller(options.dataset + " has no inertial samples or no pictures", "name a whole sequence");
  }
  camera_ = euroc->camera;
  recorded_ = std::move(euroc->imu);
  pictures_ = std::move(euroc->pictures);
  if (euroc->truth.size() < 2) return Done{};
  start_ = first_state(euroc->truth);
  // Its first place is in the middle of the room.
  const Eigen::Vector3d first = (start_ ? *start_ : euroc->truth.front()).pose.position;
  const Eigen::Vector3d offset = Eigen::Vector3d(0.0, 0.0, kHeight) - first;
  trajectory_ = std::make_unique<world::RecordedTrajectory>(world::poses_of(euroc->truth), offset);
  trajectory_begins_ = euroc->truth.front().time;
  if (start_) start_->pose.position += offset;
  return Done{};
}

std::size_t Surroundings::samples() const { return imu_ ? imu_->size() : recorded_.size(); }

nanoseconds Surroundings::end() const { return nanoseconds(std::llround(1e9 * sample(samples() - 1).time)); }

std::size_t Surroundings::samples_by(nanoseconds now) const {
  if (now < nanoseconds(0)) return 0;
  if (imu_) return std::min(samples(), static_cast<std::size_t>(now / imu_period_) + 1);
  const auto later = std::ranges::upper_bound(recorded_, in_seconds(now), {}, &ImuSample::time);
  return static_cast<std::size_t>(later - recorded_.begin());
}

ImuSample Surroundings::sample(std::size_t index) const { return imu_ ? imu_->sample(index) : recorded_[index]; }

std::optional<Pose> Surroundings::truth(nanoseconds time) const {
  if (!trajectory_) return std::nullopt;
  const double at = in_seconds(time) - trajectory_begins_;
  // The simulated head's way goes on for longer than a run.
  const bool recorded = imu_ == nullptr;
  if (recorded && (at < 0.0 || at > trajectory_->duration())) return std::nullopt;
  return trajectory_->at(at).pose;
}

std::optional<Pose> Surroundings::true_eye(nanoseconds time) const {
  const std::optional<Pose> body = truth(time);
  if (!body) return std::nullopt;
  return transformed(*body, eye_.body_from_camera);
}

}  // namespace ctn::vr::run
