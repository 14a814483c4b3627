// From the solver's numbers to a plan: cores numbered, frames laid out, predictions filled in.
//
// Units: milliseconds in, see plan.h out. Thread safety: pure functions.
#pragma once

#include "graph/app.h"
#include "model/cost.h"
#include "plan/plan.h"
#include "planner/allocation.h"

namespace ctn::planner {

// Save for `Plan::planner`, quality and gap. `cores`: all that there are, those of no use too. Cores are numbered in
// the order of the subchains that have them.
plan::Plan assemble(const graph::App& app, const model::CostTable& costs, const Instance& instance,
                    const Planned& planned, int cores, double slack);

// The allocation of a plan; false where it is not one of this app and this many cores.
bool allocation_of(const plan::Plan& plan, const Instance& instance, Allocation& allocation);

}  // namespace ctn::planner
