// Signals as something to read, for a Poller, instead of something that interrupts.
//
// They are blocked in the thread that starts the watch and in all threads that it makes from then on, so start it
// before other threads: a thread that was there before still takes a signal in the usual way. A ChildProcess starts
// with none blocked. Several signals of a kind may come as one.
//
// Thread safety: one thread, the one that started it, also destroys it.
#pragma once

#include <optional>
#include <vector>

#include "base/result.h"
#include "os/linux/descriptor.h"

namespace ctn::os {

class SignalWatch {
 public:
  // kCaller: a number that is no signal, or one that cannot be blocked. kEnvironment: no descriptor is left.
  static Result<SignalWatch> start(const std::vector<int>& signals);
  // Unblocks what was not blocked before. Signals that came but were not read are forgotten.
  ~SignalWatch();
  SignalWatch(SignalWatch&&) = default;
  SignalWatch& operator=(SignalWatch&&) = delete;
  SignalWatch(const SignalWatch&) = delete;
  SignalWatch& operator=(const SignalWatch&) = delete;

  // The number of a signal that came; nothing when none did.
  std::optional<int> next();
  // Readable when next() has one.
  const Descriptor& descriptor() const { return descriptor_; }

 private:
  SignalWatch(Descriptor descriptor, std::vector<int> blocked);

  Descriptor descriptor_;
  std::vector<int> blocked_;
};

}  // namespace ctn::os
