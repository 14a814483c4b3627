#include "path.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace ctn::face_tracking {
namespace {

constexpr double kLegMin = 1.0;  // seconds between two turns
constexpr double kLegMax = 3.0;
constexpr double kHorizon = 24.0 * 3600.0;  // turns are drawn this far ahead

}  // namespace

double wrapped(double angle) {
  constexpr double kTurn = 2.0 * std::numbers::pi;
  return angle - kTurn * std::floor((angle + std::numbers::pi) / kTurn);
}

double bearing_on_square(double sides) {
  const double side = std::round(sides);
  const double along = 2.0 * (sides - side);  // -1 .. 1 from corner to corner, the side's distance being 1
  return side * std::numbers::pi / 2.0 + std::atan(along);
}

Path::Path(double speed, std::uint64_t seed) : sides_per_second_(speed * 2.0 / std::numbers::pi) {
  std::mt19937_64 random(seed);
  // Not uniform_real_distribution: its results differ between standard libraries.
  const auto unit = [&] { return static_cast<double>(random() >> 11U) * 0x1.0p-53; };
  Leg leg{0.0, 4.0 * unit(), unit() < 0.5 ? -1.0 : 1.0};
  while (leg.begin < kHorizon) {
    legs_.push_back(leg);
    const double lasts = kLegMin + (kLegMax - kLegMin) * unit();
    leg = {leg.begin + lasts, leg.walked + leg.direction * lasts * sides_per_second_, -leg.direction};
  }
}

double Path::bearing(double time) const {
  auto after = std::ranges::upper_bound(legs_, time, {}, &Leg::begin);
  const Leg& leg = after == legs_.begin() ? *after : *std::prev(after);
  return bearing_on_square(leg.walked + leg.direction * (time - leg.begin) * sides_per_second_);
}

}  // namespace ctn::face_tracking
