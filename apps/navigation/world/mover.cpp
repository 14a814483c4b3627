#include "mover.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <iterator>
#include <utility>

namespace ctn::navigation::world {

Mover::Mover(MoverSpec spec, double drawn) : spec_(std::move(spec)) {
  assert(spec_.path.size() >= 2 && spec_.speed > 0.0);
  std::vector<Point> stops = spec_.path;
  if (spec_.closed) {
    stops.push_back(stops.front());
  } else {
    stops.insert(stops.end(), std::next(spec_.path.rbegin()), spec_.path.rend());
  }
  for (std::size_t i = 0; i + 1 < stops.size(); ++i) {
    if (spec_.pause > 0.0) {
      legs_.push_back({cycle_, cycle_ + spec_.pause, stops[i], stops[i]});
      cycle_ += spec_.pause;
    }
    const double lasts = distance(stops[i], stops[i + 1]) / spec_.speed;
    if (lasts <= 0.0) continue;
    legs_.push_back({cycle_, cycle_ + lasts, stops[i], stops[i + 1]});
    cycle_ += lasts;
  }
  assert(cycle_ > 0.0);
  phase_ = spec_.phase ? *spec_.phase : drawn * cycle_;
}

Point Mover::at(double seconds) const {
  double time = std::fmod(seconds + phase_, cycle_);
  if (time < 0.0) time += cycle_;
  const auto after = std::ranges::upper_bound(legs_, time, {}, &Leg::begin);
  const Leg& leg = after == legs_.begin() ? *after : *std::prev(after);
  return leg.from + (leg.to - leg.from) * std::min(1.0, (time - leg.begin) / (leg.end - leg.begin));
}

}  // namespace ctn::navigation::world
