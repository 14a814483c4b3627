// What is made of a relaxation by rounding: on each shared core the frame is chosen, every n = p / T is rounded to the
// nearest whole number that is allowed, and the frame made as short as its slices and rates leave it. Queue nodes keep
// their n. Exact rates are not dealt with.
//
// A relaxation leaves the frame open within limits: all n may be scaled together. With the longest frame the most
// frequent subchain has n = 1; with the shortest the numbers are large and rounding costs little, but slices are as
// short as they may be.
//
// Units: milliseconds. Thread safety: pure functions.
#pragma once

#include <vector>

#include "planner/instance.h"
#include "planner/shares.h"

namespace ctn::solvers {

enum class Frame { kLongest, kShortest };

std::vector<planner::Timing> rounded(const planner::Instance& instance, const planner::Allocation& allocation,
                                     const std::vector<planner::Timing>& relaxed, Frame frame);

// Every core shared, the subchains dealt to them by turns.
planner::Allocation dealt(const planner::Instance& instance);

}  // namespace ctn::solvers
