#include "world.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace ctn::face_tracking {

PanLog::PanLog(Pan first) { append(first); }

void PanLog::append(const Pan& pan) {
  const std::uint64_t index = size_.load(std::memory_order_relaxed);
  Entry& entry = entries_[index % kSize];
  entry.index.store(index, std::memory_order_relaxed);
  // Release here and acquire below: a reader that sees any of the new values then sees the new index too.
  entry.at.store(pan.at, std::memory_order_release);
  entry.pan.store(pan.pan, std::memory_order_release);
  entry.rate.store(pan.rate, std::memory_order_release);
  size_.store(index + 1, std::memory_order_release);
}

std::optional<Pan> PanLog::entry(std::uint64_t index) const {
  const Entry& entry = entries_[index % kSize];
  const Pan pan{entry.at.load(std::memory_order_acquire), entry.pan.load(std::memory_order_acquire),
                entry.rate.load(std::memory_order_acquire)};
  if (entry.index.load(std::memory_order_relaxed) != index) return std::nullopt;
  return pan;
}

Pan PanLog::latest() const {
  for (;;) {
    if (const auto pan = entry(size() - 1)) return *pan;
  }
}

World::World(Path path, double half_view)
    : path_(std::move(path)), half_view_(half_view), log_({0.0, path_.bearing(0.0), 0.0}), pan_(log_.latest()) {}

void World::turn(double time, double rate) {
  const Pan before = log_.latest();
  log_.append({time, before.angle(time), std::clamp(rate, -kTurnRateMax, kTurnRateMax)});
}

Sight World::sight(const Pan& pan, double time) const {
  const double bearing = path_.bearing(time);
  const double axis = pan.angle(time);
  return {bearing, axis, wrapped(bearing - axis)};
}

Sight World::sight(double time) const { return sight(log_.latest(), time); }

void World::advance(double time) {
  const std::uint64_t known = log_.size();
  for (double at = static_cast<double>(tick_) * kSamplePeriod; at <= time;
       at = static_cast<double>(++tick_) * kSamplePeriod) {
    while (command_ + 1 < known) {
      const auto next = log_.entry(command_ + 1);
      if (next && next->at > at) break;
      ++command_;
      if (next) pan_ = *next;
    }
    const double angle = std::abs(sight(pan_, at).angle);
    angle_sum_ += angle;
    lost_ += angle > half_view_ ? 1U : 0U;
    ++samples_;
  }
}

void World::begin_measuring(double time) {
  advance(time);
  samples_ = lost_ = 0;
  angle_sum_ = 0.0;
}

Tracking World::tracking() const {
  if (samples_ == 0) return {};
  const auto count = static_cast<double>(samples_);
  return {samples_, angle_sum_ / count, static_cast<double>(lost_) / count};
}

}  // namespace ctn::face_tracking
