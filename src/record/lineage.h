// From runs to the latency, period and response time of a chain; the same code live, simulated and afterwards.
//
// It follows, run by run, which source run each run of the chain's nodes descends from (through `Run::consumed`). For a
// source run i(k) that reached the chain's end, its output is the first run of the last node that descends from it, and
//   latency(k)       = end of that output - begin of i(k)
//   response time(k) = end of that output - begin of i(k-1), i(k-1) being the source run before it that reached the end
//   period(k)        = end of that output - end of i(k-1)'s output
// Source runs that were dropped on the way count for nothing. (Design section 1; paper section 3.3.) A run of a queue
// node descends from every run in its batch; its newest is passed on with it.
//
// Units: Nanos. Thread safety: none; one owner. Memory: bounded; a run that is consumed more than `kHorizon` runs later
// counts as dropped.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "base/time.h"
#include "graph/app.h"
#include "record/events.h"

namespace ctn::record {

struct ChainSample {
  std::uint64_t source_run = 0;
  TimePoint begin{};  // of the source run
  TimePoint end{};    // of its output
  Nanos latency{0};
  std::optional<Nanos> period;    // none for the first
  std::optional<Nanos> response;  // none for the first
};

class ChainTracker {
 public:
  static constexpr std::size_t kHorizon = 4096;

  // `path` as in the objective; external nodes in it are passed over.
  ChainTracker(const graph::Graph& graph, std::span<const NodeId> path);

  // Takes the next run; runs of one node in the order of their numbers, and a run after those it consumed. Returns the
  // samples that it completes, oldest first: none or one, more only where a queue node batched.
  std::vector<ChainSample> add(const Run& run);

 private:
  struct Origin {  // the source runs that a run descends from, newest last
    std::uint64_t number = 0;
    std::uint64_t first = 0;
    std::uint64_t last = 0;
  };
  // (private members are the implementation's to choose)
};

}  // namespace ctn::record
