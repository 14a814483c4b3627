#include "pose_graph.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "odometry_error.h"

namespace ctn::navigation {
namespace {

const PoseMatrix kStep = inverse(covariance_of(0.02, 0.02, 0.01));
const PoseMatrix kReturn = inverse(covariance_of(0.02, 0.02, 0.005));

TEST(PoseGraph, BendsAWayWhoseEndIsKnownToWhereItWas) {
  // Round a square, with an odometer that turns too little; the last pose was seen to be at the first.
  std::vector<Pose> truth{{0.0, 0.0, 0.0}};
  std::vector<Pose> poses{{0.0, 0.0, 0.0}};
  std::vector<Constraint> constraints;
  for (std::size_t i = 0; i < 40; ++i) {
    const double turn = i % 10 == 9 ? std::numbers::pi / 2.0 : 0.0;
    truth.push_back(transformed(truth.back(), Pose{0.5, 0.0, turn}));
    const Pose measured{0.5, 0.0, turn - 0.01};
    poses.push_back(transformed(poses.back(), measured));
    constraints.push_back({i, i + 1, measured, kStep});
  }
  const double before = distance(position(poses.back()), position(truth.back()));
  ASSERT_GT(before, 0.5);
  constraints.push_back({0, 40, between(truth[0], truth[40]), kReturn, true});
  relax(poses, constraints);
  EXPECT_GT(constraints.back().trust, 0.5);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    EXPECT_LT(distance(position(poses[i]), position(truth[i])), 0.5 * before) << i;
  }
  EXPECT_LT(distance(position(poses.back()), position(truth.back())), 0.05);
  EXPECT_EQ(poses.front(), truth.front());
}

TEST(PoseGraph, LeavesWhatAgrees) {
  std::vector<Pose> poses{{1.0, 2.0, 0.5}, {2.0, 2.0, 0.1}, {2.0, 3.0, -3.0}};
  const std::vector<Pose> before = poses;
  std::vector<Constraint> constraints{{0, 1, between(poses[0], poses[1]), kStep},
                                      {1, 2, between(poses[1], poses[2]), kStep},
                                      {0, 2, between(poses[0], poses[2]), kReturn, true}};
  EXPECT_LT(relax(poses, constraints).error, 1e-15);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    EXPECT_NEAR(poses[i].x, before[i].x, 1e-9);
    EXPECT_NEAR(poses[i].y, before[i].y, 1e-9);
    EXPECT_NEAR(poses[i].heading, before[i].heading, 1e-9);
  }
}

// Four rounds of a block, with noise; each place is recognised in each later round, and of these measurements some are
// of places that only look alike.
struct Rounds {
  static constexpr std::size_t kRound = 40;

  explicit Rounds(double share_false) {
    std::mt19937_64 random(7);
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> uniform;
    truth.push_back({});
    poses.push_back({});
    for (std::size_t i = 0; i < 4 * kRound; ++i) {
      const Pose step{0.5, 0.0, i % 10 == 9 ? std::numbers::pi / 2.0 : 0.0};
      truth.push_back(transformed(truth.back(), step));
      const Pose measured{step.x + 0.02 * normal(random), step.y + 0.02 * normal(random),
                          step.heading + 0.01 * normal(random)};
      poses.push_back(transformed(poses.back(), measured));
      constraints.push_back({i, i + 1, measured, kStep});
    }
    for (std::size_t i = kRound; i < truth.size(); ++i) {
      const std::size_t old = i - kRound;
      Pose measured = between(truth[old], truth[i]);
      measured.x += 0.01 * normal(random);
      measured.y += 0.01 * normal(random);
      measured.heading += 0.004 * normal(random);
      if (uniform(random) < share_false) {
        measured.x += 1.5;
        outliers.push_back(constraints.size());
      }
      constraints.push_back({old, i, measured, kReturn, true});
    }
  }

  double max_error() const {
    double max = 0.0;
    for (std::size_t i = 0; i < poses.size(); ++i) {
      max = std::max(max, distance(position(poses[i]), position(truth[i])));
    }
    return max;
  }

  std::vector<Pose> truth;
  std::vector<Pose> poses;
  std::vector<Constraint> constraints;
  std::vector<std::size_t> outliers;
};

TEST(PoseGraph, LeavesOutMeasurementsThatContradictTheRest) {
  Rounds clean(0.0);
  ASSERT_GT(clean.max_error(), 0.5);
  relax(clean.poses, clean.constraints);

  Rounds rounds(0.1);
  ASSERT_GE(rounds.outliers.size(), 5U);
  relax(rounds.poses, rounds.constraints);
  EXPECT_LT(rounds.max_error(), clean.max_error() + 0.03);
  for (const std::size_t outlier : rounds.outliers) EXPECT_LT(rounds.constraints[outlier].trust, 0.01);

  // Without the kernel they would bend the way.
  Rounds trusting(0.1);
  for (Constraint& constraint : trusting.constraints) constraint.doubtful = false;
  relax(trusting.poses, trusting.constraints);
  EXPECT_GT(trusting.max_error(), clean.max_error() + 0.2);
}

TEST(PoseGraph, IsTheSameEachTime) {
  Rounds one(0.1);
  Rounds other(0.1);
  relax(one.poses, one.constraints);
  relax(other.poses, other.constraints);
  EXPECT_EQ(one.poses, other.poses);
}

TEST(PoseGraph, KnowsHowUncertainAWayIs) {
  std::vector<Pose> poses{{}};
  std::vector<Constraint> constraints;
  for (std::size_t i = 0; i < 100; ++i) {
    poses.push_back(transformed(poses.back(), Pose{0.5, 0.0, 0.0}));
    constraints.push_back({i, i + 1, {0.5, 0.0, 0.0}, kStep});
  }
  const PoseMatrix way = covariance_between(poses, constraints, 20, 100);
  EXPECT_NEAR(way.xx, 80 * 0.02 * 0.02, 1e-9);
  EXPECT_NEAR(way.hh, 80 * 0.01 * 0.01, 1e-9);
  EXPECT_NEAR(std::sqrt(way.yy), 0.01 * 40.0 * std::sqrt(80.0 / 3.0), 0.1);  // errors of the heading, added up
  constraints.push_back({20, 100, between(poses[20], poses[100]), kReturn, true});
  const PoseMatrix closed = covariance_between(poses, constraints, 20, 100);
  EXPECT_LT(closed.yy, 0.02 * 0.02);
  constraints.back().trust = 0.0;
  EXPECT_NEAR(covariance_between(poses, constraints, 20, 100).yy, way.yy, 1e-9);
}

// As the world draws it.
TEST(OdometryError, GrowsAsTheNoiseOfTheWheelsDoes) {
  constexpr OdometryNoise kNoise;
  OdometryError error;
  error.start({1.0, 2.0, 0.5});
  Pose pose{1.0, 2.0, 0.5};
  for (int i = 0; i < 400; ++i) {
    pose = along_arc(pose, 0.01, 0.0);
    error.follow(pose);
  }
  const PoseMatrix straight = error.covariance();
  EXPECT_NEAR(std::sqrt(straight.xx), 2.0 * kNoise.distance_per_metre, 0.002);
  EXPECT_NEAR(std::sqrt(straight.hh), 2.0 * kNoise.turn_per_metre, 0.001);
  EXPECT_NEAR(std::sqrt(straight.yy), 2.0 * kNoise.turn_per_metre * 4.0 / std::sqrt(3.0), 0.002);
  error.start(pose);
  for (int i = 0; i < 100; ++i) {
    pose = along_arc(pose, 0.0, 0.01);
    error.follow(pose);
  }
  EXPECT_NEAR(std::sqrt(error.covariance().hh), kNoise.turn_per_radian, 0.001);
  EXPECT_LT(std::sqrt(error.covariance().xx), 0.0015);
}

}  // namespace
}  // namespace ctn::navigation
