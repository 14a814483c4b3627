#include "sim/clocks.h"

#include <algorithm>
#include <cmath>

#include "base/mixed.h"

namespace ctn::sim {
namespace {

// What is drawn of a node's clock.
enum class Draw : std::uint64_t { kPhase, kDrift };

std::uint64_t drawn(const ClockChance& chance, std::size_t node, Draw what) {
  return mixed_of(chance.seed, node, static_cast<std::uint64_t>(what));
}

Nanos drifting(Nanos period, const ClockChance& chance, std::size_t node) {
  if (chance.drift_ppm == 0.0) return period;
  const double part = 2.0 * fraction_of(drawn(chance, node, Draw::kDrift)) - 1.0;
  const double longer = static_cast<double>(period.count()) * part * chance.drift_ppm * 1e-6;
  return std::max(period + Nanos{std::llround(longer)}, Nanos{1});
}

TimePoint phase(Nanos period, const ClockChance& chance, std::size_t node) {
  const auto limit = static_cast<std::uint64_t>(period.count());
  return TimePoint{} + Nanos{static_cast<Nanos::rep>(drawn(chance, node, Draw::kPhase) % limit)};
}

}  // namespace

Clocks draw_clocks(const graph::Graph& graph, const ClockChance& chance) {
  Clocks clocks{std::vector<Ticks>(graph.nodes().size()), std::vector<Ticks>(graph.nodes().size())};
  for (std::size_t index = 0; index < graph.nodes().size(); ++index) {
    const graph::Node& node = graph.nodes()[index];
    if (node.is_external_clock()) {
      clocks.external[index] = {phase(*node.period, chance, index), drifting(*node.period, chance, index)};
    } else if (node.unscheduled && !node.follows) {
      const Nanos period = drifting(*node.period, chance, index);
      const TimePoint first = chance.drift_ppm > 0.0 ? phase(period, chance, index) : TimePoint{} + period;
      clocks.timers[index] = {first, period};
    }
  }
  return clocks;
}

}  // namespace ctn::sim
