#include "scan_filter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace ctn::navigation {
namespace {

constexpr std::size_t kHalfWindow = 2;

float usable(float range, double max_range) {
  const auto at = static_cast<double>(range);
  const bool hit = at >= ScanFilter::kMinRange && at < max_range;  // false for NaN, too
  return hit ? range : std::numeric_limits<float>::infinity();
}

float median_around(const std::vector<float>& ranges, std::size_t beam) {
  const std::size_t half = std::min({kHalfWindow, beam, ranges.size() - 1 - beam});
  std::array<float, 2 * kHalfWindow + 1> window{};
  const std::size_t count = 2 * half + 1;
  for (std::size_t i = 0; i < count; ++i) window[i] = ranges[beam - half + i];
  const auto middle = window.begin() + static_cast<std::ptrdiff_t>(half);
  std::nth_element(window.begin(), middle, window.begin() + static_cast<std::ptrdiff_t>(count));
  return *middle;
}

}  // namespace

ScanFilter::Result ScanFilter::run(const Scan& raw, const Odometry& odometry) const {
  std::vector<float> bounded(raw.ranges.size());
  std::transform(raw.ranges.begin(), raw.ranges.end(), bounded.begin(),
                 [&raw](float range) { return usable(range, raw.max_range); });

  auto scan = std::make_shared<CleanScan>();
  static_cast<Scan&>(*scan) = raw;
  scan->odometry = odometry;
  for (std::size_t beam = 0; beam < bounded.size(); ++beam) {
    scan->ranges[beam] = median_around(bounded, beam);
    const auto range = static_cast<double>(scan->ranges[beam]);
    if (!std::isfinite(range)) continue;
    const double angle = scan->angle(beam);
    const Point point{range * std::cos(angle), range * std::sin(angle)};
    if (scan->points.empty() || distance(scan->points.back(), point) >= kSpacing) scan->points.push_back(point);
  }
  return {std::move(scan), {.beams = bounded.size()}};
}

}  // namespace ctn::navigation
