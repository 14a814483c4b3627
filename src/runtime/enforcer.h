// Gives threads their levels and cores, remembers what they had, and gives it back. When the machine refuses a level
// once, it lowers what it raised and asks for none again: the session goes on with rates only, and says so.
//
// Thread safety: all calls from any thread that is not a node's or a dispatcher's (it locks), except lower() and
// raise().
#pragma once

#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>

#include "base/result.h"
#include "os/os.h"

namespace ctn::runtime {

class Enforcer {
 public:
  // `on_refusal` is called once, with what was refused and how to get it, if ever a level is.
  Enforcer(os::Os& os, bool real_time, std::function<void(const std::string&)> on_refusal);
  ~Enforcer() { release_all(); }
  Enforcer(const Enforcer&) = delete;
  Enforcer& operator=(const Enforcer&) = delete;

  bool real_time() const { return real_time_.load(std::memory_order_acquire); }

  // Puts a thread on `cpus` at `level` (kOrdinary where levels cannot be had). A CPU that cannot be had is an error, a
  // level that cannot be had is not: see above. A thread that is gone is neither.
  Status apply(os::ThreadId thread, os::Level level, const os::CpuSet& cpus);

  // For controllers, of threads that apply() has placed before: no lock, no bookkeeping, no answer. Levels are left
  // alone where they cannot be had.
  void set_level_now(os::ThreadId thread, os::Level level);
  void move_now(os::ThreadId thread, const os::CpuSet& cpus);

  // All threads that still live get back what they had before the first apply().
  void release_all();

 private:
  void refuse(const std::string& why);

  os::Os& os_;
  std::atomic<bool> real_time_;
  std::function<void(const std::string&)> on_refusal_;
  std::mutex mutex_;
  std::map<os::ThreadId, os::SavedScheduling> saved_;
};

}  // namespace ctn::runtime
