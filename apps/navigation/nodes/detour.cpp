#include "detour.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <optional>
#include <queue>
#include <utility>
#include <vector>

namespace ctn::navigation {
namespace {

constexpr int kCoarse = 2;             // cells of the map to a side of a cell of the wave front
constexpr double kEscapeRadius = 0.5;  // around the robot, where it may be nearer to obstacles than it should
constexpr double kEscapeCost = 6.0;    // of a metre there
constexpr double kOpen = 0.6;          // farther from obstacles than this, a metre costs nothing extra
constexpr double kBesideCost = 2.0;    // extra, of a metre that keeps the smallest distance
constexpr double kView = 0.8;          // the farthest that LP is sent along a way round
constexpr double kViewStep = 0.04;

class WaveFront {
 public:
  WaveFront(const LocalMap& map, Point robot, double distance_kept)
      : map_(map),
        robot_(robot),
        kept_(distance_kept),
        width_((map.frame.width + kCoarse - 1) / kCoarse),
        height_((map.frame.height + kCoarse - 1) / kCoarse) {}

  // The cells from the robot's to the goal's; none: there is no way.
  std::vector<Point> way_to(Point goal) {
    const std::optional<int> start = cell_at(robot_);
    const std::optional<int> end = cell_at(goal);
    if (!start || !end) return {};
    const auto size = static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_);
    std::vector<float> reached(size, std::numeric_limits<float>::max());
    std::vector<int> next(size, -1);
    using Entry = std::pair<float, int>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
    reached[static_cast<std::size_t>(*end)] = 0.0F;
    open.emplace(0.0F, *end);
    while (!open.empty()) {
      const float cost = open.top().first;
      const int cell = open.top().second;
      open.pop();
      if (cost > reached[static_cast<std::size_t>(cell)]) continue;
      ++expanded_;
      if (cell == *start) return follow(*start, next);
      spread(cell, cost, reached, [&](int to, float to_cost) {
        next[static_cast<std::size_t>(to)] = cell;
        open.emplace(to_cost, to);
      });
    }
    return {};
  }

  std::uint64_t expanded() const { return expanded_; }

 private:
  std::optional<int> cell_at(Point point) const {
    const int column = map_.frame.column(point.x);
    const int row = map_.frame.row(point.y);
    if (!map_.frame.inside(column, row)) return std::nullopt;
    return row / kCoarse * width_ + column / kCoarse;
  }

  Point centre(int cell) const {
    const double side = kCoarse * kCell;
    const int column = cell % width_;
    const int row = cell / width_;
    return {map_.frame.left * kCell + (column + 0.5) * side, map_.frame.bottom * kCell + (row + 0.5) * side};
  }

  // Of a metre in the cell; 0: it is not free.
  double cost_of(int cell) const {
    const Point at = centre(cell);
    const double clear = map_.static_clearance_at(at);
    if (clear < kept_) return clear >= kCoarse * kCell && distance(at, robot_) <= kEscapeRadius ? kEscapeCost : 0.0;
    return 1.0 + kBesideCost * std::max(0.0, kOpen - clear) / (kOpen - kept_);
  }

  template <typename Reach>
  void spread(int cell, float cost, std::vector<float>& reached, const Reach& reach) const {
    constexpr std::array<std::pair<int, int>, 8> kNeighbours{
        {{1, 0}, {0, 1}, {-1, 0}, {0, -1}, {1, 1}, {-1, 1}, {-1, -1}, {1, -1}}};
    for (const auto& [right, up] : kNeighbours) {
      const int column = cell % width_ + right;
      const int row = cell / width_ + up;
      if (column < 0 || row < 0 || column >= width_ || row >= height_) continue;
      const int to = row * width_ + column;
      const double factor = cost_of(to);
      if (factor <= 0.0) continue;
      const double length = (right != 0 && up != 0 ? std::numbers::sqrt2 : 1.0) * kCoarse * kCell;
      const float to_cost = cost + static_cast<float>(length * factor);
      if (to_cost >= reached[static_cast<std::size_t>(to)]) continue;
      reached[static_cast<std::size_t>(to)] = to_cost;
      reach(to, to_cost);
    }
  }

  std::vector<Point> follow(int start, const std::vector<int>& next) const {
    std::vector<Point> way;
    for (int cell = start; cell >= 0; cell = next[static_cast<std::size_t>(cell)]) way.push_back(centre(cell));
    return way;
  }

  const LocalMap& map_;
  Point robot_;
  double kept_;
  int width_;
  int height_;
  std::uint64_t expanded_ = 0;
};

// Whether the straight way keeps its distance. Its beginning may be nearer to an obstacle, if it leads away from there.
bool straight_is_free(const LocalMap& map, Point from, Point to, double kept, std::uint64_t& lookups) {
  const double length = distance(from, to);
  const int steps = std::max(1, static_cast<int>(std::ceil(length / kViewStep)));
  double before = map.static_clearance_at(from);
  for (int i = 1; i <= steps; ++i) {
    ++lookups;
    const double clear = map.static_clearance_at(from + (to - from) * (static_cast<double>(i) / steps));
    if (clear < kept && clear < before + 0.2 * length / steps) return false;
    before = clear;
  }
  return true;
}

}  // namespace

Detour find_detour(const LocalMap& map, Point robot, const Command& command, double margin) {
  const double kept = kInnerRadius + margin;
  Detour detour;
  detour.target = command.carrot;
  if (straight_is_free(map, robot, command.carrot, kept, detour.work.candidates)) return detour;

  Point goal = command.carrot;
  const auto free = [&](Point point) {
    ++detour.work.candidates;
    return map.static_clearance_at(point) >= kept;
  };
  if (!free(goal)) {
    const auto beyond = std::find_if(command.beyond.begin(), command.beyond.end(), free);
    if (beyond != command.beyond.end()) goal = *beyond;
  }
  WaveFront wave(map, robot, kept);
  const std::vector<Point> way = wave.way_to(goal);
  detour.work.expanded = wave.expanded();
  if (way.empty()) {
    detour.kind = Detour::Kind::kBlocked;
    return detour;
  }
  detour.kind = Detour::Kind::kRound;
  detour.target = way[std::min<std::size_t>(2, way.size() - 1)];
  for (std::size_t i = 2; i < way.size() && distance(way[i], robot) <= kView; ++i) {
    if (straight_is_free(map, robot, way[i], kept, detour.work.candidates)) detour.target = way[i];
  }
  return detour;
}

}  // namespace ctn::navigation
