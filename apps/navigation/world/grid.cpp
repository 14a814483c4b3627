#include "grid.h"

#include <algorithm>
#include <cmath>

namespace ctn::navigation::world {
namespace {

constexpr double kClearanceMax = 1.0;

std::size_t count_of(double length, double resolution) {
  return std::max<std::size_t>(1, static_cast<std::size_t>(std::ceil(length / resolution - 1e-9)));
}

// The part of the segment that is in the box, if any.
bool crosses(const Segment& segment, Point low, Point high) {
  double from = 0.0;
  double to = 1.0;
  const Point along = segment.to - segment.from;
  const auto clip = [&](double begin, double step, double min, double max) {
    if (step == 0.0) return begin >= min && begin <= max;
    double one = (min - begin) / step;
    double other = (max - begin) / step;
    if (one > other) std::swap(one, other);
    from = std::max(from, one);
    to = std::min(to, other);
    return from <= to;
  };
  return clip(segment.from.x, along.x, low.x, high.x) && clip(segment.from.y, along.y, low.y, high.y);
}

}  // namespace

Grid::Grid(const WorldFile& world, double resolution)
    : resolution_(resolution),
      origin_(world.bounds.low),
      columns_(count_of(world.bounds.width(), resolution)),
      rows_(count_of(world.bounds.height(), resolution)),
      walls_(size()),
      clearances_(size(), static_cast<float>(kClearanceMax)) {
  for (const Segment& wall : world.walls) add(wall);
}

void Grid::add(const Segment& wall) {
  const auto index = [&](double value, double origin, std::size_t count) {
    const double at = std::floor((value - origin) / resolution_);
    return static_cast<std::size_t>(std::clamp(at, 0.0, static_cast<double>(count - 1)));
  };
  const Point far{kClearanceMax, kClearanceMax};
  const Point low = Point{std::min(wall.from.x, wall.to.x), std::min(wall.from.y, wall.to.y)} - far;
  const Point high = Point{std::max(wall.from.x, wall.to.x), std::max(wall.from.y, wall.to.y)} + far;
  const Point half{resolution_ / 2.0, resolution_ / 2.0};
  const std::size_t last_row = index(high.y, origin_.y, rows_);
  const std::size_t last_column = index(high.x, origin_.x, columns_);
  for (std::size_t row = index(low.y, origin_.y, rows_); row <= last_row; ++row) {
    for (std::size_t column = index(low.x, origin_.x, columns_); column <= last_column; ++column) {
      const std::size_t at = row * columns_ + column;
      const Point middle = centre(at);
      const auto away = static_cast<float>(distance(wall, middle));
      clearances_[at] = std::min(clearances_[at], away);
      if (away <= static_cast<float>(resolution_) && crosses(wall, middle - half, middle + half)) walls_[at] = 1;
    }
  }
}

std::optional<std::size_t> Grid::cell(Point point) const {
  const double column = std::floor((point.x - origin_.x) / resolution_);
  const double row = std::floor((point.y - origin_.y) / resolution_);
  if (!(column >= 0.0 && row >= 0.0 && column < static_cast<double>(columns_) && row < static_cast<double>(rows_))) {
    return std::nullopt;
  }
  return static_cast<std::size_t>(row) * columns_ + static_cast<std::size_t>(column);
}

Point Grid::centre(std::size_t cell) const {
  const std::size_t row = cell / columns_;
  const std::size_t column = cell % columns_;
  return origin_ + Point{static_cast<double>(column) + 0.5, static_cast<double>(row) + 0.5} * resolution_;
}

double Grid::clearance(Point point) const {
  const auto at = cell(point);
  return at ? static_cast<double>(clearances_[*at]) : 0.0;
}

std::vector<std::uint8_t> Grid::reachable(Point from, double radius) const {
  std::vector<std::uint8_t> reached(size());
  const auto open = [&](std::size_t cell) {
    return walls_[cell] == 0 && clearances_[cell] >= static_cast<float>(radius);
  };
  const auto first = cell(from);
  if (!first || !open(*first)) return reached;
  std::vector<std::size_t> next{*first};
  reached[*first] = 1;
  while (!next.empty()) {
    const std::size_t at = next.back();
    next.pop_back();
    const auto column = static_cast<std::ptrdiff_t>(at % columns_);
    const auto row = static_cast<std::ptrdiff_t>(at / columns_);
    for (std::ptrdiff_t up = -1; up <= 1; ++up) {
      for (std::ptrdiff_t right = -1; right <= 1; ++right) {
        if (radius <= 0.0 && up != 0 && right != 0) continue;
        if (row + up < 0 || row + up >= static_cast<std::ptrdiff_t>(rows_)) continue;
        if (column + right < 0 || column + right >= static_cast<std::ptrdiff_t>(columns_)) continue;
        const auto neighbour = static_cast<std::size_t>(row + up) * columns_ + static_cast<std::size_t>(column + right);
        if (reached[neighbour] != 0 || !open(neighbour)) continue;
        reached[neighbour] = 1;
        next.push_back(neighbour);
      }
    }
  }
  return reached;
}

bool Grid::path_exists(Point from, Point to, double radius) const {
  const auto end = cell(to);
  return end && reachable(from, radius)[*end] != 0;
}

Explored::Explored(const WorldFile& world, double resolution)
    : grid_(world, resolution),
      resolution_(resolution),
      free_(grid_.reachable(position(world.start), 0.0)),
      seen_(grid_.size()) {
  free_count_ = static_cast<std::size_t>(std::ranges::count(free_, std::uint8_t{1}));
}

void Explored::see(const Pose& from, double field, double range, const std::vector<float>& rays) {
  const double step = resolution_ / 2.0;
  for (std::size_t ray = 0; ray < rays.size(); ++ray) {
    const double share = rays.size() > 1 ? static_cast<double>(ray) / static_cast<double>(rays.size() - 1) - 0.5 : 0.0;
    const double angle = from.heading + share * field;
    const Point ahead{std::cos(angle), std::sin(angle)};
    const double length = std::min(range, static_cast<double>(rays[ray]));
    for (double along = 0.0; along < length; along += step) {
      const auto cell = grid_.cell(position(from) + ahead * along);
      if (!cell) break;
      if (free_[*cell] == 0 || seen_[*cell] != 0) continue;
      seen_[*cell] = 1;
      ++seen_count_;
    }
  }
}

double Explored::fraction() const {
  return free_count_ == 0 ? 0.0 : static_cast<double>(seen_count_) / static_cast<double>(free_count_);
}

}  // namespace ctn::navigation::world
