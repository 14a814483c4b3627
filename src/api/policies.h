// What a scheduler's name means, of Catan's own policies (policy/policy.h) and of those that it is compared with
// (baselines/policies.h):
//
//   "catan", "auto", "default", "fifo", "rate:HZ"   Catan's own
//   "paper"                                 the paper's Catan; "catan" is the same where the app file says
//                                           `planner: paper`
//   "static:FILE"                           a plan that `catan plan --json` wrote, which is followed and never revised
//   "rates-of:FILE"                         the rates of such a plan, set by hand under ordinary scheduling
//   "picas", "davare", "verucchi"           of others, which decide once, by compute times: NAME:FILE takes them from a
//                                           cost file or a record, NAME from known costs, which only a simulation has
//   "deadline"                              the same, with reservations of CPU time, which only a simulation has
//
// Files that a name mentions are read here, so that policies are pure.
//
// Units: in the types. Thread safety: pure but for the files.
#pragma once

#include <memory>
#include <string_view>

#include "base/result.h"
#include "graph/app.h"
#include "policy/policy.h"
#include "sim/reservation.h"

namespace ctn::api {

// For `app`, on real CPUs. Errors: a name that is none, with all that would be right; a file that cannot be read or is
// not of the app; a policy that needs costs and is given none, or that can only be simulated. All kCaller.
Result<std::shared_ptr<const policy::Policy>> live_policy(std::string_view name, const graph::App& app);

struct SimulatedPolicy {
  std::shared_ptr<const policy::Policy> policy;
  sim::Reserve reserve{};  // for sim::Options, as the policy
};

// For simulations of `app`. Errors: names and files, as above.
Result<SimulatedPolicy> simulated_policy(std::string_view name, const graph::App& app);

}  // namespace ctn::api
