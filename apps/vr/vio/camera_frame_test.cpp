#include "vio/camera_frame.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include <opencv2/imgproc.hpp>

#include "vio/feature_track.h"

namespace ctn::vr {
namespace {

CameraModel bent_camera() {
  CameraModel model;
  model.k1 = -0.28;
  model.k2 = 0.07;
  model.p1 = 0.0005;
  model.p2 = -0.0003;
  return model;
}

// As sensors.h defines it.
cv::Point2d bent_pixel(const CameraModel& model, const Eigen::Vector2d& point) {
  const double x = point.x();
  const double y = point.y();
  const double r2 = x * x + y * y;
  const double d = 1.0 + model.k1 * r2 + model.k2 * r2 * r2;
  return {model.fx * (d * x + 2.0 * model.p1 * x * y + model.p2 * (r2 + 2.0 * x * x)) + model.cx,
          model.fy * (d * y + model.p1 * (r2 + 2.0 * y * y) + 2.0 * model.p2 * x * y) + model.cy};
}

// The centre of what is bright.
cv::Point2d centre_of(const cv::Mat& picture) {
  const cv::Moments moments = cv::moments(picture);
  return {moments.m10 / moments.m00, moments.m01 / moments.m00};
}

TEST(Camera, StraightensWhatTheLensBends) {
  const CameraModel model = bent_camera();
  Camera camera(model);
  for (const Eigen::Vector2d& point : {Eigen::Vector2d(0.0, 0.0), Eigen::Vector2d(0.5, 0.3), Eigen::Vector2d(-0.6, 0.4),
                                       Eigen::Vector2d(0.2, -0.45)}) {
    const cv::Point2d bent = bent_pixel(model, point);
    cv::Mat picture(model.height, model.width, CV_8UC1, cv::Scalar(0));
    cv::circle(picture,
               cv::Point(static_cast<int>(std::lround(bent.x * 16.0)), static_cast<int>(std::lround(bent.y * 16.0))),
               4 * 16, cv::Scalar(255), cv::FILLED, cv::LINE_AA, 4);
    const Result<CameraFrame> frame = camera.run(picture, 1.5);
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->time, 1.5);
    const cv::Point2d seen = centre_of(frame->picture());
    const Eigen::Vector2d expected = pinhole_pixel(model, point);
    EXPECT_NEAR(seen.x, expected.x(), 0.3);
    EXPECT_NEAR(seen.y, expected.y(), 0.3);
  }
}

TEST(Camera, BuildsAPyramidAndCountsItsPixels) {
  const CameraModel model = bent_camera();
  const Result<CameraFrame> frame = Camera(model).run(cv::Mat(480, 640, CV_8UC1, cv::Scalar(7)), 0.0);
  ASSERT_TRUE(frame);
  ASSERT_EQ(frame->pyramid.size(), 2U * kPyramidLevels);
  EXPECT_EQ(frame->pyramid[2].size(), cv::Size(320, 240));
  EXPECT_EQ(frame->pyramid[6].size(), cv::Size(80, 60));
  EXPECT_EQ(frame->work.moved, 640U * 480U);
  EXPECT_EQ(frame->work.smoothed, 640U * 480U + 320U * 240U + 160U * 120U + 80U * 60U);
  // A lens that bends nothing costs nothing.
  EXPECT_EQ(Camera(CameraModel{}).run(cv::Mat(480, 640, CV_8UC1, cv::Scalar(7)), 0.0)->work.moved, 0U);
}

TEST(Camera, TakesColours) {
  const Result<CameraFrame> frame = Camera(CameraModel{}).run(cv::Mat(480, 640, CV_8UC3, cv::Scalar(50, 50, 50)), 0.0);
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->picture().type(), CV_8UC1);
  EXPECT_EQ(frame->picture().at<unsigned char>(100, 100), 50);
}

TEST(Camera, RefusesWhatIsNoPictureOfTheCamera) {
  Camera camera(CameraModel{});
  EXPECT_EQ(camera.run(cv::Mat(), 0.0).error().kind(), ErrorKind::kCaller);
  EXPECT_EQ(
      camera.run(cv::Mat(480, 641, CV_8UC1), 0.0).error().message(),
      "a picture of 641 x 480 pixels from a camera of 640 x 480; give the camera's model the size of its pictures");
  EXPECT_FALSE(camera.run(cv::Mat(480, 640, CV_32FC1), 0.0));
  EXPECT_FALSE(camera.run(cv::Mat(480, 640, CV_8UC1), std::numeric_limits<double>::quiet_NaN()));
}

}  // namespace
}  // namespace ctn::vr
