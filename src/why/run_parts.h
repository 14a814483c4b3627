// What had the core while a run had not: during the run, and before it began. Records say only when a run began and
// ended, on which CPU, how much CPU time it took and how long it waited, so this is inferred from what ran there
// meanwhile. The walk through a response time asks it (walk.h), and so does the timeline of a run's page
// (page/losses.h).
//
// During a run, of the time that neither computing nor waiting accounts for: where its subchain takes turns, first what
// others ran between its slots, then runs that began meanwhile, then runs that had begun before, each for as long as it
// computed; what is left the kernel took.
//
// Units: in the types. Thread safety: pure functions.
#pragma once

#include <optional>
#include <vector>

#include "why/history.h"
#include "why/parts.h"

namespace ctn::why {

// A time in which a run did not have its core.
struct Delay {
  Span time;
  PartKind kind = PartKind::kUnexplained;
  std::optional<NodeId> by{};  // the node whose run had it
};

// The parts of a run, in order of time, from its begin to its end. Of the time in which it did not run, only the length
// is known, and when it can have begun. The wait for a device is taken to lie in the middle of the run's computing, and
// what the kernel took at the end.
std::vector<Part> parts_of_run(const History& history, const RunRef& ref);

// What had the core of the run in a span in which it had not: before it began, or between its slots.
std::vector<Delay> delays_in(const History& history, const RunRef& ref, Span span);

}  // namespace ctn::why
