// Clocks of others, in life. Of an external node: a program tells when it has ticked (tell_tick()), through the node's
// cell in the region. Of an unscheduled node: its runs begin by a timer of its own. The housekeeping thread makes of
// them what measurements, records and phases go by.
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

  // A run of any node.
  void ran(const record::Run& run);

  // Looks at what was told since the last call; the clocks of which something else is known now.
  std::vector<record::ClockReading> look(TimePoint now);

 private:
  struct Clock {
    NodeId node;
    model::ClockEstimator estimator;
    bool told = false;       // of an external node, by others
    std::uint64_t seen = 0;  // ticks that were told
    std::optional<Ticks> said{};
    TimePoint said_at{};
  };

  void take_told(Clock& clock, TimePoint now) const;
  static bool is_news(const Clock& clock, const Ticks& ticks, TimePoint now);

  const Region& region_;
  std::vector<Clock> clocks_;
};

}  // namespace ctn::runtime
