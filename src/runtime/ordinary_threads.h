// Finds out that threads of a program which no node has wait for a CPU most of the time: ready to run, but not running,
// since all that is scheduled goes before them. Something of the program (a callback that is not bound, a helper
// thread) then makes no progress, and nothing else shows it. Pure; one object a program.
//
// A thread waits most of the time if it was ready for at least half of the time between two looks. A program is told of
// once, with all threads for which this is so, and again only when none of its threads has waited like this for half a
// minute. So threads that wait by turns, or come and go, are told of once.
//
// Linux counts a wait when it ends. One that is longer than the time between two looks is all counted in the last of
// them; of a thread that never gets a CPU nothing is known.
//
// Units: Nanos. Thread safety: none; one owner.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "base/time.h"
#include "os/threads.h"

namespace ctn::runtime {

class OrdinaryThreads {
 public:
  // How often to look: so seldom that it costs next to nothing.
  static constexpr Nanos kPeriod = std::chrono::seconds{5};
  // It is told again only after no thread has waited most of the time for so long.
  static constexpr Nanos kQuiet = std::chrono::seconds{30};

  // Since the thread began.
  struct Sample {
    os::ThreadId thread{};
    Nanos ready{0};  // to run, without running
    Nanos cpu{0};
  };
  // Since the look before.
  struct Waiting {
    os::ThreadId thread{};
    Nanos waited{0};  // at most the time between the looks
    Nanos ran{0};
    friend bool operator==(const Waiting&, const Waiting&) = default;
  };
  struct News {
    Nanos elapsed{0};              // since the look before
    std::vector<Waiting> threads;  // those that waited longest first; empty: there is nothing to tell
  };

  // `threads`: all that no node has now. One that was not among them at the last look counts from now on.
  News look(TimePoint now, const std::vector<Sample>& threads);

 private:
  std::map<os::ThreadId, Sample> before_;
  TimePoint looked_at_{};
  bool told_ = false;
  TimePoint waited_at_{};  // when this was last so; if told_
};

// What a user is told. `program`: what it is called, and what it runs. `name_of`: empty where a thread is gone.
std::string notice_of(const std::string& program, const OrdinaryThreads::News& news,
                      const std::function<std::string(os::ThreadId)>& name_of);

}  // namespace ctn::runtime
