// Whether a node's report is plausible. Nodes may belong to other processes, which may be faulty or hostile; what is
// accepted goes into estimates, plans and the record. A run is accepted if
//   - it follows the node's run before: a higher number, not begun before that one ended,
//   - it did not end before it began, nor in the future (the clock is one for all processes of a machine),
//   - it used no more CPU time than its threads could have, in a mode and on a number of threads that the node may
//     have, and waited no longer than it took,
//   - there are not more of them than kMaxRuns a second.
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
  static constexpr std::int64_t kMaxRuns = 20000;

  explicit ReportCheck(const graph::Graph& graph);

  // False: it is not plausible; such reports are counted. Runs of one node come in the order in which they were
  // reported. Ranges of consumed runs that make no sense are removed.
  bool accept(record::Run& run, TimePoint now);
  // Another program runs the node from now on, which does not know when the last run of the other ended.
  void restart(NodeId node);
  std::uint64_t rejected() const { return rejected_; }

 private:
  struct Known {
    std::uint64_t number = 0;
    TimePoint end{};
    std::int64_t credit = kMaxRuns;  // runs that may still come
    TimePoint credited{};
  };

  bool is_plausible(const record::Run& run, TimePoint now) const;
  bool has_credit(Known& known, TimePoint now) const;

  const graph::Graph& graph_;
  std::vector<Known> known_;  // by node
  std::uint64_t rejected_ = 0;
};

}  // namespace ctn::runtime
