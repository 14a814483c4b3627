#include "vio/tracker.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <set>

#include "vio/rotation.h"
#include "vio/testing/painted_room.h"
#include "vio/testing/synthetic.h"

namespace ctn::vr {
namespace {

CameraModel turning_camera() {
  CameraModel model = testing::camera_of(320, 240);
  // About its own centre, so that a turn moves no point against another.
  model.body_from_camera.position.setZero();
  return model;
}

TrackerSettings small_settings() { return {.cell = 40, .min_distance = 10}; }

class Trackers : public ::testing::Test {
 protected:
  CameraFrame frame(const Pose& pose, double noise = 2.0) {
    ++pictures_;
    return *camera_.run(room_.picture(model_, pose, noise, static_cast<std::uint64_t>(pictures_)), 0.05 * pictures_);
  }
  Eigen::Quaterniond turned(const Pose& before, const Pose& now) const {
    const Pose from = transformed(before, model_.body_from_camera);
    const Pose to = transformed(now, model_.body_from_camera);
    return to.orientation.conjugate() * from.orientation;
  }

  CameraModel model_ = turning_camera();
  testing::PaintedRoom room_{1};
  Camera camera_{model_};
  Tracker tracker_{model_, small_settings()};
  int pictures_ = 0;
};

TEST_F(Trackers, FollowFeaturesThroughATurnOf200DegreesASecond) {
  Pose pose{Eigen::Quaterniond::Identity(), {0.0, 0.0, 1.5}};
  std::map<std::uint64_t, Eigen::Vector2d> before;
  std::size_t followed = 0;
  std::size_t wrong = 0;  // by more than a pixel: near the edge, where a turn changes what a window looks like
  std::size_t possible = 0;
  for (int i = 0; i < 8; ++i) {
    const Pose last = pose;
    pose.orientation = rotation({0.0, 0.0, 0.175}) * pose.orientation;
    const Eigen::Quaterniond turn = turned(last, pose);
    const Tracker::Result result = tracker_.run(frame(pose), turn);
    for (const Observation& observation : result.observations) {
      const auto found = before.find(observation.feature);
      if (found == before.end()) continue;
      ++followed;
      const Eigen::Vector2d expected = (turn * found->second.homogeneous()).hnormalized();
      const double error = (observation.point - expected).norm() * model_.fx;
      EXPECT_LT(error, 2.5);
      if (error > 1.0) ++wrong;
    }
    for (const auto& [id, point] : before) {
      const Eigen::Vector2d pixel = pinhole_pixel(model_, (turn * point.homogeneous()).hnormalized());
      if (pixel.x() > 8.0 && pixel.x() < model_.width - 8.0 && pixel.y() > 8.0 && pixel.y() < model_.height - 8.0)
        ++possible;
    }
    before.clear();
    for (const Observation& observation : result.observations) before[observation.feature] = observation.point;
  }
  EXPECT_GT(possible, 200U);
  EXPECT_LT(static_cast<double>(wrong), 0.1 * static_cast<double>(followed));
  EXPECT_GT(static_cast<double>(followed), 0.85 * static_cast<double>(possible));
}

TEST_F(Trackers, SpreadFeaturesOverThePictureAndBoundTheirNumber) {
  const Tracker::Result result =
      tracker_.run(frame({Eigen::Quaterniond::Identity(), {0.0, 0.0, 1.5}}), Eigen::Quaterniond::Identity());
  EXPECT_FALSE(result.displacement);
  EXPECT_GT(result.observations.size(), 48U);
  EXPECT_LE(result.observations.size(), 2U * 8U * 6U);
  std::set<int> quarters;
  for (const Observation& observation : result.observations) {
    quarters.insert((observation.point.x() > 0.0 ? 1 : 0) + (observation.point.y() > 0.0 ? 2 : 0));
  }
  EXPECT_EQ(quarters.size(), 4U);
  EXPECT_EQ(result.work.windows, 0U);
  EXPECT_GT(result.work.cornered, 60'000U);
}

// Of a head that turns and walks.
TEST_F(Trackers, FollowFeaturesFromTheKeyframeAsIfThereWereNoPicturesBetween) {
  const auto pose_of = [](int picture) {
    return Pose{rotation({0.0, 0.0, 0.02 * picture}), {0.01 * picture, 0.005 * picture, 1.5}};
  };
  Tracker of_all(model_, small_settings());
  const CameraFrame first = frame(pose_of(0));
  tracker_.run(first, Eigen::Quaterniond::Identity());
  const std::size_t at_first = of_all.run(first, Eigen::Quaterniond::Identity()).observations.size();
  for (int picture = 1; picture < 4; ++picture) {
    const Eigen::Quaterniond turn = turned(pose_of(picture - 1), pose_of(picture));
    const Tracker::Result between = of_all.run(frame(pose_of(picture)), turn, false);
    EXPECT_EQ(between.work.cornered, 0U);
    EXPECT_LE(between.observations.size(), at_first);
  }
  const CameraFrame last = frame(pose_of(4));
  std::map<std::uint64_t, Eigen::Vector2d> followed;
  for (const Observation& observation : of_all.run(last, turned(pose_of(3), pose_of(4))).observations) {
    followed[observation.feature] = observation.point;
  }
  std::size_t known = 0;
  std::size_t same = 0;
  for (const Observation& observation : tracker_.run(last, turned(pose_of(0), pose_of(4))).observations) {
    if (observation.feature > at_first) continue;
    ++known;
    const auto found = followed.find(observation.feature);
    if (found != followed.end() && (found->second - observation.point).norm() * model_.fx < 0.05) ++same;
  }
  EXPECT_GT(known, 30U);
  EXPECT_GT(static_cast<double>(same), 0.85 * static_cast<double>(known));
}

TEST_F(Trackers, ADarkPictureLosesAllAndNewOnesComeAfterIt) {
  const Pose pose{Eigen::Quaterniond::Identity(), {0.0, 0.0, 1.5}};
  const Eigen::Quaterniond still = Eigen::Quaterniond::Identity();
  const Tracker::Result first = tracker_.run(frame(pose), still);
  std::uint64_t newest = 0;
  for (const Observation& observation : first.observations) newest = std::max(newest, observation.feature);
  for (int i = 0; i < 3; ++i) {
    const CameraFrame dark = *camera_.run(cv::Mat(model_.height, model_.width, CV_8UC1, cv::Scalar(0)), 1.0);
    EXPECT_TRUE(tracker_.run(dark, still).observations.empty());
  }
  const Tracker::Result after = tracker_.run(frame(pose), still);
  EXPECT_GT(after.observations.size(), 48U);
  for (const Observation& observation : after.observations) EXPECT_GT(observation.feature, newest);
}

TEST_F(Trackers, MeasureHowFarFeaturesMoved) {
  const Pose pose{Eigen::Quaterniond::Identity(), {0.0, 0.0, 1.5}};
  tracker_.run(frame(pose), Eigen::Quaterniond::Identity());
  const Tracker::Result rest = tracker_.run(frame(pose), Eigen::Quaterniond::Identity());
  ASSERT_TRUE(rest.displacement);
  EXPECT_LT(*rest.displacement, 0.3);
  EXPECT_GT(rest.work.windows, 4U * 48U);
  EXPECT_GT(rest.work.votes, 0U);
  Pose turned_pose = pose;
  turned_pose.orientation = rotation({0.0, 0.0, 0.05});
  const Tracker::Result turn = tracker_.run(frame(turned_pose), turned(pose, turned_pose));
  ASSERT_TRUE(turn.displacement);
  EXPECT_NEAR(*turn.displacement, 0.05 * model_.fx, 3.0);
}

TEST_F(Trackers, TakeAFrameOfAnotherSizeForAnEmptyOne) {
  tracker_.run(frame({Eigen::Quaterniond::Identity(), {0.0, 0.0, 1.5}}), Eigen::Quaterniond::Identity());
  EXPECT_TRUE(tracker_.run(CameraFrame{}, Eigen::Quaterniond::Identity()).observations.empty());
  CameraModel other = model_;
  other.width = 200;
  const CameraFrame small = *Camera(other).run(cv::Mat(240, 200, CV_8UC1, cv::Scalar(9)), 0.0);
  EXPECT_TRUE(tracker_.run(small, Eigen::Quaterniond::Identity()).observations.empty());
}

}  // namespace
}  // namespace ctn::vr
