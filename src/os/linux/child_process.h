// A program that is run as a child of this one.
//
// It starts with no signal blocked or ignored, in the folder, process group and terminal of its parent, so Ctrl-C
// reaches both. No descriptor of ours is open in it but standard input, output and error.
//
// When its owner goes, a child that still runs is asked to end (SIGTERM), made to after two seconds (SIGKILL), and
// waited for: neither a program without its owner is left, nor a zombie. An owner that wants to be gentler waits
// before.
//
// Thread safety: one thread at a time.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "os/linux/descriptor.h"
#include "os/os.h"

namespace ctn::os {

// How a process ended: `signal` is 0 where it returned `code` by itself.
struct Exit {
  int code = 0;
  int signal = 0;
  friend bool operator==(const Exit&, const Exit&) = default;
};

class ChildProcess {
 public:
  // Where its standard output goes: where ours does, or where our standard error does, so that ours is for data.
  enum class Output { kOurs, kErrors };

  // Looks the first argument up in PATH. `environment`: "NAME=value" entries in addition to ours, or in place of ours
  // of the same name. kCaller: no argument, a program that is not there or may not be executed, an entry without a
  // name. kEnvironment: the system has no process left.
  static Result<ChildProcess> start(const std::vector<std::string>& arguments,
                                    const std::vector<std::string>& environment = {}, Output output = Output::kOurs);
  ~ChildProcess();
  ChildProcess(ChildProcess&& other) noexcept;
  ChildProcess& operator=(ChildProcess&&) = delete;
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  ProcessId process() const { return process_; }
  // Readable once it has ended, for a Poller. None where the system does not support that: ask wait() now and then.
  const Descriptor& descriptor() const { return descriptor_; }

  // How it ended; nothing while it runs. Code 255 where another part of this process collected that (or SIGCHLD is
  // ignored).
  std::optional<Exit> wait();
  // Does nothing once it has ended. kEnvironment: not permitted, since the child is another user by now.
  Status signal(int number);

 private:
  ChildProcess(ProcessId process, Descriptor descriptor);
  void end();

  ProcessId process_{};  // 0: moved away
  Descriptor descriptor_;
  std::optional<Exit> exit_;
};

}  // namespace ctn::os
