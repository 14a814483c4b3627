// What a bound callback throws. It is called in its node's thread, where nobody of the program could catch it: the port
// hands it on to where it would come out without Catan, as of the program's spinner. What becomes of it there the
// framework decides, or who calls the spinner.
//
// Thread safety: as the call's, and what hands on.
#pragma once

#include <utility>

#include "common/bound_callback.h"

namespace catan_ros {

// Makes the call. Where it throws in a node's run, `hand_on` is called by the handler of that exception, so that
// std::current_exception() is it, and the result is `if_thrown`. In any other thread it throws as it does.
template <class Call, class Result, class HandOn>
Result call_handing_on(Call&& call, Result if_thrown, HandOn&& hand_on) {
  try {
    return std::forward<Call>(call)();
  } catch (...) {
    if (BoundCallback::current() == nullptr) throw;
    std::forward<HandOn>(hand_on)();
    return if_thrown;
  }
}

}  // namespace catan_ros
