#include "runtime/unserved_pacer.h"

#include <algorithm>
#include <optional>

namespace ctn::runtime {
namespace {

// Where nothing says how often a subchain is to run.
constexpr Nanos kUnknownPeriod = std::chrono::milliseconds{100};
constexpr Nanos kLongestPeriod = std::chrono::seconds{100};
// A run that has not ended after so many periods, and a second, counts as ended.
constexpr int kLostPeriods = 10;
constexpr Nanos kLostAfter = std::chrono::seconds{1};

}  // namespace

void UnservedPacer::begin(TimePoint now, const std::vector<Head>& heads) {
  paced_.clear();
  for (const Head& head : heads) paced_.push_back({head, now, now});
}

TimePoint UnservedPacer::pace_heads(TimePoint now) {
  TimePoint next = kNever;
  for (Paced& paced : paced_) {
    const auto& [port, period] = paced.head;
    if (now >= paced.due) {
      if (port->trigger_locally()) {
        paced.ended = now;
      } else if (now - paced.ended > kLostPeriods * period && now - paced.ended > kLostAfter) {
        port->abandon_run();
        paced.ended = now;
      }
      paced.due = std::max(paced.due + period, now);
    }
    next = std::min(next, paced.due);
  }
  return next;
}

Nanos period_without_server(const graph::Graph& graph, SubchainId subchain, const Region& region) {
  const Nanos planned{region.signal(subchain).period.load(std::memory_order_relaxed)};
  if (planned > Nanos{0}) return std::clamp(planned, graph::kShortestPeriod, kLongestPeriod);
  const std::optional<Rate> fallback = graph.node(graph.subchain(subchain).nodes.front()).fallback_rate;
  return fallback ? to_nanos(fallback->period()) : kUnknownPeriod;
}

}  // namespace ctn::runtime
