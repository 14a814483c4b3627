#include "vio/vio.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "vio/imu_motion.h"
#include "vio/rotation.h"
#include "vio/testing/painted_room.h"
#include "vio/testing/synthetic.h"
#include "vio/trajectory_error.h"

namespace ctn::vr {
namespace {

// A head in the painted room, with Camera and VIO on it.
class Wearer {
 public:
  explicit Wearer(const testing::SyntheticOptions& options)
      : model_(small_camera()), room_(options.seed), head_(options), camera_(model_), vio_(model_, settings()) {}

  static CameraModel small_camera() { return testing::camera_of(320, 240); }
  static VioSettings settings() {
    VioSettings settings;
    settings.tracker.cell = 40;
    settings.tracker.min_distance = 10;
    settings.filter.pixel_noise = 0.5;
    return settings;
  }

  Vio::Result step(bool dark = false) {
    for (int i = 0; i < 10; ++i) {
      const ImuSample sample = head_.next_sample();
      time_ = sample.time;
      vio_.add(sample);
    }
    const cv::Mat picture = dark ? cv::Mat(model_.height, model_.width, CV_8UC1, cv::Scalar(0))
                                 : room_.picture(model_, head_.truth(time_).pose, 2.0, ++pictures_);
    const Vio::Result result = vio_.run(*camera_.run(picture, time_));
    if (result.state) {
      estimated_.push_back({time_, result.state->pose});
      truth_.push_back({time_, head_.truth(time_).pose});
    }
    return result;
  }
  TrajectoryError error() const { return absolute_error(estimated_, truth_); }
  Vio& vio() { return vio_; }
  Camera& camera() { return camera_; }
  const testing::SyntheticHead& head() const { return head_; }
  double time() const { return time_; }

 private:
  CameraModel model_;
  testing::PaintedRoom room_;
  testing::SyntheticHead head_;
  Camera camera_;
  Vio vio_;
  double time_ = 0.0;
  std::uint64_t pictures_ = 0;
  std::vector<StampedPose> estimated_;
  std::vector<StampedPose> truth_;
};

TEST(Vio, StartsByItselfAndFollowsTheHeadByPictures) {
  Wearer wearer({.seed = 1, .rest = 1.2});
  std::size_t used = 0;
  int frames_before = 0;
  for (int frame = 0; frame < 240; ++frame) {
    const Vio::Result result = wearer.step();
    if (!result.state) {
      ++frames_before;
      continue;
    }
    EXPECT_EQ(result.state->time, wearer.time());
    EXPECT_GT(result.features, 20U);
    used += result.used;
  }
  EXPECT_LE(frames_before, 16);
  EXPECT_GT(used, 500U);
  EXPECT_LT(wearer.error().position_rmse, 0.1);
  EXPECT_LT(wearer.error().rotation_rmse, 0.03);
}

TEST(Vio, DoesNotStartWhileTheHeadMoves) {
  Wearer wearer({.seed = 2, .rest = 0.0});
  for (int frame = 0; frame < 60; ++frame) wearer.step();
  for (int frame = 0; frame < 20; ++frame) EXPECT_FALSE(wearer.step().state);
  wearer.vio().start(wearer.head().truth_with_biases(wearer.time()), {});
  EXPECT_TRUE(wearer.step().state);
}

TEST(Vio, BearsSecondsOfDarkness) {
  Wearer wearer({.seed = 3, .rest = 1.0});
  for (int frame = 0; frame < 100; ++frame) wearer.step();
  for (int frame = 0; frame < 40; ++frame) {
    const Vio::Result result = wearer.step(true);
    ASSERT_TRUE(result.state);
    EXPECT_TRUE(is_finite(*result.state));
    EXPECT_EQ(result.features, 0U);
  }
  Vio::Result last;
  for (int frame = 0; frame < 40; ++frame) last = wearer.step();
  ASSERT_TRUE(last.state);
  EXPECT_GT(last.features, 20U);
  // In its own world, whose yaw is another.
  const double speed = wearer.head().truth(wearer.time()).velocity.norm();
  EXPECT_NEAR(last.state->velocity.norm(), speed, 0.15);
}

TEST(Vio, LeavesOutFramesOfThePast) {
  Wearer wearer({.seed = 4, .rest = 1.0});
  for (int frame = 0; frame < 30; ++frame) wearer.step();
  const cv::Mat grey(240, 320, CV_8UC1, cv::Scalar(100));
  for (const double time : {wearer.time(), wearer.time() - 0.5}) {
    const Vio::Result result = wearer.vio().run(*wearer.camera().run(grey, time));
    EXPECT_FALSE(result.state);
    EXPECT_EQ(result.work, Work{});
  }
  EXPECT_TRUE(wearer.step().state);
}

TEST(Vio, ItsWindowSpansNoLessTimeWithMorePictures) {
  const CameraModel model = testing::camera_of(64, 48);
  const cv::Mat grey(model.height, model.width, CV_8UC1, cv::Scalar(100));
  for (const double rate : {20.0, 31.0, 45.0, 60.0}) {
    Camera camera(model);
    Vio vio(model);
    vio.start(State{}, Uncertainty{});
    for (int i = 0; i < 500; ++i) vio.add({0.005 * i, Eigen::Vector3d::Zero(), {0.0, 0.0, kGravity}});
    for (int picture = 1; picture < 2.0 * rate; ++picture) {
      ASSERT_TRUE(vio.run(*camera.run(grey, picture / rate)).state);
    }
    const std::vector<double> window = vio.filter().window_times();
    EXPECT_GT(window.back() - window.front(), 0.49) << rate;
    EXPECT_LT(window.back() - window.front(), 0.85) << rate;
  }
}

TEST(Vio, CountsItsWork) {
  Wearer wearer({.seed = 5, .rest = 1.0});
  Work work;
  for (int frame = 0; frame < 60; ++frame) work += wearer.step().work;
  EXPECT_GT(work.windows, 0U);
  EXPECT_GT(work.cornered, 0U);
  EXPECT_GT(work.votes, 0U);
  EXPECT_GT(work.observations, 0U);
  EXPECT_GT(work.multiply_adds, 0U);
  EXPECT_GT(work.samples, 0U);
}

}  // namespace
}  // namespace ctn::vr
