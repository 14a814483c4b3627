// What is usual of each part over all responses of a chain, and from that the one cause of each late response: parts
// are summed up by kind and node, and the sum that exceeds its median by most is the cause. If the usual response is
// late already, the longest sum is.
//
// Some parts are counted together, or followed further:
//   plan-change       the wait that follows the change is an ordinary wait for a trigger: so all waits for triggers of
//                     the subchain count as plan-change
//   stolen,           waits for slots that follow from them count as these, unless they are ten times as long or more
//   running-longer
//   own-previous-run  if that run was longer than usual by at least half of what is exceeded, the cause is long-run
//
// Units: in the types. Thread safety: none; one owner.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "graph/app.h"
#include "why/analysis.h"
#include "why/durations.h"
#include "why/history.h"
#include "why/parts.h"

namespace ctn::why {

class Causes {
 public:
  using Key = std::pair<PartKind, NodeId>;  // as whose() has it

  // All parts of a response with one key.
  struct Sum {
    Key key;
    Nanos length{0};
    std::optional<NodeId> held_up{};  // of pre-empted and stolen: the node that lost most at a stretch
    std::optional<NodeId> robbed{};   // of stolen: the node that lost first
  };
  // A run that ended while `waiting` waited for its own previous run, and computed longer than usual.
  struct Excess {
    NodeId waiting;
    NodeId node;
    Nanos length{0};
  };
  // What the cause of a response depends on.
  struct Evidence {
    NodeId first;                  // of the first part
    std::vector<Sum> sums;         // by key
    std::vector<Excess> excesses;  // in order of time; of each node that waited, those that no later one exceeds
  };
  static Evidence evidence_of(std::span<const Part> parts);
  // Adds the excesses; needed only to find the cause.
  static void find_excesses(std::span<const Part> parts, const History& history, Evidence& evidence);

  // Adds the next response.
  void add(const Evidence& response);
  // To be called once, after all were added. Medians that are not 0.
  std::vector<std::pair<Key, Nanos>> medians();
  // To be called after medians().
  Cause cause_of(const Evidence& response, const graph::Graph& graph, bool usually_late) const;

 private:
  std::size_t responses_ = 0;
  std::map<Key, Durations> lengths_;  // of responses that have such a part
  std::map<Key, Nanos> medians_;
};

}  // namespace ctn::why
