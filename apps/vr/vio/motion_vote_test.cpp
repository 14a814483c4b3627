#include "vio/motion_vote.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "vio/rotation.h"

namespace ctn::vr {
namespace {

constexpr double kTolerance = 2.0 / 400.0;

struct Tracks {
  std::vector<Eigen::Vector2d> before;
  std::vector<Eigen::Vector2d> now;
  Eigen::Quaterniond now_from_before;
};

// Points 2 to 6 m away, of a camera that turns by 10 degrees and moves.
Tracks tracks_of(const Eigen::Vector3d& translation, std::size_t count, double noise) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  std::normal_distribution<double> normal(0.0, noise);
  Tracks tracks;
  tracks.now_from_before = rotation({0.02, 0.17, -0.03});
  for (std::size_t i = 0; i < count; ++i) {
    const double distance = 4.0 + 2.0 * uniform(random);
    const Eigen::Vector3d point = distance * Eigen::Vector3d(0.6 * uniform(random), 0.5 * uniform(random), 1.0);
    tracks.before.emplace_back(point.hnormalized());
    const Eigen::Vector3d seen = tracks.now_from_before * point + translation;
    tracks.now.emplace_back(seen.hnormalized() + Eigen::Vector2d(normal(random), normal(random)));
  }
  return tracks;
}

std::size_t inliers(const MotionVote& vote) {
  return static_cast<std::size_t>(std::count(vote.inlier.begin(), vote.inlier.end(), 1));
}

TEST(MotionVote, KeepsWhatOneMotionExplains) {
  for (const Eigen::Vector3d& translation :
       {Eigen::Vector3d(0.1, 0.0, 0.0), Eigen::Vector3d(0.0, 0.02, 0.1), Eigen::Vector3d(0.0, 0.0, -0.2)}) {
    const Tracks tracks = tracks_of(translation, 100, 0.5 / 400.0);
    EXPECT_GE(inliers(vote(tracks.before, tracks.now, tracks.now_from_before, kTolerance, 1)), 97U);
  }
}

TEST(MotionVote, KeepsAllWhereTheCameraOnlyTurns) {
  const Tracks tracks = tracks_of(Eigen::Vector3d::Zero(), 50, 0.0);
  EXPECT_EQ(inliers(vote(tracks.before, tracks.now, tracks.now_from_before, kTolerance, 1)), 50U);
}

TEST(MotionVote, FindsOutliersAmongTwoFifths) {
  Tracks tracks = tracks_of({0.1, 0.0, 0.0}, 100, 0.3 / 400.0);
  std::mt19937 random(4);
  std::uniform_real_distribution<double> uniform(0.04, 0.2);
  for (std::size_t i = 0; i < 40; ++i) tracks.now[i].y() += (i % 2 == 0 ? 1.0 : -1.0) * uniform(random);
  const MotionVote found = vote(tracks.before, tracks.now, tracks.now_from_before, kTolerance, 1);
  for (std::size_t i = 0; i < 40; ++i) EXPECT_EQ(found.inlier[i], 0) << i;
  EXPECT_GE(inliers(found), 57U);
}

TEST(MotionVote, IsTheSameEachTimeAndCounted) {
  const Tracks tracks = tracks_of({0.1, 0.0, 0.0}, 30, 2.0 / 400.0);
  const MotionVote one = vote(tracks.before, tracks.now, tracks.now_from_before, kTolerance, 7);
  const MotionVote other = vote(tracks.before, tracks.now, tracks.now_from_before, kTolerance, 7);
  EXPECT_EQ(one.inlier, other.inlier);
  EXPECT_EQ(one.work, other.work);
  EXPECT_GE(one.work.votes, 30U);
  EXPECT_EQ(one.work.votes % 30U, 0U);
}

TEST(MotionVote, OfFewOrNone) {
  EXPECT_TRUE(vote({}, {}, Eigen::Quaterniond::Identity(), kTolerance, 1).inlier.empty());
  const Tracks tracks = tracks_of({0.1, 0.0, 0.0}, 1, 0.0);
  EXPECT_EQ(vote(tracks.before, tracks.now, tracks.now_from_before, kTolerance, 1).inlier.size(), 1U);
}

}  // namespace
}  // namespace ctn::vr
