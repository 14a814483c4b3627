// The clocks of external nodes, in life: a program tells when one has ticked (tell_tick()), through the node's cell in
// the region, and the housekeeping thread makes of it what measurements and records go by.
//
// What is told is not trusted: any process may write anything there.
//
// Units: in the types. Thread safety: tell_tick() of one node from one thread at a time; a ClockWatch has one owner,
// the housekeeping thread.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "graph/app.h"
#include "model/clock_estimator.h"
#include "record/events.h"
#include "runtime/region.h"

namespace ctn::runtime {

// Errors (kCaller): no such node, or it has no clock.
Status tell_tick(const graph::App& app, const Region& region, std::string_view node, TimePoint at);

class ClockWatch {
 public:
  // `region` outlives it.
  ClockWatch(const graph::Graph& graph, const Region& region);

  // Looks at what was told since the last call; the clocks of which something else is known now.
  std::vector<record::ClockReading> look(TimePoint now);

 private:
  struct Clock {
    NodeId node;
    model::ClockEstimator estimator;
    std::uint64_t seen = 0;  // ticks
    std::optional<Ticks> told{};
    TimePoint told_at{};
  };

  static bool is_news(const Clock& clock, const Ticks& ticks, TimePoint now);

  const Region& region_;
  std::vector<Clock> clocks_;
};

}  // namespace ctn::runtime
