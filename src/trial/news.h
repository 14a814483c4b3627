// Whether something new has come to a node since its last run began: an output of a predecessor, or a tick of an
// external node that feeds it. Runs that lack news wait for it, or are idle (machine.h).
//
// Units: in the types. Thread safety: none; one owner.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "base/ids.h"
#include "base/ticks.h"
#include "base/time.h"

namespace ctn::trial {

class News {
 public:
  // An external node that ticks feeds the node.
  void add_clock(NodeId clock) { clocks_.push_back(clock); }

  // A predecessor has emitted.
  void came() { came_ = true; }
  // A run begins. What has come by now is no news to the next.
  void begin_run(TimePoint now) {
    came_ = false;
    last_begin_ = now;
  }

  // `ticks`: by NodeId.
  bool any(TimePoint now, std::span<const Ticks> ticks) const {
    return came_ || std::any_of(clocks_.begin(), clocks_.end(),
                                [&](NodeId clock) { return ticks[clock.index()].last(now) > last_begin_; });
  }
  // Of what feeds the node, after `now`; kNever: nothing that feeds it ticks.
  TimePoint next_tick(TimePoint now, std::span<const Ticks> ticks) const {
    TimePoint next = kNever;
    for (const NodeId clock : clocks_) next = std::min(next, ticks[clock.index()].next(now + Nanos{1}));
    return next;
  }

 private:
  std::vector<NodeId> clocks_;
  bool came_ = false;  // an output
  TimePoint last_begin_ = TimePoint::min();
};

}  // namespace ctn::trial
