// Reservations of CPU time, one a thread, as a user of Linux's SCHED_DEADLINE would make them. Rates are given (set by
// hand); a node's reservation is its cost with a margin, in every period of its subchain, by the end of the period.
//
// The server that such a thread runs in is that of Abeni and Buttazzo, "Integrating multimedia applications in hard
// real-time systems", RTSS 1998 (constant bandwidth, earliest deadline first); sim/reservation_server.h is its
// rule. As the kernel does, all threads together may reserve at most 95 % of the cores, wherever they run
// (sched_rt_runtime_us over sched_rt_period_us), and are refused beyond that.
//
// What differs from what a user would do: where the kernel would refuse, all rates are lowered by the least factor at
// which it would not. Nodes with a rate that is exact are slowed down, too. Parallel nodes have one thread.
//
// Units: in the types. Thread safety: plain values, pure functions.
#pragma once

#include <span>
#include <vector>

#include "base/time.h"
#include "graph/app.h"
#include "model/cost.h"
#include "sim/reservation.h"

namespace ctn::baselines {

struct ReservationRules {
  double margin = 1.1;                            // on each cost
  double max_bandwidth = 0.95;                    // of all cores together
  Nanos shortest = std::chrono::microseconds{2};  // the kernel refuses runtimes of about a microsecond
};

struct Reservations {
  std::vector<sim::Reservation> nodes;  // by NodeId
  std::vector<Nanos> periods;           // by SubchainId, as lowered
  bool admitted = true;                 // as asked; false: rates were lowered
  double asked = 0.0;                   // bandwidth, in cores
  double factor = 1.0;                  // by which all periods are longer than asked

  friend bool operator==(const Reservations&, const Reservations&) = default;
};

// Preconditions: `rates` by SubchainId; cores >= 1, and no more than the app lists. Where cores differ, a node is taken
// to be on the slowest for it: a reserved thread may run anywhere.
Reservations reserve(const graph::App& app, const model::CostTable& costs, std::span<const Rate> rates, int cores,
                     const ReservationRules& rules = {});

}  // namespace ctn::baselines
