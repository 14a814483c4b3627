// The phases that clocks of external nodes have to each other, where these are worth a trial of their own: they are
// known, and stay what they are for long (docs/decisions/0062-a-trial-of-the-phases-that-are-there.md).
//
// Clocks are by NodeId; one with a period of 0 is not known, or no clock. Units: in the types. Thread safety: none is
// needed.
#pragma once

#include <vector>

#include "base/ticks.h"
#include "base/time.h"
#include "graph/app.h"

namespace ctn::planner {

// What is there later than so long before a tick is taken to miss it: clocks are known to some microseconds, runs take
// now and then more than they did, and a controller that takes a new plan does so just before.
inline constexpr Nanos kBeforeTicks = std::chrono::microseconds{60};

// Whether any clock is known, and those that are known stay where they are to each other, and to ours, by a tenth of
// the shortest period, for ten seconds or more. What follows no clock goes by ours, and how the phases of others move
// is known if each ticks as often as the app file says.
bool keep_their_phases(const graph::Graph& graph, const std::vector<Ticks>& clocks);

// Whether a trial of the phases of `before` says what one of those of `now` would: no clock has slipped by a tenth of
// the shortest period. Precondition: both keep their phases, or are empty.
bool have_same_phases(const graph::Graph& graph, const std::vector<Ticks>& before, const std::vector<Ticks>& now);

// The newest tick of all, which is the longest since the beginning of time.
TimePoint newest_tick(const std::vector<Ticks>& clocks);

// As if all had ticked so much sooner.
std::vector<Ticks> earlier_by(Nanos time, std::vector<Ticks> clocks);

}  // namespace ctn::planner
