#include "view.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include <opencv2/imgproc.hpp>

#include "lens.h"
#include "preprocess.h"

namespace ctn::face_tracking {
namespace {

// A white face in front of a black panorama with one grey column at bearing 0.
Footage plain_footage() {
  const int ring = static_cast<int>(std::lround(2.0 * std::numbers::pi * kRawPixelsPerRadian));
  Footage footage;
  footage.panorama = cv::Mat::zeros(kRawHeight, ring, CV_8UC3);
  footage.panorama.colRange(0, 4).setTo(cv::Scalar::all(120));
  footage.panorama.colRange(ring - 4, ring).setTo(cv::Scalar::all(120));
  footage.faces.push_back(
      {cv::Mat(100, 100, CV_8UC3, cv::Scalar::all(255)), cv::Mat(100, 100, CV_32FC3, cv::Scalar::all(1.0))});
  return footage;
}

// Mean column of the pixels brighter than `above`, or -1.
double bright_column(const cv::Mat& picture, double above) {
  cv::Mat grey;
  if (picture.channels() == 3) {
    cv::cvtColor(picture, grey, cv::COLOR_BGR2GRAY);
  } else {
    grey = picture;
  }
  const cv::Moments moments = cv::moments(grey > above, true);
  return moments.m00 > 0.0 ? moments.m10 / moments.m00 + 0.5 : -1.0;
}

Sight sight_of(double bearing, double pan) { return {bearing, pan, wrapped(bearing - pan)}; }

TEST(View, TheFaceStandsAtItsColumn) {
  const View view(plain_footage(), 1);
  cv::Mat raw;
  for (const double angle : {-0.45, -0.2, 0.0, 0.1, 0.4}) {
    view.render(sight_of(2.0 + angle, 2.0), 0.0, 1, raw);
    EXPECT_NEAR(bright_column(raw, 200), raw_column(angle), 1.0) << angle;
  }
}

TEST(View, FlattenedTheFaceStandsWhereAPinholeCameraSeesIt) {
  const auto flat_column = [](double angle) { return 0.5 * kFlatWidth - kFocalLength * std::tan(angle); };
  const View view(plain_footage(), 1);
  Preprocess preprocess;
  cv::Mat raw;
  cv::Mat flat;
  for (const double angle : {-0.4, -0.2, 0.0, 0.1, 0.4}) {
    view.render(sight_of(2.0 + angle, 2.0), 0.0, 1, raw);
    preprocess.run(raw, flat);
    ASSERT_EQ(flat.size(), cv::Size(kFlatWidth, kFlatHeight));
    EXPECT_NEAR(bright_column(flat, 160), flat_column(angle), 3.0) << angle;
    EXPECT_NEAR(flat_angle(flat_column(angle)), angle, 1e-12);
  }
}

TEST(View, OutOfViewIsOutOfThePicture) {
  const View view(plain_footage(), 1);
  cv::Mat raw;
  view.render(sight_of(4.0, 2.0), 0.0, 1, raw);
  EXPECT_EQ(bright_column(raw, 200), -1.0);
}

TEST(View, TheBackgroundMovesWithTheCamera) {
  const View view(plain_footage(), 1);
  cv::Mat raw;
  constexpr double kRound = 2.0 * std::numbers::pi;
  for (const double pan : {0.0, 0.3, -0.3, kRound + 0.3, -5.0 * kRound}) {
    view.render(sight_of(pan + 3.0, pan), 0.0, 1, raw);
    EXPECT_NEAR(bright_column(raw, 60), raw_column(wrapped(-pan)), 1.5) << pan;
  }
}

TEST(View, EqualNoiseEqualPicture) {
  const View view(plain_footage(), 1);
  cv::Mat one;
  cv::Mat same;
  cv::Mat other;
  view.render(sight_of(0.0, 0.0), 0.0, 5, one);
  view.render(sight_of(0.0, 0.0), 0.0, 5, same);
  view.render(sight_of(0.0, 0.0), 0.0, 6, other);
  EXPECT_EQ(cv::norm(one, same), 0.0);
  EXPECT_GT(cv::norm(one, other), 0.0);
}

}  // namespace
}  // namespace ctn::face_tracking
