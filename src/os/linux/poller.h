// Waits for whatever comes first: one of a set of descriptors has something to read, a deadline, or a call of wake().
//
// A descriptor is reported again and again until it is read, and none is starved by others. A socket whose other end is
// closed and the pidfd of a process that has ended count as readable.
//
// Units: TimePoint as os.h. Thread safety: wait() from one thread at a time, everything else from any.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "base/result.h"
#include "base/time.h"
#include "os/linux/descriptor.h"

struct epoll_event;

namespace ctn::os {

class Poller {
 public:
  using Key = std::uint64_t;
  static constexpr Key kKeys = ~Key{0} - 1;  // keys are below this

  // `call_takes_deadline`: false plays a kernel before 5.11.
  static Result<std::unique_ptr<Poller>> make(bool call_takes_deadline = true);

  // Preconditions: the descriptor is valid and not in the set. It is taken out by remove(), before it is closed: where
  // another process has a copy of it, closing alone does not do it. kEnvironment: the system has no room left.
  Status add(const Descriptor& descriptor, Key key);
  void remove(const Descriptor& descriptor);

  // The keys of the descriptors that are readable, at most 64 at once; none after the deadline (kNever: no deadline) or
  // wake(). A key that another thread removes meanwhile may be among them. Valid until the next call.
  const std::vector<Key>& wait(TimePoint deadline);
  // Ends the wait() that is going on, or else the next one, at once.
  void wake();

 private:
  Poller(Descriptor set, Descriptor timer, Descriptor event, bool call_takes_deadline);
  void set_timer(TimePoint deadline);
  int wait_for_events(std::span<epoll_event> events, TimePoint deadline);

  Descriptor set_;
  Descriptor timer_;  // for kernels before 5.11, whose call takes no deadline but in milliseconds
  Descriptor event_;
  bool call_takes_deadline_;
  std::vector<Key> ready_;
};

}  // namespace ctn::os
