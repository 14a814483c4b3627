#include "loop_closure.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>

#include "testing/analytic_world.h"

namespace ctn::navigation {
namespace {

using testing::AnalyticWorld;
using testing::Wall;

// A corridor along the x axis, 2.5 m wide, with a doorway on the left from x = 1.5 m to `door_ends`, into a room of 4
// m.
std::vector<Wall> corridor(double door_ends) {
  std::vector<Wall> walls;
  testing::add_box(walls, -40.0, 0.0, 40.0, 8.0);
  walls.push_back({{-40.0, 2.5}, {1.5, 2.5}});
  walls.push_back({{door_ends, 2.5}, {40.0, 2.5}});
  walls.push_back({{0.5, 2.5}, {0.5, 8.0}});
  walls.push_back({{4.5, 2.5}, {4.5, 8.0}});
  return walls;
}
constexpr double kClosed = 1.5;

SharedScan scan_in(const std::vector<Wall>& walls, const Pose& pose, std::uint64_t seed) {
  AnalyticWorld world(walls, pose, {.range = 0.01}, seed);
  return ScanFilter{}.run(world.scan(), world.odometry()).scan;
}

// Some keyframes of a drive along the corridor, the one at x = 0 first.
struct Drive {
  explicit Drive(const std::vector<Wall>& walls) {
    for (const int i : {0, -3, -2, -1, 1, 2, 3}) {
      poses.push_back({0.45 * i, 1.25, 0.0});
      scans.push_back(scan_in(walls, poses.back(), static_cast<std::uint64_t>(10 + i)));
    }
  }
  std::vector<Sight> sights() const {
    std::vector<Sight> sights;
    for (std::size_t i = 0; i < poses.size(); ++i) sights.push_back({poses[i], *scans[i], scans[i]->points});
    return sights;
  }
  std::vector<Pose> poses;
  std::vector<SharedScan> scans;
};

const PoseMatrix kDrift = covariance_of(0.3, 0.2, 0.03);

std::optional<Recognised> recognised(const Drive& drive, const CleanScan& scan, const Pose& expected,
                                     const PoseMatrix& drift) {
  Work work;
  return recognise(drive.sights(), {expected, scan, scan.points}, drift, work);
}

TEST(LoopClosure, FindsAPlaceAgainAfterDrift) {
  const std::vector<Wall> walls = corridor(3.0);
  const Pose truth{0.2, 1.4, 0.1};
  const SharedScan scan = scan_in(walls, truth, 99);
  const auto found = recognised(Drive(walls), *scan, {truth.x + 0.35, truth.y - 0.2, truth.heading - 0.04}, kDrift);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->pose.x, truth.x, 0.03);
  EXPECT_NEAR(found->pose.y, truth.y, 0.02);
  EXPECT_NEAR(found->pose.heading, truth.heading, 0.005);
  EXPECT_LT(std::sqrt(found->covariance.xx), 0.1);
}

TEST(LoopClosure, SaysNothingAlongACorridorWithoutDoors) {
  const std::vector<Wall> walls = corridor(kClosed);
  const Pose truth{0.2, 1.4, 0.1};
  const Pose expected{truth.x + 0.35, truth.y - 0.2, truth.heading - 0.04};
  const SharedScan scan = scan_in(walls, truth, 99);
  const auto found = recognised(Drive(walls), *scan, expected, kDrift);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->pose.y, truth.y, 0.02);
  EXPECT_NEAR(found->pose.heading, truth.heading, 0.005);
  const PoseMatrix information = inverse(found->covariance);
  EXPECT_GT(std::sqrt(found->covariance.xx), 0.15);
  EXPECT_LT(information.xx, 0.02 * information.yy);
}

// Another corridor, whose walls look the same but for the door.
TEST(LoopClosure, RejectsACorridorWhoseDoorIsMissing) {
  const SharedScan scan = scan_in(corridor(kClosed), {0.0, 1.25, 0.0}, 99);
  EXPECT_FALSE(recognised(Drive(corridor(3.0)), *scan, {0.1, 1.2, 0.01}, kDrift));
  const SharedScan open = scan_in(corridor(3.0), {0.0, 1.25, 0.0}, 99);
  EXPECT_FALSE(recognised(Drive(corridor(kClosed)), *open, {0.1, 1.2, 0.01}, kDrift));
}

// The walls look the same, from where the robot cannot be by what it has driven.
TEST(LoopClosure, RejectsAPlaceThatIsTooFarAway) {
  const std::vector<Wall> walls = corridor(3.0);
  const Pose truth{0.0, 1.25, 0.0};
  const SharedScan scan = scan_in(walls, truth, 99);
  const Drive drive(walls);
  const PoseMatrix certain = covariance_of(0.04, 0.04, 0.01);
  EXPECT_TRUE(recognised(drive, *scan, {0.08, 1.2, 0.01}, certain));
  EXPECT_FALSE(recognised(drive, *scan, {0.7, 1.25, 0.0}, certain));
  EXPECT_FALSE(recognised(drive, *scan, {0.0, 1.49, 0.0}, certain));
}

TEST(LoopClosure, CountsWhatItLookedAt) {
  const std::vector<Wall> walls = corridor(3.0);
  const SharedScan scan = scan_in(walls, {0.0, 1.25, 0.0}, 99);
  const Drive drive(walls);
  const auto work_of = [&](const PoseMatrix& drift) {
    Work work;
    recognise(drive.sights(), {{0.1, 1.2, 0.01}, *scan, scan->points}, drift, work);
    return work;
  };
  const Work narrow = work_of(covariance_of(0.1, 0.1, 0.03));
  EXPECT_GT(narrow.beams, 0U);
  EXPECT_GT(narrow.cells, 0U);
  EXPECT_GT(work_of(kDrift).candidates, 3 * narrow.candidates);  // a window three times as wide to each side
  EXPECT_EQ(work_of(kDrift), work_of(kDrift));
}

}  // namespace
}  // namespace ctn::navigation
