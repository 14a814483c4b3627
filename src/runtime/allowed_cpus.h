// Which CPUs an app may use at present: the ones that are online, and that have not been taken from its programs since.
//
// CPUs are taken from a program by its cpuset, or by a user who changes the affinity of its threads (`taskset`). Both
// show in the affinity of threads that Catan does not place itself, so some of these are watched: the main thread of
// the session's process, which is all that `taskset -p` changes, the housekeeping thread, and of each program that a
// server schedules the thread that serves the connection. A CPU that one of them could use when it was first watched
// and may not use any more is taken, until it may again. So a main thread that was pinned to a CPU before the session
// began does not bind the session.
//
// A node's threads must all be able to go wherever the plan wants them, so that a CPU counts only if every program may
// use it.
//
// Thread safety: every call from any thread that is not a node's or a controller's (it locks).
#pragma once

#include <map>
#include <mutex>
#include <optional>

#include "base/result.h"
#include "os/os.h"

namespace ctn::runtime {

class AllowedCpus {
 public:
  // `os` outlives it.
  explicit AllowedCpus(os::Os& os) : os_(os) {}

  // From now on. A thread that a session of this process has placed, now or later, tells nothing as long as it is.
  void watch(os::ThreadId thread);
  // What was taken from it counts no more.
  void forget(os::ThreadId thread);
  // Errors: it is not known which are online.
  Result<os::CpuSet> now() const;

 private:
  std::optional<os::CpuSet> of_its_own(os::ThreadId thread) const;

  os::Os& os_;
  mutable std::mutex mutex_;  // guards what follows
  // What each could use when it was first watched, or at the first look after that at which nobody had placed it.
  mutable std::map<os::ThreadId, std::optional<os::CpuSet>> before_;
};

}  // namespace ctn::runtime
