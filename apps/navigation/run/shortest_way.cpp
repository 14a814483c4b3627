#include "run/shortest_way.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <queue>
#include <utility>
#include <vector>

#include "robot.h"
#include "world/grid.h"

namespace ctn::navigation::run {
namespace {

constexpr double kResolution = 0.1;
constexpr double kNeeded = kRobotSide / 2.0;

// The cells of a shortest way through sides and corners of cells, both ends included; empty: there is none.
std::vector<std::size_t> way_through(const world::Grid& grid, std::size_t from, std::size_t to) {
  constexpr double kUnreached = std::numeric_limits<double>::infinity();
  std::vector<double> length(grid.size(), kUnreached);
  std::vector<std::size_t> before(grid.size(), from);
  using Entry = std::pair<double, std::size_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  length[from] = 0.0;
  open.emplace(0.0, from);
  while (!open.empty()) {
    const auto [reached, cell] = open.top();
    open.pop();
    if (reached > length[cell]) continue;
    if (cell == to) break;
    const Point at = grid.centre(cell);
    for (int row = -1; row <= 1; ++row) {
      for (int column = -1; column <= 1; ++column) {
        const auto next = grid.cell({at.x + column * kResolution, at.y + row * kResolution});
        if (!next || *next == cell || (*next != to && grid.clearance(grid.centre(*next)) < kNeeded)) continue;
        const double longer = reached + kResolution * std::hypot(column, row);
        if (longer >= length[*next]) continue;
        length[*next] = longer;
        before[*next] = cell;
        open.emplace(longer, *next);
      }
    }
  }
  if (length[to] == kUnreached) return {};
  std::vector<std::size_t> way{to};
  while (way.back() != from) way.push_back(before[way.back()]);
  std::reverse(way.begin(), way.end());
  return way;
}

bool has_room(const world::Grid& grid, Point from, Point to) {
  const int steps = static_cast<int>(std::ceil(distance(from, to) / (kResolution / 2.0)));
  for (int i = 1; i < steps; ++i) {
    if (grid.clearance(from + (to - from) * (static_cast<double>(i) / steps)) < kNeeded) return false;
  }
  return true;
}

}  // namespace

std::optional<double> shortest_way(const world::WorldFile& world) {
  if (!world.goal) return std::nullopt;
  const world::Grid grid(world, kResolution);
  const auto from = grid.cell(position(world.start));
  const auto to = grid.cell(*world.goal);
  if (!from || !to) return std::nullopt;
  std::vector<Point> points;
  for (const std::size_t cell : way_through(grid, *from, *to)) points.push_back(grid.centre(cell));
  if (points.empty()) return std::nullopt;
  points.front() = position(world.start);
  points.back() = *world.goal;

  double length = 0.0;
  for (std::size_t at = 0; at + 1 < points.size();) {
    std::size_t next = points.size() - 1;
    while (next > at + 1 && !has_room(grid, points[at], points[next])) --next;
    length += distance(points[at], points[next]);
    at = next;
  }
  return length;
}

}  // namespace ctn::navigation::run
