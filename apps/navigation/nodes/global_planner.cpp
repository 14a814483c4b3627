#include "global_planner.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <optional>
#include <queue>
#include <utility>

#include "robot.h"
#include "visibility.h"

namespace ctn::navigation {
namespace {

constexpr double kEscape = 0.6;      // around the robot, where cells nearer to obstacles than kClearance may be crossed
constexpr float kTightCost = 10.0F;  // of such a cell
constexpr float kNearCost = 3.0F;    // of a cell at kClearance, more than of one in the open
constexpr float kUnknownCost = 3.0F;       // likewise of an unknown one
constexpr double kFrontierDistance = 0.5;  // the robot sees nearer ones by turning
constexpr double kFrontierGain = 1.0;      // metres of way that a metre of a frontier is worth
constexpr double kFrontierMax = 3.0;       // a longer one is worth no more

// To the eight cells around, and to the eight in between, a knight's move away: straighter ways, whose length is at
// most 3 % from the shortest one's. The first eight are the cells around.
struct Step {
  int column;
  int row;
  float length;
};
constexpr std::size_t kAround = 8;
constexpr float kDiagonal = std::numbers::sqrt2_v<float>;
constexpr float kKnight = 2.2360680F;  // the root of 5
constexpr std::array<Step, 16> kSteps{{{1, 0, 1.0F},
                                       {0, 1, 1.0F},
                                       {-1, 0, 1.0F},
                                       {0, -1, 1.0F},
                                       {1, 1, kDiagonal},
                                       {-1, 1, kDiagonal},
                                       {-1, -1, kDiagonal},
                                       {1, -1, kDiagonal},
                                       {2, 1, kKnight},
                                       {1, 2, kKnight},
                                       {-1, 2, kKnight},
                                       {-2, 1, kKnight},
                                       {-2, -1, kKnight},
                                       {-1, -2, kKnight},
                                       {1, -2, kKnight},
                                       {2, -1, kKnight}}};

// Places that are obstacles although the map has none there.
using Extra = std::vector<Point>;

// One search over the cells of one map.
class Search {
 public:
  Search(const GlobalMap& map, const Point& robot, const Extra& extra, bool through_unknown)
      : map_(map), frame_(map.frame), robot_(robot) {
    std::vector<std::uint8_t> obstacles(map.cells.size());
    std::transform(map.cells.begin(), map.cells.end(), obstacles.begin(),
                   [](Cell cell) { return static_cast<std::uint8_t>(cell == Cell::kObstacle); });
    for (const Point& point : extra) {
      const int column = frame_.column(point.x);
      const int row = frame_.row(point.y);
      if (frame_.inside(column, row)) obstacles[frame_.index(column, row)] = 1;
    }
    clearance_ = navigation::clearance(frame_, obstacles, GlobalPlanner::kComfortable);
    costs_.resize(frame_.cells());
    for (int row = 0; row < frame_.height; ++row) {
      for (int column = 0; column < frame_.width; ++column) {
        const std::size_t cell = frame_.index(column, row);
        costs_[cell] = obstacles[cell] != 0 ? 0.0F : cost_of(cell, column, row, through_unknown);
      }
    }
    work_.cells += 5 * frame_.cells();
  }

  // The groups of cells of frontiers that are large enough.
  std::vector<std::vector<std::size_t>> frontiers() {
    std::vector<std::uint8_t> of_frontier(frame_.cells(), 0);
    for (int row = 1; row + 1 < frame_.height; ++row) {
      for (int column = 1; column + 1 < frame_.width; ++column) {
        if (borders_on_unknown(column, row)) of_frontier[frame_.index(column, row)] = 1;
      }
    }
    std::vector<std::vector<std::size_t>> groups;
    for (std::size_t cell = 0; cell < of_frontier.size(); ++cell) {
      if (of_frontier[cell] == 0) continue;
      std::vector<std::size_t> group = collect(cell, of_frontier);
      if (static_cast<double>(group.size()) * kCell >= GlobalPlanner::kSmallestFrontier) {
        groups.push_back(std::move(group));
      }
    }
    work_.cells += 2 * frame_.cells();
    return groups;
  }

  // Finds the ways from the robot to all cells, or to those that come before `end`. `estimate` must not exceed the cost
  // of the way that is left.
  void run(const std::optional<std::size_t>& end, const std::function<float(int, int)>& estimate) {
    reached_.assign(frame_.cells(), kUnreached);
    before_.assign(frame_.cells(), 0);
    const int start_column = frame_.column(robot_.x);
    const int start_row = frame_.row(robot_.y);
    if (!frame_.inside(start_column, start_row)) return;
    start_ = frame_.index(start_column, start_row);
    // Expected cost of the whole way; of equal ones the lower cell comes first.
    using Entry = std::pair<float, std::uint32_t>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
    std::vector<std::uint8_t> closed(frame_.cells(), 0);
    reached_[start_] = 0.0F;
    open.emplace(0.0F, static_cast<std::uint32_t>(start_));
    while (!open.empty()) {
      const std::size_t cell = open.top().second;
      open.pop();
      if (closed[cell] != 0) continue;
      closed[cell] = 1;
      ++work_.expanded;
      if (end == cell) return;
      const int column = static_cast<int>(cell % static_cast<std::size_t>(frame_.width));
      const int row = static_cast<int>(cell / static_cast<std::size_t>(frame_.width));
      for (const Step& step : kSteps) {
        const int to_column = column + step.column;
        const int to_row = row + step.row;
        if (!frame_.inside(to_column, to_row)) continue;
        const std::size_t to = frame_.index(to_column, to_row);
        if (closed[to] != 0 || costs_[to] <= 0.0F) continue;
        if (step.length == kKnight && !passes(column, row, step)) continue;
        const float cost = reached_[cell] + step.length * costs_[to];
        if (cost >= reached_[to]) continue;
        reached_[to] = cost;
        before_[to] = static_cast<std::uint32_t>(cell);
        open.emplace(cost + estimate(to_column, to_row), static_cast<std::uint32_t>(to));
      }
    }
  }

  // Of a way that was found, in lengths of a cell in the open; kUnreached: there is none.
  static constexpr float kUnreached = std::numeric_limits<float>::max();
  float cost_to(std::size_t cell) const { return reached_[cell]; }

  // From the robot's cell on.
  std::vector<std::size_t> way_to(std::size_t end) const {
    std::vector<std::size_t> way{end};
    while (way.back() != start_) way.push_back(before_[way.back()]);
    std::reverse(way.begin(), way.end());
    return way;
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

  // Whether the two cells that a knight's move passes between are free.
  bool passes(int column, int row, const Step& step) const {
    const int half_column = step.column / 2;
    const int half_row = step.row / 2;
    return costs_[frame_.index(column + half_column, row + half_row)] > 0.0F &&
           costs_[frame_.index(column + step.column - half_column, row + step.row - half_row)] > 0.0F;
  }

  // The group of neighbours that `cell` belongs to; they are taken out of `of_frontier`.
  std::vector<std::size_t> collect(std::size_t cell, std::vector<std::uint8_t>& of_frontier) const {
    std::vector<std::size_t> group{cell};
    of_frontier[cell] = 0;
    for (std::size_t next = 0; next < group.size(); ++next) {
      const int column = static_cast<int>(group[next] % static_cast<std::size_t>(frame_.width));
      const int row = static_cast<int>(group[next] / static_cast<std::size_t>(frame_.width));
      for (std::size_t i = 0; i < kAround; ++i) {
        const Step& step = kSteps[i];
        if (!frame_.inside(column + step.column, row + step.row)) continue;
        const std::size_t neighbour = frame_.index(column + step.column, row + step.row);
        if (of_frontier[neighbour] == 0) continue;
        of_frontier[neighbour] = 0;
        group.push_back(neighbour);
      }
    }
    return group;
  }

  // The cost of a step into the cell, which is no obstacle, per length; 0: the step is not allowed.
  float cost_of(std::size_t cell, int column, int row, bool through_unknown) const {
    const auto clear = static_cast<double>(clearance_[cell]);
    const bool unknown = map_.cells[cell] == Cell::kUnknown;
    if (clear < GlobalPlanner::kClearance || (unknown && !through_unknown)) {
      // The robot may be nearer to an obstacle, and may not have seen the cells that it stands on.
      return distance(frame_.centre(column, row), robot_) <= kEscape ? kTightCost : 0.0F;
    }
    const double missing =
        (GlobalPlanner::kComfortable - clear) / (GlobalPlanner::kComfortable - GlobalPlanner::kClearance);
    return 1.0F + kNearCost * static_cast<float>(missing) + (unknown ? kUnknownCost : 0.0F);
  }

  const GlobalMap& map_;
  GridFrame frame_;
  Point robot_;
  std::vector<float> clearance_;
  std::vector<float> costs_;  // of a step into the cell, per length; 0: not allowed
  std::size_t start_ = 0;
  std::vector<float> reached_;
  std::vector<std::uint32_t> before_;
  Work work_;
};

struct End {
  std::size_t cell;
  double cost;  // metres in the open
};

// The cell of a frontier that is worth its way most, if one can be reached.
std::optional<End> best_of(const std::vector<std::vector<std::size_t>>& frontiers, const Search& search,
                           const Point& robot) {
  std::optional<End> best;
  for (const std::vector<std::size_t>& group : frontiers) {
    const double gain = kFrontierGain * std::min(kFrontierMax, static_cast<double>(group.size()) * kCell);
    for (const std::size_t cell : group) {
      if (search.cost_to(cell) == Search::kUnreached) continue;
      const double cost = static_cast<double>(search.cost_to(cell)) * kCell - gain;
      if ((best && cost >= best->cost) || distance(search.centre(cell), robot) < kFrontierDistance) continue;
      best = End{cell, cost};
    }
  }
  return best;
}

// One point for every so many cells, and one for the last cell.
std::vector<Point> thinned(const Search& search, const std::vector<std::size_t>& way) {
  const auto spacing = static_cast<std::size_t>(Path::kSpacing / (kCell * static_cast<double>(kKnight)));
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
  larger.anchor = map.anchor;
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

struct Planned {
  GlobalPlanner::Result result;
  double cost = 0.0;  // in metres in the open, less what a frontier is worth

  bool found() const { return result.path.outcome == Path::Outcome::kFound; }
};

Planned plan(const GlobalMap& map, const Point& robot, const Extra& extra, const std::optional<Point>& goal) {
  Planned planned;
  GlobalPlanner::Result& result = planned.result;
  result.path.stamp = map.stamp;
  result.path.anchor = map.anchor;
  result.path.to_goal = goal.has_value();
  Search search(map, robot, extra, goal.has_value());
  std::optional<End> end;
  if (goal) {
    const int column = map.frame.column(goal->x);
    const int row = map.frame.row(goal->y);
    const std::size_t cell = map.frame.index(column, row);
    search.run(cell, [column, row](int at_column, int at_row) {
      return std::hypot(static_cast<float>(at_column - column), static_cast<float>(at_row - row));
    });
    const float cost = search.cost_to(cell);
    if (cost != Search::kUnreached) end = End{cell, static_cast<double>(cost) * kCell};
  } else {
    search.run(std::nullopt, [](int, int) { return 0.0F; });
    end = best_of(search.frontiers(), search, robot);
  }
  if (end) {
    result.path.outcome = Path::Outcome::kFound;
    result.path.points = thinned(search, search.way_to(end->cell));
    planned.cost = end->cost;
  } else {
    result.path.outcome = goal ? Path::Outcome::kNoWay : Path::Outcome::kNothingLeft;
  }
  result.work = search.work();
  return planned;
}

// What the scan hits near the robot.
Extra shown_by(const CleanScan& scan, const Pose& robot) {
  Extra extra;
  for (const Point& point : scan.points) {
    if (std::hypot(point.x, point.y) <= GlobalPlanner::kScanReach) extra.push_back(transformed(robot, point));
  }
  return extra;
}

}  // namespace

GlobalPlanner::Result GlobalPlanner::run(const GlobalMap& map, const Pose& robot,
                                         const std::optional<Point>& goal) const {
  if (map.cells.empty()) return {};
  if (goal && !map.frame.inside(map.frame.column(goal->x), map.frame.row(goal->y))) {
    return run(extended(map, *goal), robot, goal);
  }
  return plan(map, position(robot), {}, goal).result;
}

// Whether it still waits, if it does so for so long at most.
bool GlobalPlanner::waits_for(double seconds, std::chrono::nanoseconds now) {
  if (!waits_since_) waits_since_ = now;
  return std::chrono::duration<double>(now - *waits_since_).count() < seconds;
}

GlobalPlanner::Result GlobalPlanner::run(const GlobalMap& map, const Localization& localization,
                                         const std::optional<Point>& goal) {
  if (map.cells.empty() || !localization.newest) return {};
  if (goal && !map.frame.inside(map.frame.column(goal->x), map.frame.row(goal->y))) {
    return run(extended(map, *goal), localization, goal);
  }
  const CleanScan& scan = *localization.newest;
  const Pose robot = localization.pose_on(map.anchor, scan.odometry);
  remove_free(scan, inverse(robot), blocked_);
  Extra extra = shown_by(scan, robot);
  extra.insert(extra.end(), blocked_.begin(), blocked_.end());
  Planned round = plan(map, position(robot), extra, goal);
  const auto taken = [this](Planned& planned) {
    expected_ = planned.found() ? std::optional(planned.cost) : std::nullopt;
    return std::move(planned.result);
  };
  if (round.found() && (!expected_ || round.cost <= *expected_ + kWorthWaiting)) {
    waits_since_.reset();
    expected_ = std::min(expected_.value_or(round.cost), round.cost);
    return std::move(round.result);
  }
  Planned through = plan(map, position(robot), {}, goal);
  through.result.work += round.result.work;
  round.result.work = through.result.work;
  if (!through.found()) return taken(round);
  if (!round.found()) {
    blocked_.clear();
    return taken(through);
  }
  const double more = round.cost - through.cost;
  if (more > kWorthWaiting) {
    if (waits_for(more / RobotLimits{}.speed, scan.stamp)) return taken(through);
    blocked_ = std::move(extra);
    // Walls stay with the map, which may still be corrected.
    std::erase_if(blocked_, [&](const Point& point) { return map.at(point) != Cell::kFree; });
  }
  waits_since_.reset();
  return taken(round);
}

}  // namespace ctn::navigation
