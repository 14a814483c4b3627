// A thread as FakeOs knows it; for its implementation alone.
#pragma once

#include <fmt/format.h>

#include <condition_variable>
#include <string>
#include <thread>

#include "os/fake/fake_os.h"

namespace ctn::os {

inline std::string show_time(TimePoint time) {
  return fmt::format("{:.6f} ms", to_millis(time.time_since_epoch()).count());
}

inline Error gone(const std::string& what, ThreadId thread) {
  return Error::environment(fmt::format("cannot {} thread {}: it is gone", what, static_cast<int>(thread)),
                            "threads that end while they are scheduled need no action");
}

struct FakeOs::Task {
  ThreadId id{};
  std::string name;
  std::uint64_t started = 0;  // how many threads have had its number before
  bool ended = false;
  TimePoint wake_at{};        // can run from then on; kNever: someone must wake it
  std::uint64_t yielded = 0;  // not 0: it could have gone on; the least has been waiting longest
  const std::atomic<std::uint32_t>* word = nullptr;
  const Task* joining = nullptr;
  std::optional<TimePoint> burning_since;
  Nanos cpu_time{0};
  Nanos ready_time{0};
  std::uint64_t times_blocked = 0;
  Level level = Level::kOrdinary;
  bool reset_on_fork = false;
  CpuSet cpus;  // as asked; those that are online count
  std::thread thread;
  std::condition_variable baton;

  std::string who() const { return fmt::format("thread {} '{}' ({})", static_cast<int>(id), name, to_string(level)); }

  std::string describe() const {
    if (ended) return who() + " has ended";
    if (word) return fmt::format("{} waits for a word that is {}", who(), word->load());
    if (joining) return fmt::format("{} joins thread {}", who(), static_cast<int>(joining->id));
    if (wake_at == kNever) return who() + " sleeps for ever";
    return fmt::format("{} can run at {}", who(), show_time(wake_at));
  }
};

}  // namespace ctn::os
