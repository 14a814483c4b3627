#include "model/clock_estimator.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/statistics.h"

namespace ctn::model {
namespace {

// So far from where it should be, in periods, a tick may still be that one.
constexpr double kStray = 0.25;
// Beyond so many periods without a tick, it cannot be told how many there were.
constexpr std::int64_t kLongestGap = 1000;
// So many times the median distance from the line is far from it, but no less than this, in ns.
constexpr double kFar = 4.0;
constexpr double kMinFar = 1000.0;
// The line is drawn anew at each of so many ticks, then at every so-many-th.
constexpr std::size_t kFitEach = 64;
constexpr int kFitEvery = 8;

struct Point {
  double x = 0.0;
  double y = 0.0;
};
struct Slope {
  double height = 0.0;
  double slope = 0.0;
  double at(double x) const { return height + slope * x; }
};

Slope least_squares(const std::vector<Point>& points) {
  double x = 0.0;
  double y = 0.0;
  for (const Point& point : points) {
    x += point.x;
    y += point.y;
  }
  x /= static_cast<double>(points.size());
  y /= static_cast<double>(points.size());
  double xy = 0.0;
  double xx = 0.0;
  for (const Point& point : points) {
    xy += (point.x - x) * (point.y - y);
    xx += (point.x - x) * (point.x - x);
  }
  const double slope = xy / xx;
  return {y - slope * x, slope};
}

std::vector<double> distances(const std::vector<Point>& points, const Slope& line) {
  std::vector<double> distances;
  for (const Point& point : points) distances.push_back(point.y - line.at(point.x));
  return distances;
}

// Where it costs least to read, by how late ticks were told: TicksAre::kArrivals. Precondition: not empty.
double best_to_read(std::vector<double> late, double period) {
  std::sort(late.begin(), late.end());
  double best = late.back();
  double min_cost = late.back();
  for (std::size_t i = 0; i < late.size(); ++i) {
    const double missed = static_cast<double>(late.size() - 1 - i) / static_cast<double>(late.size());
    const double cost = late[i] + missed * period;
    if (cost >= min_cost) continue;
    best = late[i];
    min_cost = cost;
  }
  return best;
}

}  // namespace

void ClockEstimator::begin_anew(TimePoint tick) {
  told_ = {{0, tick}};
  line_.reset();
  since_fit_ = 0;
  astray_ = 0;
}

void ClockEstimator::add(TimePoint tick) {
  if (told_.empty()) return begin_anew(tick);
  const Tick& newest = told_.back();
  if (tick <= newest.at) return;
  // By the line, so that it does not count how late the newest was told.
  const Tick from = line_ ? line_->through : newest;
  const double since = static_cast<double>((tick - from.at).count()) / period();
  const Tick next{from.number + std::llround(since), tick};
  if (next.number - newest.number > kLongestGap) return begin_anew(tick);
  const bool far = line_ && std::abs(since - std::round(since)) > kStray;
  if (far || next.number <= newest.number) {
    if (++astray_ >= kAstray) begin_anew(tick);
    return;
  }
  astray_ = 0;
  told_.push_back(next);
  if (told_.size() > kWindow) told_.pop_front();
  ++since_fit_;
  if (told_.size() >= kMinTicks && (told_.size() < kFitEach || since_fit_ >= kFitEvery)) fit();
}

void ClockEstimator::fit() {
  since_fit_ = 0;
  const Tick& first = told_.front();
  std::vector<Point> points;
  for (const Tick& tick : told_) {
    points.push_back(
        {static_cast<double>(tick.number - first.number), static_cast<double>((tick.at - first.at).count())});
  }
  Slope line = least_squares(points);
  constexpr int kAgain = 2;
  for (int round = 0; round < kAgain; ++round) {
    std::vector<double> off = distances(points, line);
    const double middle = median_of(off);
    for (double& each : off) each = std::abs(each - middle);
    const double far = std::max(kFar * median_of(off), kMinFar);
    std::vector<Point> near;
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (off[i] <= far) near.push_back(points[i]);
    }
    line = least_squares(near);
  }
  std::vector<double> off = distances(points, line);
  const double middle = median_of(off);
  const double above = what_ == TicksAre::kArrivals ? best_to_read(off, line.slope) : middle;
  const double height = line.at(points.back().x) + above;
  for (double& each : off) each = std::abs(each - middle);
  regular_ = median_of(off) <= kIrregular * line.slope;
  line_ = Line{{told_.back().number, first.at + Nanos{std::llround(height)}}, line.slope};
}

std::optional<Ticks> ClockEstimator::ticks() const {
  const auto nominal = static_cast<double>(nominal_.count());
  if (!line_ || !regular_ || std::abs(line_->period - nominal) > kFarOff * nominal) return std::nullopt;
  return Ticks{line_->through.at, Nanos{std::llround(line_->period)}, line_->through.number};
}

}  // namespace ctn::model
