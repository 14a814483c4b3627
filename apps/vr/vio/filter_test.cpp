#include "vio/filter.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <random>
#include <utility>
#include <vector>

#include <Eigen/Cholesky>

#include "vio/keyframes.h"
#include "vio/rotation.h"
#include "vio/standstill.h"
#include "vio/testing/covariance.h"
#include "vio/testing/synthetic.h"
#include "vio/trajectory_error.h"

namespace ctn::vr {
namespace {

using testing::HeadPath;
using testing::SyntheticHead;
using testing::SyntheticOptions;

// A head with a filter on it. Both have the same world: the filter's is turned to that of the head once it starts.
class HeadWithFilter {
 public:
  // 200 inertial samples a second, a picture after so many.
  explicit HeadWithFilter(const SyntheticOptions& options, int samples_a_picture = 10, HeadPath path = {})
      : head_(options, std::move(path)), filter_(head_.camera(), {}), samples_a_picture_(samples_a_picture) {}

  // From the head's true state, as far as it goes.
  void start_from_truth() { filter_.start(head_.truth_with_biases(time_), {.velocity = 0.1, .gyro_bias = 0.002}); }
  // As VIO does.
  bool start_from_rest() {
    const std::optional<State> state = standing_state(filter_.history(), time_);
    if (!state) return false;
    turn_ = rotation({0.0, 0.0, -yaw_of(head_.truth(time_).pose.orientation)});
    origin_ = head_.truth(time_).pose.position;
    filter_.start(*state, {.tilt = 0.002, .gyro_bias = 0.002, .tilt_from_accelerometer = true});
    return true;
  }

  // One frame: the samples up to it, and what is seen.
  Filter::Outcome step(bool sees = true) {
    for (int i = 0; i < samples_a_picture_; ++i) {
      const ImuSample sample = head_.next_sample();
      time_ = sample.time;
      filter_.add(sample);
    }
    std::vector<Observation> observations = head_.observe(time_);
    if (!sees) observations.clear();
    const Filter::Outcome outcome = filter_.update(time_, observations, keyframes_.take(time_));
    if (outcome.taken) {
      estimated_.push_back({time_, filter_.state().pose});
      truth_.push_back({time_, truth().pose});
    }
    return outcome;
  }
  void steps(double seconds, bool sees = true) {
    const int frames = static_cast<int>(std::lround(seconds / (SyntheticHead::kImuPeriod * samples_a_picture_)));
    for (int i = 0; i < frames; ++i) step(sees);
  }

  State truth() const {
    State state = head_.truth_with_biases(time_);
    state.pose = {(turn_ * state.pose.orientation).normalized(), turn_ * (state.pose.position - origin_)};
    state.velocity = turn_ * state.velocity;
    return state;
  }
  Eigen::Matrix<double, 15, 1> errors() const {
    const State is = truth();
    const State& estimate = filter_.state();
    Eigen::Matrix<double, 15, 1> errors;
    errors << rotation_vector(is.pose.orientation * estimate.pose.orientation.conjugate()),
        is.pose.position - estimate.pose.position, is.velocity - estimate.velocity, is.gyro_bias - estimate.gyro_bias,
        is.accelerometer_bias - estimate.accelerometer_bias;
    return errors;
  }
  // Normalised estimation error squared, of three errors from `first` on.
  double nees(Eigen::Index first) const {
    const Eigen::Vector3d error = errors().segment<3>(first);
    return error.dot(filter_.covariance().block<3, 3>(first, first).ldlt().solve(error));
  }
  double position_deviation() const { return std::sqrt(filter_.covariance().block<3, 3>(3, 3).trace()); }

  SyntheticHead& head() { return head_; }
  Filter& filter() { return filter_; }
  double time() const { return time_; }
  TrajectoryError error() const { return absolute_error(estimated_, truth_); }
  const std::vector<StampedPose>& estimated() const { return estimated_; }

 private:
  SyntheticHead head_;
  Filter filter_;
  Keyframes keyframes_;
  int samples_a_picture_;
  double time_ = 0.0;
  Eigen::Quaterniond turn_ = Eigen::Quaterniond::Identity();
  Eigen::Vector3d origin_ = Eigen::Vector3d::Zero();
  std::vector<StampedPose> estimated_;
  std::vector<StampedPose> truth_;
};

// A minute of turns of up to 200 degrees a second, from standing still on.
TEST(Filter, IsWithin30CentimetresAfterAMinuteAndKnowsHowFarOffItIs) {
  double position = 0.0;
  double orientation = 0.0;
  double velocity = 0.0;
  int counted = 0;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    HeadWithFilter run({.seed = seed, .rest = 1.5});
    run.steps(0.7);
    ASSERT_TRUE(run.start_from_rest());
    for (int frame = 0; frame < 1200; ++frame) {
      run.step();
      if (frame % 10 != 0 || frame < 60) continue;
      orientation += run.nees(0);
      position += run.nees(3);
      velocity += run.nees(6);
      ++counted;
    }
    EXPECT_EQ(run.error().poses, 1200U);
    EXPECT_LT(run.error().position_rmse, 0.3);
    EXPECT_LT(run.error().position_max, 0.5);
    EXPECT_LT(run.error().rotation_rmse, 0.03);
    // The biases are found.
    EXPECT_LT(run.errors().segment<3>(9).norm(), 0.002);
    EXPECT_LT(run.errors().segment<3>(12).norm(), 0.08);
  }
  // Of three errors, 3 is what a consistent filter has. Errors are correlated over time, so these means of three
  // minutes scatter widely; a filter that believes to learn its yaw has tens.
  for (const double mean : {orientation / counted, position / counted, velocity / counted}) {
    EXPECT_GT(mean, 0.5);
    EXPECT_LT(mean, 9.0);
  }
}

TEST(Filter, StartsWhileTheHeadMoves) {
  HeadWithFilter run({.seed = 3, .rest = 0.0});
  run.steps(5.0);
  run.start_from_truth();
  run.steps(20.0);
  EXPECT_LT(run.error().position_rmse, 0.15);
}

TEST(Filter, BearsOutliers) {
  HeadWithFilter run({.seed = 4, .rest = 1.5, .outliers = 0.05});
  run.steps(0.7);
  ASSERT_TRUE(run.start_from_rest());
  run.steps(20.0);
  EXPECT_LT(run.error().position_rmse, 0.3);
}

TEST(Filter, ItsCovarianceIsOneAfterEachStep) {
  HeadWithFilter run({.seed = 2, .rest = 1.5, .max_features = 30});
  run.steps(0.7);
  ASSERT_TRUE(run.start_from_rest());
  for (int frame = 0; frame < 120; ++frame) {
    run.step(frame % 40 < 30);
    EXPECT_GT(testing::relative_smallest_eigenvalue(run.filter().full_covariance()), -1e-12) << frame;
  }
}

// Yaw and position cannot be observed, so what is believed of them must not become better.
TEST(Filter, DoesNotBelieveToLearnItsYaw) {
  HeadWithFilter run({.seed = 5, .rest = 1.5});
  run.steps(0.7);
  ASSERT_TRUE(run.start_from_rest());
  run.steps(6.0);  // once the gyroscope's bias is known, which tells of the yaw since the start
  const double at_first = run.filter().covariance()(2, 2);
  double before = 0.0;
  for (int frame = 0; frame < 400; ++frame) {
    run.step();
    const double yaw = run.filter().covariance()(2, 2);
    EXPECT_GT(yaw, 0.98 * before) << frame;
    before = yaw;
  }
  EXPECT_GT(before, 1.5 * at_first);
}

TEST(Filter, WithoutFeaturesItGoesOnAndKnowsLessAndComesBackAfter) {
  HeadWithFilter run({.seed = 6, .rest = 1.5});
  run.steps(0.7);
  ASSERT_TRUE(run.start_from_rest());
  run.steps(10.0);
  const double before = run.position_deviation();
  double last = 0.0;
  for (int frame = 0; frame < 60; ++frame) {
    const Filter::Outcome outcome = run.step(false);
    EXPECT_TRUE(outcome.taken);
    if (frame < 14) continue;  // what was seen before is still used
    EXPECT_GT(run.position_deviation(), last);
    last = run.position_deviation();
  }
  EXPECT_GT(last, 3.0 * before);
  EXPECT_LT(run.errors().segment<3>(3).norm(), 4.0 * last);
  run.steps(3.0);
  const Eigen::Vector3d offset = run.errors().segment<3>(3);
  EXPECT_LT(run.errors().segment<3>(6).norm(), 0.15);
  run.steps(5.0);
  // Where it came to is where it stays, but for drift.
  EXPECT_LT((run.errors().segment<3>(3) - offset).norm(), 0.3);
}

TEST(Filter, StandsStillWhereTheHeadDoes) {
  for (const int samples_a_picture : {10, 3}) {
    HeadWithFilter run({.seed = 7, .rest = 100.0, .pixel_noise = 0.2}, samples_a_picture);
    run.steps(0.7);
    ASSERT_TRUE(run.start_from_rest());
    run.steps(0.5);
    int at_rest = 0;
    for (int frame = 0; frame < 600; ++frame) at_rest += run.step().at_rest ? 1 : 0;
    EXPECT_GT(at_rest, 590);
    EXPECT_LT(run.errors().segment<3>(3).norm(), 0.02);
    EXPECT_LT(run.errors().segment<3>(6).norm(), 0.01);
    EXPECT_LT(run.errors().segment<3>(9).norm(), 0.002);
  }
}

// Guards against judging by what moves from one of many pictures to the next, which is next to nothing.
TEST(Filter, DoesNotTakeASlowWayForRestHoweverManyPicturesCome) {
  constexpr double kSpeed = 0.12;  // 0.3 pixels from picture to picture, a pixel from keyframe to keyframe
  const HeadPath straight{[](double time) {
    return Pose{Eigen::Quaterniond::Identity(), {0.0, kSpeed * (time - 5.0), 1.5}};
  }};
  HeadWithFilter run({.seed = 15, .pixel_noise = 0.2}, 3, straight);
  run.steps(0.7);
  run.start_from_truth();
  for (int frame = 0; frame < 600; ++frame) EXPECT_FALSE(run.step().at_rest) << frame;
  EXPECT_LT(run.errors().segment<3>(6).norm(), 0.5 * kSpeed);  // without acceleration, distances are hard to tell
}

// A head that moves slowly: the less time the window spans, the less features in it move.
TEST(Filter, IsNoWorseWithMorePictures) {
  const auto error_at = [](int samples_a_picture) {
    double sum = 0.0;
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
      HeadWithFilter run({.seed = seed, .rest = 0.0, .speed = 0.3, .translation = 0.3, .pixel_noise = 0.1},
                         samples_a_picture);
      run.steps(3.0);
      run.start_from_truth();
      run.steps(12.0);
      sum += run.error().position_rmse;
    }
    return sum / 4.0;
  };
  const double at_20_hz = error_at(10);
  EXPECT_LT(at_20_hz, 0.03);
  for (const int samples_a_picture : {4, 3}) {
    EXPECT_LT(error_at(samples_a_picture), 1.1 * at_20_hz) << 200.0 / samples_a_picture << " Hz";
  }
}

// The poses of the newest keyframes and of the newest picture, whenever pictures come.
RC_GTEST_PROP(FilterWindow, HasTheNewestKeyframesAndTheNewestPicture, ()) {
  const auto intervals = *rc::gen::container<std::vector<int>>(60, rc::gen::inRange(1, 25));
  Filter filter(CameraModel{}, FilterSettings{});
  for (int i = 0; i < 1600; ++i) filter.add({0.005 * i, Eigen::Vector3d::Zero(), {0.0, 0.0, kGravity}});
  filter.start(State{}, Uncertainty{});
  Keyframes keyframes;
  std::vector<double> taken;
  double time = 0.0;
  for (const int interval : intervals) {
    time += 0.005 * interval;
    const bool keyframe = keyframes.take(time);
    RC_ASSERT(filter.update(time, {}, keyframe).taken);
    const std::vector<double> window = filter.window_times();
    RC_ASSERT(window.back() == time);
    const std::size_t older = window.size() - 1;
    RC_ASSERT(older <= 11U);
    RC_ASSERT(older >= std::min<std::size_t>(taken.size(), 9U));
    RC_ASSERT(std::equal(window.begin(), window.end() - 1, taken.end() - static_cast<std::ptrdiff_t>(older)));
    if (keyframe) taken.push_back(time);
  }
}

TEST(Filter, FollowsAHeadThatRestsNowAndThen) {
  HeadWithFilter run({.seed = 8, .rest = 4.0, .pixel_noise = 0.3});
  run.steps(0.7);
  ASSERT_TRUE(run.start_from_rest());
  run.steps(14.0);
  EXPECT_LT(run.error().position_rmse, 0.1);
}

TEST(Filter, AfterAGapItStartsAnewFromWhereItWas) {
  HeadWithFilter run({.seed = 9, .rest = 1.5});
  run.steps(0.7);
  ASSERT_TRUE(run.start_from_rest());
  run.steps(8.0);
  const double before = run.position_deviation();
  const double yaw_before = run.filter().covariance()(2, 2);
  for (int i = 0; i < 200; ++i) run.head().next_sample();  // a second is lost
  const Filter::Outcome outcome = run.step();
  EXPECT_TRUE(outcome.taken);
  EXPECT_TRUE(is_finite(run.filter().state()));
  EXPECT_GT(run.position_deviation(), before + 0.5);
  EXPECT_GT(run.filter().covariance()(2, 2), yaw_before + 0.5);
  EXPECT_LT(run.errors().segment<3>(3).norm(), 4.0 * run.position_deviation());
  run.steps(10.0);
  EXPECT_LT(run.errors().segment<3>(6).norm(), 0.3);
  EXPECT_LT((run.filter().state().pose.orientation.conjugate() * Eigen::Vector3d::UnitZ() -
             run.truth().pose.orientation.conjugate() * Eigen::Vector3d::UnitZ())
                .norm(),
            0.05);
}

TEST(Filter, IsTheSameEachTime) {
  Eigen::Vector3d position[2];
  Work work[2];
  for (int i = 0; i < 2; ++i) {
    HeadWithFilter run({.seed = 10, .rest = 1.5});
    run.steps(0.7);
    ASSERT_TRUE(run.start_from_rest());
    for (int frame = 0; frame < 60; ++frame) work[i] += run.step().work;
    position[i] = run.filter().state().pose.position;
  }
  EXPECT_EQ(position[0], position[1]);
  EXPECT_EQ(work[0], work[1]);
  EXPECT_GT(work[0].observations, 1000U);
  EXPECT_GT(work[0].multiply_adds, 1'000'000U);
  EXPECT_EQ(work[0].samples, 600U);
}

TEST(Filter, LeavesOutPicturesOfThePast) {
  HeadWithFilter run({.seed = 11, .rest = 1.5});
  EXPECT_FALSE(run.filter().update(0.0, {}).taken);  // not started
  run.steps(0.7);
  ASSERT_TRUE(run.start_from_rest());
  run.steps(1.0);
  const State before = run.filter().state();
  for (const double time : {run.time(), run.time() - 1.0, std::numeric_limits<double>::quiet_NaN(),
                            std::numeric_limits<double>::infinity()}) {
    EXPECT_FALSE(run.filter().update(time, run.head().observe(run.time())).taken);
  }
  EXPECT_EQ(run.filter().state().pose.position, before.pose.position);
}

// Whatever comes: the state is finite, the covariance one.
TEST(Filter, StaysFiniteWhateverTheInputs) {
  constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();
  HeadWithFilter run({.seed = 12, .rest = 1.5});
  run.steps(0.7);
  ASSERT_TRUE(run.start_from_rest());
  std::mt19937 random(13);
  double time = run.time();
  for (int frame = 0; frame < 400; ++frame) {
    const unsigned what = random() % 8;
    for (int i = 0; i < 10; ++i) {
      ImuSample sample = run.head().next_sample();
      time = sample.time;
      if (what == 1 && i % 2 == 0) sample.angular_rate.x() = kNothing;
      if (what == 2) sample.time -= 10.0;
      if (what == 3 && i == 3) sample.acceleration.setConstant(900.0);
      if (what == 4 && i == 4) sample.angular_rate.setConstant(50.0);
      if (what == 5) continue;  // a gap of 50 ms
      run.filter().add(sample);
    }
    std::vector<Observation> observations = run.head().observe(time);
    if (what == 6) observations.clear();
    for (Observation& observation : observations) {
      if (what == 7) observation.point.x() = kNothing;
      if (what == 0 && random() % 3 == 0) observation.point *= -1e6;
      if (what == 2) observation.feature = 1;
    }
    run.filter().update(time + (random() % 20 == 0 ? 0.3 : 0.0), observations);
    ASSERT_TRUE(is_finite(run.filter().state())) << frame;
    if (frame % 20 == 0) {
      ASSERT_GT(testing::relative_smallest_eigenvalue(run.filter().full_covariance()), -1e-9) << frame;
    }
  }
  EXPECT_LE(run.filter().window_times().size(), 12U);
}

TEST(Filter, WithoutInertialSamplesItSaysThatItKnowsNothing) {
  Filter filter(CameraModel{}, FilterSettings{});
  filter.start(State{}, Uncertainty{});
  for (int i = 1; i < 100; ++i) EXPECT_TRUE(filter.update(0.05 * i, {}).taken);
  EXPECT_TRUE(is_finite(filter.state()));
  EXPECT_GT(std::sqrt(filter.covariance()(3, 3)), 0.2);
}

}  // namespace
}  // namespace ctn::vr
