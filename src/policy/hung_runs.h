// Which runs count as samples of what a node costs. A run that hung does not: it shows that something went wrong, and
// three of them in fifty would be the node's 95th percentile and lower all rates. But if the run before it hung, too,
// then the node has become that slow, and the planner must know.
//
// Units: in the types. Thread safety: none; one owner.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "graph/app.h"
#include "record/events.h"

namespace ctn::policy {

class HungRuns {
 public:
  explicit HungRuns(const graph::Graph& graph)
      : graph_(graph), began_(graph.subchains().size(), kNone), before_hung_(graph.nodes().size(), false) {}

  // A run of the subchain was taken to hang at that time.
  void began(SubchainId subchain, TimePoint at) { began_[subchain.index()] = at; }

  // Whether the run counts; asked once for each run, in the order of the node's runs.
  bool counts(const record::Run& run) {
    const std::optional<SubchainId> subchain = graph_.node(run.node).subchain;
    if (!subchain) return true;
    const TimePoint at = began_[subchain->index()];
    const bool hung = at != kNone && run.begin <= at && at <= run.end;
    const bool counts = !hung || before_hung_[run.node.index()];
    before_hung_[run.node.index()] = hung;
    return counts;
  }

 private:
  static constexpr TimePoint kNone = TimePoint::min();

  const graph::Graph& graph_;
  std::vector<TimePoint> began_;   // by SubchainId: the newest
  std::vector<bool> before_hung_;  // by NodeId
};

// What the record says of a hang that began, or has ended.
inline record::Notice notice_of_hang(const std::string& subchain, bool began, TimePoint at) {
  return {at, "watchdog",
          began ? "a run of subchain " + subchain + " hangs: it was suspended"
                : "the run of subchain " + subchain + " that hung has ended: it is scheduled as before"};
}

}  // namespace ctn::policy
