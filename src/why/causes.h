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

#include "why/analysis.h"
#include "why/history.h"
#include "why/parts.h"

namespace ctn::why {

class Causes {
 public:
  using Key = std::pair<PartKind, NodeId>;  // as whose() has it

  // Adds the parts of the next response.
  void add(std::span<const Part> parts);
  // To be called after all were added. Medians that are not 0.
  std::vector<std::pair<Key, Nanos>> medians();
  // To be called after medians().
  Cause cause_of(std::span<const Part> parts, const History& history, bool usually_late) const;

 private:
  static std::map<Key, Nanos> sums(std::span<const Part> parts);
  Nanos beyond_usual(const Key& key, const std::map<Key, Nanos>& lengths, bool usually_late) const;
  static void look_closer(std::span<const Part> parts, const History& history, const Key& max, Cause& cause);

  std::size_t responses_ = 0;
  std::map<Key, std::vector<Nanos>> lengths_;  // of responses that have such a part
  std::map<Key, Nanos> medians_;
};

}  // namespace ctn::why
