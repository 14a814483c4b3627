// Sets the level and CPUs of threads, remembers the scheduling that they had before, and restores it. For threads of
// other processes the guardian, if there is one, remembers it too, and restores it if this process cannot. Once the
// machine has refused a level, all threads are lowered and no level is asked for again: the session goes on with rates
// only, and says so. While a thread is as apply() has put it, PlacedThreads has it.
//
// Thread safety: all calls from any thread that is not a node's or a controller's (it locks), except
// set_level_now() and move_now(), which controllers may call, and keep_on(), which does not lock either.
#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <string>

#include "base/result.h"
#include "driver/notices.h"
#include "os/os.h"
#include "runtime/saved_threads.h"

namespace ctn::runtime {

class Enforcer {
 public:
  // `notices` hears of what was refused and how to get it, if ever a level is, and of the guardian. Both may be null.
  Enforcer(os::Os& os, bool real_time, std::unique_ptr<os::Guardian> guardian, driver::Notices* notices);
  ~Enforcer() { restore_for_good(); }
  Enforcer(const Enforcer&) = delete;
  Enforcer& operator=(const Enforcer&) = delete;

  bool real_time() const { return real_time_.load(std::memory_order_acquire); }

  // Until restore_for_good(): afterwards these do nothing.
  //
  // Puts a thread on `cpus` at `level`, or at kOrdinary where levels cannot be had: that is no error, see above. The
  // level of a thread of another process is set again where that process has changed it meanwhile.
  // Errors: a CPU that cannot be had; a thread of another process that the guardian cannot watch, which is left alone.
  // None where the thread has ended.
  Status apply(os::ThreadId thread, os::Level level, const os::CpuSet& cpus, os::ProcessId owner);
  // The same of a thread of this process.
  Status apply(os::ThreadId thread, os::Level level, const os::CpuSet& cpus) {
    return apply(thread, level, cpus, os_.current_process());
  }

  // The level alone, of a thread that apply() has placed; one that is refused is as above. Nothing where levels cannot
  // be had.
  void raise(os::ThreadId thread, os::Level level);

  // Finds out whether a thread that apply() has placed can have the level, which is refused for all if it cannot, and
  // leaves the thread at the ordinary one.
  void try_level(os::ThreadId thread, os::Level level, os::ProcessId owner);

  // For controllers, of threads that apply() has placed before: no lock, no bookkeeping, no answer. Levels are left
  // alone where they cannot be had.
  void set_level_now(os::ThreadId thread, os::Level level);
  void move_now(os::ThreadId thread, const os::CpuSet& cpus);
  // As move_now(), where the thread is on other CPUs by now: another program has moved it. True: it was.
  bool keep_on(os::ThreadId thread, const os::CpuSet& cpus);

  // A thread, if it still lives, gets back what it had before the first apply(), and is forgotten; or all of them.
  // No thread may set its level any more: restore_all() is for where controllers still might. It forgets nothing.
  void restore(os::ThreadId thread);
  void restore_for_good();
  void restore_all();

  // Makes sure that there is still a guardian: to be called about every second.
  void check_guardian();

 private:
  void tell(const std::string& kind, const std::string& detail);
  // So often a level is asked for before it is taken to be refused.
  int attempts_of(os::ProcessId owner) const;
  void raise_or_refuse(os::ThreadId thread, os::Level level, int attempts);
  void refuse(const std::string& why);

  os::Os& os_;
  std::atomic<bool> real_time_;
  driver::Notices* const notices_;
  mutable std::mutex mutex_;  // guards what follows
  SavedThreads saved_;
  bool ended_ = false;  // all are restored, for good
  std::unique_ptr<os::Guardian> guardian_;
  int guardians_replaced_ = 0;
  bool guardian_missing_ = false;
};

}  // namespace ctn::runtime
