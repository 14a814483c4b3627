// A system and an engine on it, of a session or a client, in the process that made them.
//
// A forked child has a copy of that memory and none of the threads. What it did with the copy would happen to its
// parent: levels are set by thread numbers, and the region, the record, the guardian and the connection to a server are
// shared. Locks that another thread held at the fork stay locked in the child. So there nothing is called, and nothing
// is destroyed.
//
// Thread safety: here() and elsewhere() from any thread.
#pragma once

#include <memory>
#include <string>
#include <utility>

#include "base/result.h"
#include "os/os.h"

namespace ctn::api {

template <class Engine>
class InOneProcess {
 public:
  // `what` this is of, for messages.
  InOneProcess(std::string what, std::unique_ptr<os::Os> system, std::unique_ptr<Engine> engine)
      : what_(std::move(what)), os_(std::move(system)), engine_(std::move(engine)), process_(os_->current_process()) {}
  ~InOneProcess() {
    if (here()) return;
    static_cast<void>(engine_.release());
    static_cast<void>(os_.release());
  }
  InOneProcess(const InOneProcess&) = delete;
  InOneProcess& operator=(const InOneProcess&) = delete;

  // False: this is the copy in a forked child. Costs a system call of a tenth of a microsecond.
  bool here() const { return os_->current_process() == process_; }
  // What calls return that are made in a child. kCaller.
  Error elsewhere() const {
    return Error::caller("the " + what_ + " was made in another process, of which this one is a fork",
                         "open one here, after the fork");
  }
  Engine& engine() { return *engine_; }

  // What `call` returns, a Status or another Result, of the engine.
  template <class Call>
  auto ask(Call call) -> decltype(call(engine())) {
    if (!here()) return elsewhere();
    return call(engine());
  }

 private:
  const std::string what_;
  std::unique_ptr<os::Os> os_;  // outlives the engine
  std::unique_ptr<Engine> engine_;
  const os::ProcessId process_;
};

}  // namespace ctn::api
