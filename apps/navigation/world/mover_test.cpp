#include "mover.h"

#include <gtest/gtest.h>

namespace ctn::navigation::world {
namespace {

MoverSpec mover_on(std::vector<Point> path) {
  MoverSpec spec;
  spec.path = std::move(path);
  spec.speed = 2.0;
  spec.length = spec.width = 0.5;
  return spec;
}

void expect_at(const Mover& mover, double seconds, Point where) {
  EXPECT_NEAR(mover.at(seconds).x, where.x, 1e-9) << "at " << seconds << " s";
  EXPECT_NEAR(mover.at(seconds).y, where.y, 1e-9) << "at " << seconds << " s";
}

TEST(Mover, GoesThereAndBack) {
  const Mover mover(mover_on({{0, 0}, {4, 0}, {4, 2}}), 0.0);
  EXPECT_DOUBLE_EQ(mover.cycle(), 6.0);
  expect_at(mover, 0.0, {0, 0});
  expect_at(mover, 1.0, {2, 0});
  expect_at(mover, 2.5, {4, 1});
  expect_at(mover, 3.0, {4, 2});
  expect_at(mover, 3.5, {4, 1});
  expect_at(mover, 5.0, {2, 0});
  expect_at(mover, 7.0, {2, 0});
}

TEST(Mover, GoesRoundWhereItsPathIsClosed) {
  MoverSpec spec = mover_on({{0, 0}, {3, 0}, {3, 4}});
  spec.closed = true;
  const Mover mover(spec, 0.0);
  EXPECT_DOUBLE_EQ(mover.cycle(), 6.0);
  expect_at(mover, 4.75, {1.5, 2});
  expect_at(mover, 6.5, {1, 0});
}

TEST(Mover, PausesAtEachPoint) {
  MoverSpec spec = mover_on({{0, 0}, {4, 0}});
  spec.pause = 1.0;
  const Mover mover(spec, 0.0);
  EXPECT_DOUBLE_EQ(mover.cycle(), 6.0);
  expect_at(mover, 0.9, {0, 0});
  expect_at(mover, 2.0, {2, 0});
  expect_at(mover, 3.0, {4, 0});
  expect_at(mover, 3.9, {4, 0});
  expect_at(mover, 5.0, {2, 0});
}

TEST(Mover, BeginsAtItsPhase) {
  MoverSpec spec = mover_on({{0, 0}, {4, 0}});
  spec.phase = 1.5;
  expect_at(Mover(spec, 0.9), 0.0, {3, 0});
  spec.phase.reset();
  expect_at(Mover(spec, 0.25), 0.0, {2, 0});
}

}  // namespace
}  // namespace ctn::navigation::world
