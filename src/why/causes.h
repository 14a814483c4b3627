// What is usual of each part, over all responses of a chain, and so the one cause of each that was late: of all parts,
// summed up by kind and by whose they are, the one that exceeds its median by most. Where the usual response is late
// already, the longest.
//
// Some are looked at together, or further:
//   plan-change       what came after the change of a wait for a trigger is no longer called one: so all that is waited
//                     for triggers counts for it
//   stolen,           the waits for slots that come of it count for it, where they are not ten times as long or more
//   running-longer
//   own-previous-run  where that run was longer than usual by half of what is exceeded, the cause is its length
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

  // The parts of the next response.
  void add(std::span<const Part> parts);
  // After all were added. Those that are not 0.
  std::vector<std::pair<Key, Nanos>> medians();
  // After medians().
  Cause cause_of(std::span<const Part> parts, const History& history, bool usually_late) const;

 private:
  static std::map<Key, Nanos> sums(std::span<const Part> parts);

  std::size_t responses_ = 0;
  std::map<Key, std::vector<Nanos>> lengths_;  // of responses that have such a part
  std::map<Key, Nanos> medians_;
};

}  // namespace ctn::why
