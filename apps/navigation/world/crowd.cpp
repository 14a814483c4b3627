#include "crowd.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "grid.h"
#include "program/random.h"

namespace ctn::navigation::world {
namespace {

constexpr double kCell = 0.1;
constexpr double kFree = 2.5;      // so near to either end there is neither clutter nor a mover
constexpr double kFromEnd = 1.2;   // of start and goal
constexpr double kToWalls = 0.15;  // that movers keep
constexpr int kTries = 300;
constexpr std::uint64_t kClutter = 4;  // streams of random numbers
constexpr std::uint64_t kPaths = 5;

// World files have three digits after the point.
double rounded(double value) { return std::round(value * 1000.0) / 1000.0; }

std::vector<Point> corners_of(Point centre, double length, double width, double heading) {
  std::vector<Point> corners;
  for (const auto& [along, across] : {std::pair{-1.0, -1.0}, {1.0, -1.0}, {1.0, 1.0}, {-1.0, 1.0}}) {
    const double x = along * length / 2.0;
    const double y = across * width / 2.0;
    corners.push_back({rounded(centre.x + x * std::cos(heading) - y * std::sin(heading)),
                       rounded(centre.y + x * std::sin(heading) + y * std::cos(heading))});
  }
  return corners;
}

void add_clutter(WorldFile& world, const CrowdSpec& spec) {
  program::Draws draws(spec.seed, kClutter);
  const double radius = kRobotSide / std::numbers::sqrt2 + kCell;
  Grid grid(world, kCell);
  double covered = 0.0;
  for (int i = 0; i < kTries && covered < spec.density * spec.length * spec.width; ++i) {
    const double length = draws.between(0.3, 1.4);
    const double width = draws.between(0.3, 0.8);
    const double reach = std::hypot(length, width) / 2.0;
    const Point centre{draws.between(kFree, spec.length - kFree), draws.between(reach, spec.width - reach)};
    const double heading = draws.between(0.0, std::numbers::pi);
    WorldFile block;
    add_block(block, corners_of(centre, length, width, heading));
    Grid with = grid;
    for (const Segment& side : block.walls) with.add(side);
    if (!with.path_exists(position(world.start), *world.goal, radius)) continue;
    grid = std::move(with);
    add_block(world, std::move(block.blocks.front()));
    covered += length * width;
  }
}

bool clear_way(const Grid& grid, Point from, Point to, double reach) {
  const int pieces = 1 + static_cast<int>(distance(from, to) / kCell);
  for (int i = 0; i <= pieces; ++i) {
    if (grid.clearance(from + (to - from) * (static_cast<double>(i) / pieces)) < reach + kToWalls) return false;
  }
  return true;
}

void add_movers(WorldFile& world, const CrowdSpec& spec) {
  program::Draws draws(spec.seed, kPaths);
  const Grid grid(world, kCell);
  for (int i = 0; i < kTries && std::cmp_less(world.movers.size(), spec.movers); ++i) {
    MoverSpec mover;
    if (draws.between(0, 2) == 0) {
      mover.radius = rounded(draws.between(0.2, 0.4));
    } else {
      mover.length = mover.width = kRobotSide;
      mover.heading = static_cast<double>(draws.between(0, 89)) * (std::numbers::pi / 180.0);
    }
    mover.speed = rounded(draws.between(0.2, 0.8));
    mover.pause = draws.between(0, 1) == 0 ? 0.0 : rounded(draws.between(0.2, 2.0));
    const int points = draws.between(2, 4);
    for (int tries = 0; tries < kTries && std::cmp_less(mover.path.size(), points); ++tries) {
      const Point next{rounded(draws.between(kFree, spec.length - kFree)), rounded(draws.between(0.0, spec.width))};
      const Point before = mover.path.empty() ? next : mover.path.back();
      if (!mover.path.empty() && distance(before, next) < 2.0) continue;
      if (clear_way(grid, before, next, mover.reach())) mover.path.push_back(next);
    }
    const double share = draws.between(0.0, 1.0);
    if (std::cmp_less(mover.path.size(), points)) continue;
    mover.closed = points > 2 && clear_way(grid, mover.path.back(), mover.path.front(), mover.reach());
    mover.phase = rounded(share * Mover(mover, 0.0).cycle());
    world.movers.push_back(std::move(mover));
  }
}

}  // namespace

WorldFile make_crowd(const CrowdSpec& spec) {
  WorldFile world;
  world.name = fmt::format("crowd {}", spec.seed);
  world.bounds = {{0.0, 0.0}, {spec.length, spec.width}};
  const std::vector<Point> around{{0.0, 0.0}, {spec.length, 0.0}, {spec.length, spec.width}, {0.0, spec.width}};
  for (std::size_t i = 0; i < around.size(); ++i) world.walls.push_back({around[i], around[(i + 1) % around.size()]});
  world.start = {kFromEnd, spec.width / 2.0, 0.0};
  world.goal = Point{spec.length - kFromEnd, spec.width / 2.0};
  add_clutter(world, spec);
  add_movers(world, spec);
  return world;
}

}  // namespace ctn::navigation::world
