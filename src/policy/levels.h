// What levels mean for threads: those that controllers give, and fixed priorities one above the other.
//
// Thread safety: pure functions, but for rise_above(), which changes what it is given.
#pragma once

#include <cstddef>

#include "base/result.h"
#include "dispatch/shared_core_member.h"
#include "os/level.h"
#include "policy/policy.h"

namespace ctn::policy {

os::Level to_os(dispatch::MemberLevel level);

// Puts nodes that run by themselves above all levels of the decision's assignment, and controllers above these: at the
// usual levels where it has no fixed priorities. Precondition: the highest rank is below kFixedLevels - 2; those from
// there on are not outranked.
void rise_above_assigned(Decision& decision);

// Puts nodes that run by themselves above `ranks` fixed priorities, and controllers above all. Errors (kCaller): more
// `what` than there are priorities.
Status rise_above(Decision& decision, std::size_t ranks, const char* what);

}  // namespace ctn::policy
