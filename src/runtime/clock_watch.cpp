#include "runtime/clock_watch.h"

#include <fmt/format.h>

#include <algorithm>

namespace ctn::runtime {
namespace {

// A tick may be told before it comes, as by a program that knows when the next one is.
constexpr Nanos kMaxAhead = std::chrono::seconds{1};
// A clock is told of again no sooner, and only if it is off by more than this part of its period.
constexpr Nanos kSayAgainAfter = std::chrono::seconds{1};
constexpr Nanos::rep kOff = 1000;

}  // namespace

Status tell_tick(const graph::App& app, const Region& region, std::string_view node, TimePoint at) {
  const std::optional<NodeId> id = app.graph.find_node(node);
  if (!id || !app.graph.node(*id).is_external_clock()) {
    return Error::caller(fmt::format("app {} has no node '{}' with a clock", app.name, node),
                         "name an external node that has a period in the app file");
  }
  NodeCell& cell = region.node(*id);
  cell.give(cell.newest_output.load(std::memory_order_relaxed) + 1, at.time_since_epoch().count());
  return Done{};
}

ClockWatch::ClockWatch(const graph::Graph& graph, const Region& region) : region_(region) {
  for (std::size_t index = 0; index < graph.nodes().size(); ++index) {
    const graph::Node& node = graph.nodes()[index];
    if (!node.has_clock()) continue;
    const bool read = node.external && !node.successors.empty();
    const model::TicksAre what = read ? model::TicksAre::kArrivals : model::TicksAre::kDeadlines;
    clocks_.push_back(
        {.node = NodeId(index), .estimator = model::ClockEstimator(*node.period, what), .told = node.external});
  }
}

void ClockWatch::ran(const record::Run& run) {
  for (Clock& clock : clocks_) {
    if (clock.node == run.node && !clock.told) clock.estimator.add(run.begin);
  }
}

void ClockWatch::take_told(Clock& clock, TimePoint now) const {
  const NodeCell& cell = region_.node(clock.node);
  const std::uint64_t newest = cell.newest_output.load(std::memory_order_acquire);
  if (newest == clock.seen) return;
  const std::uint64_t kept = newest > NodeCell::kOutputs ? newest - NodeCell::kOutputs : 0;
  for (std::uint64_t number = newest > clock.seen ? std::max(clock.seen, kept) : newest; number < newest; ++number) {
    const std::int64_t at = cell.origin_of(number + 1);
    if (at != NodeCell::kUnknown && Nanos{at} <= now.time_since_epoch() + kMaxAhead) {
      clock.estimator.add(TimePoint{Nanos{at}});
    }
  }
  clock.seen = newest;
}

std::vector<record::ClockReading> ClockWatch::look(TimePoint now) {
  std::vector<record::ClockReading> readings;
  for (Clock& clock : clocks_) {
    if (clock.told) take_told(clock, now);
    const std::optional<Ticks> ticks = clock.estimator.ticks();
    if (!ticks || !is_news(clock, *ticks, now)) continue;
    clock.said = ticks;
    clock.said_at = now;
    readings.push_back({now, clock.node, *ticks});
  }
  return readings;
}

bool ClockWatch::is_news(const Clock& clock, const Ticks& ticks, TimePoint now) {
  if (!clock.said) return true;
  if (now - clock.said_at < kSayAgainAfter) return false;
  const TimePoint tick = ticks.last(now);
  const Nanos off = std::min(clock.said->next(tick) - tick, tick - clock.said->last(tick));
  return off > ticks.period / kOff;
}

}  // namespace ctn::runtime
