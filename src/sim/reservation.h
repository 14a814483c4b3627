// Reservations of CPU time, one a node, as Linux's SCHED_DEADLINE has them: a thread of the node may run for `runtime`
// in each `period`, before all threads at levels, the one whose period ends first before the others (cpus.h). Catan
// itself makes none, and only the simulated machine knows them.
//
// Units: Nanos. Thread safety: plain values.
#pragma once

#include <functional>
#include <vector>

#include "base/result.h"
#include "base/time.h"
#include "policy/policy.h"

namespace ctn::sim {

struct Reservation {
  Nanos runtime{0};  // of each period; 0: the node has none
  Nanos period{0};   // and deadline

  friend bool operator==(const Reservation&, const Reservation&) = default;
};

// By NodeId, for a policy that decided once, in the same situation; asked where it could decide.
using Reserve = std::function<Result<std::vector<Reservation>>(const policy::Situation&)>;

}  // namespace ctn::sim
