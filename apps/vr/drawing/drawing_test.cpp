// What is drawn, compared with arithmetic that knows nothing of OpenGL. Where nothing can be drawn, these are skipped.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <filesystem>
#include <iterator>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "drawing/cameras.h"
#include "drawing/timewarp.h"
#include "drawing/views.h"
#include "lens.h"
#include "world/room.h"
#include "world/trajectory.h"

namespace ctn::vr::drawing {
namespace {

// A camera that looks where the head's x axis points.
Pose forwards() { return {looking_forward(), Eigen::Vector3d::Zero()}; }

Pose turned(const Pose& pose, double angle, const Eigen::Vector3d& axis) {
  return {pose.orientation * Eigen::Quaterniond(Eigen::AngleAxisd(angle, axis.normalized())), pose.position};
}

class Drawing : public testing::Test {
 protected:
  void SetUp() override {
    auto view = EyeView::open(room_, eye_of(8, 8), Screen::kFirst);
    if (view) return;
    ASSERT_EQ(view.error().kind(), ErrorKind::kEnvironment);
    GTEST_SKIP() << view.error().message();
  }

  std::unique_ptr<EyeView> view(const CameraModel& camera, Screen screen = Screen::kFirst) const {
    return EyeView::open(room_, camera, screen).value();
  }
  Pose pose_at(double time) const { return transformed(head_.at(time).pose, forwards()); }

  world::Room room_{1};
  world::HeadTrajectory head_{{}};
};

double nearness(const world::Room& room, const CameraModel& camera, const Pose& pose, const Eigen::Vector2d& pixel) {
  const Eigen::Vector2d plane = undistorted(camera, pixel);
  const auto depth = room.distance(pose.position, pose.orientation * Eigen::Vector3d(plane.x(), plane.y(), 1.0));
  return depth ? std::min(255.0, 255.0 * kNearestDepth / *depth) : 0.0;
}

// The difference of two pictures: the mean over all colours of all pixels that are `border` away from the edges.
double difference(const std::vector<std::uint8_t>& one, const std::vector<std::uint8_t>& other, int width, int height,
                  int border) {
  EXPECT_EQ(one.size(), other.size());
  double sum = 0.0;
  for (int y = border; y < height - border; ++y) {
    for (int x = border; x < width - border; ++x) {
      const std::size_t at =
          4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x));
      for (std::size_t i = 0; i < 3; ++i) sum += std::abs(one[at + i] - other[at + i]);
    }
  }
  return sum / 3.0 / (width - 2 * border) / (height - 2 * border);
}

// All that is where, and nothing mirrored: each pixel has the depth that a ray finds. Where an edge goes through a
// pixel it may have that of either side.
TEST_F(Drawing, HasTheTrueDepthInEachPixel) {
  const CameraModel camera = eye_of(160, 120);
  const auto drawn = view(camera);
  Frame frame;
  for (const double time : {2.0, 17.0, 33.0, 50.0}) {
    const Pose pose = pose_at(time);
    drawn->draw(pose, frame);
    ASSERT_EQ(frame.pixels.size(), std::size_t{4} * 160 * 120);
    for (int y = 0; y < camera.height; y += 3) {
      for (int x = 0; x < camera.width; x += 3) {
        double low = 255.0;
        double high = 0.0;
        for (const double dx : {-0.52, 0.0, 0.52}) {
          for (const double dy : {-0.52, 0.0, 0.52}) {
            const double near = nearness(room_, camera, pose, {x + dx, y + dy});
            low = std::min(low, near);
            high = std::max(high, near);
          }
        }
        const int found = frame.pixels[4 * static_cast<std::size_t>(y * camera.width + x) + 3];
        ASSERT_GE(found, low - 0.6) << x << " " << y << " at " << time;
        ASSERT_LE(found, high + 0.6) << x << " " << y << " at " << time;
      }
    }
  }
}

TEST_F(Drawing, IsTheSameEachTime) {
  const CameraModel camera = eye_of(200, 150);
  const auto one = view(camera);
  const auto other = view(camera, Screen::kSecond);
  Frame first;
  Frame second;
  Frame elsewhere;
  one->draw(pose_at(5.0), first);
  one->draw(pose_at(9.0), elsewhere);
  EXPECT_NE(first.pixels, elsewhere.pixels);
  one->draw(pose_at(5.0), second);
  EXPECT_EQ(first.pixels, second.pixels);
  std::thread([&] { other->draw(pose_at(5.0), second); }).join();  // any thread, either screen
  EXPECT_EQ(first.pixels, second.pixels);
}

TEST_F(Drawing, AFrameThatIsNotTurnedStaysAsItIs) {
  const CameraModel eye = eye_of(160, 120);
  const CameraModel wider = with_margin(eye, 0.1);
  EXPECT_EQ(wider.width, 192);
  EXPECT_EQ(wider.height, 144);
  Frame frame;
  Frame inner;
  view(wider)->draw(pose_at(7.0), frame);
  view(eye)->draw(pose_at(7.0), inner);
  for (const Warp warp : {Warp::kRotational, Warp::kTranslational}) {
    const auto timewarp = Timewarp::open(eye, wider, warp, Screen::kFirst).value();
    timewarp->take(frame);
    timewarp->warp(pose_at(7.0));
    std::vector<std::uint8_t> picture;
    timewarp->read(picture);
    EXPECT_LT(difference(picture, inner.pixels, 160, 120, 0), 0.7);
    for (std::size_t i = 3; i < picture.size(); i += 4) ASSERT_EQ(picture[i], 255);  // nothing is missing
  }
}

// A turn, which a rotational warp undoes exactly but for the textures' sampling.
TEST_F(Drawing, AWarpedFrameAgreesWithOneThatIsDrawnThere) {
  const CameraModel eye = eye_of(320, 240);
  const CameraModel wider = with_margin(eye, 0.1);
  const auto frames = view(wider);
  const auto there = view(eye);
  const auto timewarp = Timewarp::open(eye, wider, Warp::kRotational, Screen::kSecond).value();
  std::vector<std::uint8_t> picture;
  Frame frame;
  Frame truth;
  for (const double time : {3.0, 12.0, 28.0, 44.0}) {
    const Pose drawn_at = pose_at(time);
    for (const Eigen::Vector3d& axis :
         {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(0.3, 0.4, 1.0)}) {
      const Pose now = turned(drawn_at, 0.06, axis);
      frames->draw(drawn_at, frame);
      timewarp->take(frame);
      timewarp->warp(now);
      timewarp->read(picture);
      there->draw(now, truth);
      const double warped = difference(picture, truth.pixels, 320, 240, 8);
      there->draw(drawn_at, truth);
      const double stale = difference(picture, truth.pixels, 320, 240, 8);
      EXPECT_LT(warped, 4.0) << time << " about " << axis.transpose();
      EXPECT_GT(stale, 4.0 * warped);  // so it is the warp that makes them agree
    }
  }
}

// A step to the side and a turn: with depths the frame agrees, without them it does not.
TEST_F(Drawing, ATranslationIsUndoneByDepths) {
  const CameraModel eye = eye_of(320, 240);
  const CameraModel wider = with_margin(eye, 0.15);
  const auto frames = view(wider);
  const auto there = view(eye);
  const auto rotational = Timewarp::open(eye, wider, Warp::kRotational, Screen::kFirst).value();
  const auto translational = Timewarp::open(eye, wider, Warp::kTranslational, Screen::kFirst).value();
  std::vector<std::uint8_t> picture;
  Frame frame;
  Frame truth;
  double with_depths = 0.0;
  double without = 0.0;
  for (const double time : {3.0, 12.0, 28.0, 44.0}) {
    const Pose drawn_at = pose_at(time);
    Pose now = turned(drawn_at, 0.03, {0, 1, 0});
    now.position += now.orientation * Eigen::Vector3d(0.06, 0.02, 0.03);
    frames->draw(drawn_at, frame);
    there->draw(now, truth);
    rotational->take(frame);
    rotational->warp(now);
    rotational->read(picture);
    without += difference(picture, truth.pixels, 320, 240, 8);
    translational->take(frame);
    translational->warp(now);
    translational->read(picture);
    with_depths += difference(picture, truth.pixels, 320, 240, 8);
  }
  EXPECT_LT(with_depths / 4.0, 4.0);
  EXPECT_GT(without, 4.0 * with_depths);
}

TEST_F(Drawing, WhatAFrameDoesNotCoverIsBlack) {
  const CameraModel eye = eye_of(100, 80);
  Frame frame;
  view(eye)->draw(pose_at(7.0), frame);
  const auto timewarp = Timewarp::open(eye, eye, Warp::kRotational, Screen::kFirst).value();
  timewarp->take(frame);
  std::vector<std::uint8_t> picture;
  timewarp->warp(turned(pose_at(7.0), 0.3, {0, 1, 0}));  // to the right: what is on the right is not in the frame
  timewarp->read(picture);
  const std::size_t row = std::size_t{4} * 100 * 40;
  EXPECT_EQ(picture[row + 3], 255);
  EXPECT_EQ(picture[row + 4 * 99 + 3], 0);
  EXPECT_EQ(picture[row + 4 * 99], 0);
  timewarp->warp(turned(pose_at(7.0), 3.1, {0, 1, 0}));  // behind
  timewarp->read(picture);
  EXPECT_EQ(std::count(picture.begin(), picture.end(), 0), std::ssize(picture));
}

// Each pixel of the camera's picture has what a picture without distortion has along its ray.
TEST_F(Drawing, TheCameraSeesThroughItsLens) {
  CameraModel camera = eye_of(240, 180);
  camera.fx = camera.fy = 150.0;
  camera.k1 = -0.28;
  camera.k2 = 0.07;
  camera.p1 = 0.002;
  camera.p2 = -0.001;
  camera.body_from_camera = forwards();
  camera.body_from_camera.position = {0.05, 0.02, -0.01};
  const CameraModel plain = covering(camera).value();
  const auto straight = view(plain);
  const auto lens = CameraView::open(room_, camera, Screen::kFirst).value();
  const Pose body = head_.at(21.0).pose;
  Frame frame;
  std::vector<std::uint8_t> picture;
  straight->draw(transformed(body, camera.body_from_camera), frame);
  lens->draw(body, picture);
  ASSERT_EQ(picture.size(), std::size_t{240} * 180);
  const auto grey = [&](int x, int y) {
    const std::size_t at = 4 * static_cast<std::size_t>(y * plain.width + x);
    return 0.299 * frame.pixels[at] + 0.587 * frame.pixels[at + 1] + 0.114 * frame.pixels[at + 2];
  };
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const Eigen::Vector2d plane = undistorted(camera, {x, y});
      const double u = plain.fx * plane.x() + plain.cx;
      const double v = plain.fy * plane.y() + plain.cy;
      const int left = static_cast<int>(u);
      const int top = static_cast<int>(v);
      ASSERT_TRUE(left >= 0 && top >= 0 && left + 1 < plain.width && top + 1 < plain.height);
      const double upper = grey(left, top) + (u - left) * (grey(left + 1, top) - grey(left, top));
      const double lower = grey(left, top + 1) + (u - left) * (grey(left + 1, top + 1) - grey(left, top + 1));
      ASSERT_NEAR(picture[static_cast<std::size_t>(y * camera.width + x)], upper + (v - top) * (lower - upper), 2.5);
    }
  }
}

// What is drawn must cost the thread that draws. Mesa's software renderer would start threads of its own.
TEST_F(Drawing, StartsNoThreads) {
  const auto threads = [] {
    return std::distance(std::filesystem::directory_iterator("/proc/self/task"), std::filesystem::directory_iterator());
  };
  const auto drawn = view(eye_of(640, 480));
  if (drawn->renderer().find("llvmpipe") == std::string::npos) GTEST_SKIP() << "this is " << drawn->renderer();
  const auto before = threads();
  Frame frame;
  drawn->draw(pose_at(1.0), frame);
  EXPECT_EQ(threads(), before);
#ifndef CATAN_SANITIZED
  EXPECT_EQ(before, 1);  // sanitizers have threads
#endif
}

TEST(Cameras, ThatCannotBeDrawnAreRefused) {
  const world::Room room(1);
  const auto expect_refused = [](const auto& opened, const char* what) {
    ASSERT_FALSE(opened);
    EXPECT_EQ(opened.error().kind(), ErrorKind::kCaller);
    EXPECT_NE(opened.error().message().find(what), std::string::npos) << opened.error().message();
  };
  expect_refused(check_size(eye_of(0, 480)), "0 x 480");
  expect_refused(check_size(eye_of(640, 5000)), "from 1 to 4096");
  CameraModel bent = eye_of(640, 480);
  bent.k1 = -3.0;
  expect_refused(covering(bent), "lens");
}

}  // namespace
}  // namespace ctn::vr::drawing
