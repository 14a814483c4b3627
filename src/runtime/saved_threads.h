// The scheduling that threads had before Catan changed it, and the way back: the only place that remembers it, for the
// scheduler (enforcer.h) and for programs that restore their threads themselves (client_nodes.h).
//
// Thread safety: none; its owner locks.
#pragma once

#include <map>

#include "os/os.h"

namespace ctn::runtime {

class SavedThreads {
 public:
  // `scheduling` outlives it.
  explicit SavedThreads(os::ThreadScheduling& scheduling) : scheduling_(scheduling) {}

  // Whether this very thread is known. One that has the number of a thread that ended is not.
  bool has(const os::SavedScheduling& thread) const;
  bool has(os::ThreadId thread) const { return saved_.contains(thread); }
  // What the thread has now is what it gets back.
  void save(os::SavedScheduling now) { saved_.insert_or_assign(now.thread, std::move(now)); }
  void forget(os::ThreadId thread) { saved_.erase(thread); }

  // Threads that are gone, or not known, are left alone.
  void restore(os::ThreadId thread) const;
  void restore_all() const;
  // All but the CPUs, of all of them.
  void restore_levels() const;
  // Of a thread that is not known: it becomes ordinary if it was `raised`, and gets the CPUs that `like` had, if that
  // is known.
  void restore_unknown(os::ThreadId thread, bool raised, os::ThreadId like) const;

  template <class Visit>
  void for_each_thread(Visit&& visit) const {
    for (const auto& [thread, saved] : saved_) visit(thread);
  }
  void clear() { saved_.clear(); }

 private:
  os::ThreadScheduling& scheduling_;
  std::map<os::ThreadId, os::SavedScheduling> saved_;
};

}  // namespace ctn::runtime
