#include "global_planner.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <queue>

namespace ctn::navigation {
namespace {

constexpr double kEscape = 0.6;      // around the robot, where cells nearer to obstacles than kClearance may be crossed
constexpr float kTightCost = 10.0F;  // of such a cell
constexpr float kNearCost = 3.0F;    // of a cell at kClearance, more than of one in the open
constexpr float kUnknownCost = 3.0F;       // likewise of an unknown one
constexpr double kFrontierDistance = 0.5;  // the robot sees nearer ones by turning

struct Step {
  int column;
  int row;
  float length;
};
constexpr float kDiagonal = std::numbers::sqrt2_v<float>;
constexpr std::array<Step, 8> kSteps{{{1, 0, 1.0F},
                                      {0, 1, 1.0F},
                                      {-1, 0, 1.0F},
                                      {0, -1, 1.0F},
                                      {1, 1, kDiagonal},
                                      {-1, 1, kDiagonal},
                                      {-1, -1, kDiagonal},
                                      {1, -1, kDiagonal}}};

// One search over the cells of one map.
class Search {
 public:
  Search(const GlobalMap& map, const Pose& robot, bool through_unknown)
      : map_(map), frame_(map.frame), robot_(position(robot)), through_unknown_(through_unknown) {
    std::vector<std::uint8_t> obstacles(map.cells.size());
    std::transform(map.cells.begin(), map.cells.end(), obstacles.begin(),
                   [](Cell cell) { return static_cast<std::uint8_t>(cell == Cell::kObstacle); });
    clearance_ = navigation::clearance(frame_, obstacles, GlobalPlanner::kComfortable);
    work_.cells += 4 * frame_.cells();
  }

  // The cells of frontiers that are large enough.
  std::vector<std::uint8_t> frontiers() {
    std::vector<std::uint8_t> kind(frame_.cells(), 0);  // 1: borders on the unknown, 2: in a large enough group
    for (int row = 1; row + 1 < frame_.height; ++row) {
      for (int column = 1; column + 1 < frame_.width; ++column) {
        if (borders_on_unknown(column, row)) kind[frame_.index(column, row)] = 1;
      }
    }
    std::vector<std::uint8_t> large(frame_.cells(), 0);
    std::vector<std::size_t> group;
    for (std::size_t cell = 0; cell < kind.size(); ++cell) {
      if (kind[cell] != 1) continue;
      collect(cell, kind, group);
      if (static_cast<double>(group.size()) * kCell < GlobalPlanner::kSmallestFrontier) continue;
      for (const std::size_t member : group) large[member] = 1;
    }
    work_.cells += 2 * frame_.cells();
    return large;
  }

  // The cells from the robot to the first one for which `is_end` holds; none: there is no way. `estimate` must not
  // exceed the cost of the way that is left.
  std::vector<std::size_t> run(const std::function<bool(std::size_t)>& is_end,
                               const std::function<float(int, int)>& estimate) {
    const int start_column = frame_.column(robot_.x);
    const int start_row = frame_.row(robot_.y);
    if (!frame_.inside(start_column, start_row)) return {};
    const std::size_t start = frame_.index(start_column, start_row);
    constexpr float kUnreached = std::numeric_limits<float>::max();
    std::vector<float> cost(frame_.cells(), kUnreached);
    std::vector<std::uint32_t> before(frame_.cells(), 0);
    using Entry =
        std::pair<float, std::uint32_t>;  // expected cost of the whole way; of equal ones the lower cell comes first
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
    std::vector<std::uint8_t> closed(frame_.cells(), 0);
    cost[start] = 0.0F;
    open.emplace(0.0F, static_cast<std::uint32_t>(start));
    while (!open.empty()) {
      const std::size_t cell = open.top().second;
      open.pop();
      if (closed[cell] != 0) continue;
      closed[cell] = 1;
      ++work_.expanded;
      if (is_end(cell)) return way_to(cell, start, before);
      const int column = static_cast<int>(cell % static_cast<std::size_t>(frame_.width));
      const int row = static_cast<int>(cell / static_cast<std::size_t>(frame_.width));
      for (const Step& step : kSteps) {
        const int to_column = column + step.column;
        const int to_row = row + step.row;
        if (!frame_.inside(to_column, to_row)) continue;
        const std::size_t to = frame_.index(to_column, to_row);
        if (closed[to] != 0) continue;
        const float factor = cost_of(to, to_column, to_row);
        if (factor <= 0.0F) continue;
        const float reached = cost[cell] + step.length * factor;
        if (reached >= cost[to]) continue;
        cost[to] = reached;
        before[to] = static_cast<std::uint32_t>(cell);
        open.emplace(reached + estimate(to_column, to_row), static_cast<std::uint32_t>(to));
      }
    }
    return {};
  }

  Point centre(std::size_t cell) const {
    return frame_.centre(static_cast<int>(cell % static_cast<std::size_t>(frame_.width)),
                         static_cast<int>(cell / static_cast<std::size_t>(frame_.width)));
  }
  const Work& work() const { return work_; }

 private:
  bool wide(std::size_t cell) const { return static_cast<double>(clearance_[cell]) >= GlobalPlanner::kClearance; }

  bool borders_on_unknown(int column, int row) const {
    const std::size_t cell = frame_.index(column, row);
    if (map_.cells[cell] != Cell::kFree || !wide(cell)) return false;
    const auto width = static_cast<std::size_t>(frame_.width);
    return map_.cells[cell - 1] == Cell::kUnknown || map_.cells[cell + 1] == Cell::kUnknown ||
           map_.cells[cell - width] == Cell::kUnknown || map_.cells[cell + width] == Cell::kUnknown;
  }

  // The group of neighbours that `cell`, which is of kind 1, belongs to; all become of kind 2.
  void collect(std::size_t cell, std::vector<std::uint8_t>& kind, std::vector<std::size_t>& group) const {
    group.assign(1, cell);
    kind[cell] = 2;
    for (std::size_t next = 0; next < group.size(); ++next) {
      const int column = static_cast<int>(group[next] % static_cast<std::size_t>(frame_.width));
      const int row = static_cast<int>(group[next] / static_cast<std::size_t>(frame_.width));
      for (const Step& step : kSteps) {
        if (!frame_.inside(column + step.column, row + step.row)) continue;
        const std::size_t neighbour = frame_.index(column + step.column, row + step.row);
        if (kind[neighbour] != 1) continue;
        kind[neighbour] = 2;
        group.push_back(neighbour);
      }
    }
  }

  // The cost of a step into the cell, per length; 0: the step is not allowed.
  float cost_of(std::size_t cell, int column, int row) const {
    if (map_.cells[cell] == Cell::kObstacle) return 0.0F;
    const double clear = static_cast<double>(clearance_[cell]);
    if (map_.cells[cell] == Cell::kUnknown && !through_unknown_) {
      // The robot may not have seen the cells that it stands on.
      return distance(frame_.centre(column, row), robot_) <= kEscape ? kTightCost : 0.0F;
    }
    if (clear < GlobalPlanner::kClearance) {
      return distance(frame_.centre(column, row), robot_) <= kEscape ? kTightCost : 0.0F;
    }
    const double missing =
        (GlobalPlanner::kComfortable - clear) / (GlobalPlanner::kComfortable - GlobalPlanner::kClearance);
    const float unknown = map_.cells[cell] == Cell::kUnknown ? kUnknownCost : 0.0F;
    return 1.0F + kNearCost * static_cast<float>(missing) + unknown;
  }

  static std::vector<std::size_t> way_to(std::size_t end, std::size_t start, const std::vector<std::uint32_t>& before) {
    std::vector<std::size_t> way{end};
    while (way.back() != start) way.push_back(before[way.back()]);
    std::reverse(way.begin(), way.end());
    return way;
  }

  const GlobalMap& map_;
  GridFrame frame_;
  Point robot_;
  bool through_unknown_;
  std::vector<float> clearance_;
  Work work_;
};

// One point for every so many cells, and one for the last cell.
std::vector<Point> thinned(const Search& search, const std::vector<std::size_t>& way) {
  const auto spacing = static_cast<std::size_t>(Path::kSpacing / (kCell * std::numbers::sqrt2));
  std::vector<Point> points;
  for (std::size_t i = 0; i < way.size(); ++i) {
    if (i % spacing == 0 || i + 1 == way.size()) points.push_back(search.centre(way[i]));
  }
  return points;
}

// The map with unknown cells around it, as far as `point` and a little more.
GlobalMap extended(const GlobalMap& map, const Point& point) {
  constexpr int kMore = 25;
  const int column = map.frame.column(point.x);
  const int row = map.frame.row(point.y);
  const int left = std::min(0, column - kMore);
  const int bottom = std::min(0, row - kMore);
  GlobalMap larger;
  larger.stamp = map.stamp;
  larger.frame = {map.frame.left + left, map.frame.bottom + bottom, std::max(map.frame.width, column + kMore) - left,
                  std::max(map.frame.height, row + kMore) - bottom};
  larger.cells.assign(larger.frame.cells(), Cell::kUnknown);
  for (int at_row = 0; at_row < map.frame.height; ++at_row) {
    for (int at_column = 0; at_column < map.frame.width; ++at_column) {
      larger.cells[larger.frame.index(at_column - left, at_row - bottom)] =
          map.cells[map.frame.index(at_column, at_row)];
    }
  }
  return larger;
}

}  // namespace

GlobalPlanner::Result GlobalPlanner::run(const GlobalMap& map, const Pose& robot,
                                         const std::optional<Point>& goal) const {
  Result result;
  result.path.stamp = map.stamp;
  if (map.cells.empty()) return result;
  if (goal && !map.frame.inside(map.frame.column(goal->x), map.frame.row(goal->y))) {
    return run(extended(map, *goal), robot, goal);
  }

  Search search(map, robot, goal.has_value());
  std::vector<std::size_t> way;
  if (goal) {
    const int column = map.frame.column(goal->x);
    const int row = map.frame.row(goal->y);
    const std::size_t end = map.frame.index(column, row);
    way = search.run([end](std::size_t cell) { return cell == end; },
                     [column, row](int at_column, int at_row) {
                       const auto dx = static_cast<float>(std::abs(at_column - column));
                       const auto dy = static_cast<float>(std::abs(at_row - row));
                       return std::max(dx, dy) + (kDiagonal - 1.0F) * std::min(dx, dy);
                     });
    result.path.to_goal = true;
    result.path.outcome = way.empty() ? Path::Outcome::kNoWay : Path::Outcome::kFound;
  } else {
    const std::vector<std::uint8_t> frontiers = search.frontiers();
    const Point from = position(robot);
    way = search.run(
        [&](std::size_t cell) {
          return frontiers[cell] != 0 && distance(search.centre(cell), from) >= kFrontierDistance;
        },
        [](int, int) { return 0.0F; });
    result.path.outcome = way.empty() ? Path::Outcome::kNothingLeft : Path::Outcome::kFound;
  }
  result.path.points = thinned(search, way);
  result.work = search.work();
  return result;
}

}  // namespace ctn::navigation
