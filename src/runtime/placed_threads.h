// Threads that some session or server of this process has placed on CPUs of its choice (enforcer.h), so that where they
// may run says nothing of what the user wants. One process may have several sessions, which know nothing else of one
// another; hence this is the process's.
//
// Thread safety: every call from any thread (it locks). Cost: that of a look-up, however many there are.
#pragma once

#include <mutex>
#include <unordered_map>

#include "os/os.h"

namespace ctn::runtime {

class PlacedThreads {
 public:
  static PlacedThreads& of_process();

  // Each by its enforcer, once until it is removed.
  void add(os::ThreadId thread);
  void remove(os::ThreadId thread);
  bool has(os::ThreadId thread) const;

 private:
  mutable std::mutex mutex_;
  std::unordered_map<os::ThreadId, int> enforcers_;  // by thread: how many have placed it
};

}  // namespace ctn::runtime
