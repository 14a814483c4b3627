#include "planner/clock_phases.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <optional>

namespace ctn::planner {
namespace {

// How far two clocks may get from where they were to each other, as a part of the period of the faster one, before a
// trial says something else.
constexpr double kSlipped = 0.1;
// For so long at least, or it is not worth trying what is soon over.
constexpr Nanos kKept = std::chrono::seconds{10};

bool is_known(const Ticks& clock) { return clock.period > Nanos{0}; }

Nanos shortest_period(const std::vector<Ticks>& clocks) {
  Nanos shortest = Nanos::max();
  for (const Ticks& clock : clocks) {
    if (is_known(clock)) shortest = std::min(shortest, clock.period);
  }
  return shortest;
}

}  // namespace

bool keep_their_phases(const graph::Graph& graph, const std::vector<Ticks>& clocks) {
  const double may_slip = kSlipped * to_millis(shortest_period(clocks)) / to_millis(kKept);
  bool any = false;
  for (std::size_t index = 0; index < clocks.size(); ++index) {
    if (!is_known(clocks[index])) continue;
    any = true;
    const std::optional<Nanos> nominal = graph.nodes()[index].period;
    if (!nominal) return false;
    if (std::abs(to_millis(clocks[index].period) / to_millis(*nominal) - 1.0) > may_slip) return false;
  }
  return any;
}

bool have_same_phases(const graph::Graph& graph, const std::vector<Ticks>& before, const std::vector<Ticks>& now) {
  if (before.size() != now.size()) return false;
  const double may_slip = kSlipped * to_millis(shortest_period(now)).count();
  for (std::size_t index = 0; index < now.size(); ++index) {
    if (is_known(before[index]) != is_known(now[index])) return false;
    if (!is_known(now[index])) continue;
    const Ticks nominal{before[index].tick, *graph.nodes()[index].period};
    const Nanos after = now[index].tick - nominal.last(now[index].tick);
    const Nanos slipped = std::min(after, nominal.period - after);
    if (to_millis(slipped).count() > may_slip) return false;
  }
  return true;
}

TimePoint newest_tick(const std::vector<Ticks>& clocks) {
  TimePoint newest{};
  for (const Ticks& clock : clocks) newest = std::max(newest, clock.tick);
  return newest;
}

std::vector<Ticks> earlier_by(Nanos time, std::vector<Ticks> clocks) {
  for (Ticks& clock : clocks) clock.tick -= time;
  return clocks;
}

}  // namespace ctn::planner
