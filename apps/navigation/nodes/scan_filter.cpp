#include "scan_filter.h"

#include <algorithm>
#include <array>

namespace ctn::navigation {
namespace {

constexpr std::size_t kHalfWindow = 2;

double usable(double range) {
  const bool hit = range >= ScanFilter::kMinRange && range < Scan::kMaxRange;  // false for NaN, too
  return hit ? range : Scan::kMaxRange;
}

double median_around(const std::array<double, Scan::kBeams>& ranges, std::size_t beam) {
  const std::size_t half = std::min({kHalfWindow, beam, Scan::kBeams - 1 - beam});
  std::array<double, 2 * kHalfWindow + 1> window{};
  const std::size_t count = 2 * half + 1;
  for (std::size_t i = 0; i < count; ++i) window[i] = ranges[beam - half + i];
  const auto middle = window.begin() + static_cast<std::ptrdiff_t>(half);
  std::nth_element(window.begin(), middle, window.begin() + static_cast<std::ptrdiff_t>(count));
  return *middle;
}

}  // namespace

ScanFilter::Result ScanFilter::run(const Scan& raw, const Odometry& odometry) const {
  std::array<double, Scan::kBeams> bounded{};
  std::transform(raw.ranges.begin(), raw.ranges.end(), bounded.begin(), usable);

  auto scan = std::make_shared<CleanScan>();
  scan->stamp = raw.stamp;
  scan->odometry = odometry;
  scan->ranges.resize(Scan::kBeams);
  for (std::size_t beam = 0; beam < Scan::kBeams; ++beam) {
    const double range = median_around(bounded, beam);
    scan->ranges[beam] = range;
    if (range >= Scan::kMaxRange) continue;
    const double angle = beam_angle(beam);
    const Point point{range * std::cos(angle), range * std::sin(angle)};
    if (scan->points.empty() || distance(scan->points.back(), point) >= kSpacing) scan->points.push_back(point);
  }
  return {std::move(scan), {.beams = Scan::kBeams}};
}

}  // namespace ctn::navigation
