// Periods by the method of Davare, Zhu, Di Natale, Pinello, Kanajan and Sangiovanni-Vincentelli, "Period optimization
// for hard real-time distributed automotive systems", DAC 2007.
//
// Tasks are triggered periodically, by nothing but their own timer, and pre-empt each other by fixed priorities. A
// chain takes at most the sum of (period + response time) over its tasks, and periods are sought that make the weighted
// sum of the chains least while bounds hold. Response times are approximated (period_program.h) with a part `a` for
// what a ceiling rounds up; after each solution the part is corrected by the error against the exact response times
// (response_times.h), until they agree. `a` = 1, which is where it begins, is on the safe side; only solutions whose
// exact response times are within the periods count, and what is returned are exact response times.
//
// What differs from the paper:
// - There, cores and priorities are given. Here they are found by local search: cores first by balanced load,
//   priorities first by the periods that a core of one's own class would give (shorter ones higher), then one move at a
//   time: to another core, past a neighbour in the order, two subchains that swap cores. The answer is a local optimum.
// - No messages and no buses: reading a predecessor's output takes no time.
// - A task is a subchain (rate_plan.h). `a` is one figure a task, not one a pair of tasks.
// - Periods are weighed too, where the objective does. A task that no term weighs runs at least every 100 times what
//   all tasks together cost.
// - The geometric program is solved in other variables, by a barrier method of our own.
// - A `max` or `min_rate` that cannot hold gives way by the smallest common factor, as in Catan's plans; by the
//   approximation, so by a little more than would be needed.
//
// Units: see rate_plan.h. Thread safety: pure functions.
#pragma once

#include "base/result.h"
#include "baselines/rate_plan.h"

namespace ctn::baselines {

// `request.effort` counts convex programs solved. Errors (kCaller): see check_request; no assignment found that keeps
// exact rates and caps.
Result<RatePlan> plan_by_davare(const graph::App& app, const model::CostTable& costs, const RateRequest& request);

}  // namespace ctn::baselines
