#include "visibility.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "testing/analytic_world.h"

namespace ctn::navigation {
namespace {

using testing::AnalyticWorld;

// A room of 10 m x 6 m, perhaps with a box in it; the robot looks along x.
SharedScan scan_from(const Pose& pose, bool box) {
  AnalyticWorld world({}, pose, {.range = 0.01});
  testing::add_box(world.walls(), 0.0, 0.0, 10.0, 6.0);
  if (box) testing::add_box(world.walls(), 4.0, 2.8, 4.5, 3.3);
  return ScanFilter{}.run(world.scan(), world.odometry()).scan;
}

TEST(Visibility, KnowsWhatAScanSawThrough) {
  const SharedScan scan = scan_from({1.0, 3.0, 0.0}, true);
  EXPECT_EQ(seen(*scan, {2.0, 0.0}), Seen::kFree);
  EXPECT_EQ(seen(*scan, {2.9, 0.0}), Seen::kOther);     // where the box begins, and just before
  EXPECT_EQ(seen(*scan, {5.0, 0.0}), Seen::kOther);     // behind it
  EXPECT_EQ(seen(*scan, {5.0, 1.5}), Seen::kFree);      // beside it
  EXPECT_EQ(seen(*scan, {-1.0, 0.1}), Seen::kUnknown);  // behind the robot
  EXPECT_EQ(seen(*scan, {20.0, 0.0}), Seen::kUnknown);  // too far away
  EXPECT_EQ(seen({}, {1.0, 0.0}), Seen::kUnknown);      // no beams
}

TEST(Visibility, AScanDoesNotSeeThroughTheWallsThatAnotherOneHit) {
  const SharedScan scan = scan_from({1.0, 3.0, 0.0}, false);
  const Pose elsewhere{2.0, 1.0, 0.4};
  const Conflict found = conflict(*scan, between({1.0, 3.0, 0.0}, elsewhere), scan_from(elsewhere, false)->points);
  EXPECT_GT(found.judged, 200U);
  EXPECT_LT(found.free, found.judged / 100);
}

TEST(Visibility, LeavesOutWhatWasNotThere) {
  const Pose before{1.0, 3.0, 0.0};
  const Pose now{1.4, 3.1, 0.1};
  const SharedScan empty = scan_from(before, false);
  std::vector<Point> points = scan_from(now, true)->points;
  const auto on_box = [&](const Point& point) {
    const Point at = transformed(now, point);
    return at.x > 3.9 && at.x < 4.6 && at.y > 2.7 && at.y < 3.4;
  };
  const auto shown = std::count_if(points.begin(), points.end(), on_box);
  const std::size_t all = points.size();
  ASSERT_GT(shown, 10);
  remove_free(*empty, between(before, now), points);
  EXPECT_EQ(std::count_if(points.begin(), points.end(), on_box), 0);
  EXPECT_GE(points.size() + static_cast<std::size_t>(shown) + 3, all);  // the walls stay
}

}  // namespace
}  // namespace ctn::navigation
