// Whether what a node reports can be true. Nodes may be of other processes, which may be wrong or worse; what is
// believed goes into estimates, plans and the record. A run is believed if
//   - it follows the node's run before: a higher number, not begun before that one ended,
//   - it did not end before it began, nor in the future (the clock is one for all processes of a machine),
//   - it used no more CPU time than its threads could have, in a mode that the node has,
//   - there are not more of them than kMostRuns a second.
//
// Units: in the types. Thread safety: one owner.
#pragma once

#include <cstdint>
#include <vector>

#include "base/time.h"
#include "graph/app.h"
#include "record/events.h"

namespace ctn::runtime {

class ReportCheck {
 public:
  static constexpr std::int64_t kMostRuns = 20000;

  explicit ReportCheck(const graph::Graph& graph);

  // False: it cannot be true, which is counted. Runs of one node in the order they were reported. What it says of runs
  // consumed is put right: ranges that make no sense are left out.
  bool believe(record::Run& run, TimePoint now);
  // The node is another program's from now on, which does not know when the last one's run ended.
  void begin_anew(NodeId node);
  std::uint64_t disbelieved() const { return disbelieved_; }

 private:
  struct Known {
    std::uint64_t number = 0;
    TimePoint end{};
    std::int64_t credit = kMostRuns;  // runs that may still come
    TimePoint credited{};
  };

  bool can_be(const record::Run& run, TimePoint now) const;
  bool has_credit(Known& known, TimePoint now) const;

  const graph::Graph& graph_;
  std::vector<Known> known_;  // by node
  std::uint64_t disbelieved_ = 0;
};

}  // namespace ctn::runtime
