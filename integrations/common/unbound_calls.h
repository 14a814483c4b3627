// The calls of a bound callback that the framework makes, as without Catan: while no server schedules its node, or has
// let go of the node's subchain. Before the node's runs go on they have ended, so that calls of one callback do not
// overlap that did not before, and stay in order.
//
// Thread safety: all calls from any thread.
#pragma once

#include <atomic>

#include "common/priority_mutex.h"

namespace catan_ros {

class UnboundCalls {
 public:
  // One is made, or about to be. With the lock under which it was decided that this is not for the node's runs.
  void begin();
  void end();
  // For those that have begun, or until `stop` becomes true.
  void wait_for_ends(const std::atomic<bool>& stop);

  // end() at the end of a scope.
  class Ended {
   public:
    explicit Ended(UnboundCalls& calls) : calls_(calls) {}
    ~Ended() { calls_.end(); }
    Ended(const Ended&) = delete;
    Ended& operator=(const Ended&) = delete;

   private:
    UnboundCalls& calls_;
  };

 private:
  PriorityMutex mutex_;
  PriorityCondition changed_;
  int under_way_ = 0;
};

}  // namespace catan_ros
