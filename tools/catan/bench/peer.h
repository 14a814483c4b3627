// The other process of a measurement: a copy of this one that runs a node, over memory that both share.
//
// Thread safety: to be made while this process has no other thread.
#pragma once

#include <unistd.h>

#include <functional>

#include "os/linux/forked_process.h"
#include "os/os.h"

namespace ctn::tool {

// Ended at the end of the scope, and by itself within a tenth of a second of its parent's end, however that came.
class Peer {
 public:
  Peer(os::Os& os, const std::function<void()>& body)
      : process_([&os, &body, parent = ::getpid()] {
          const auto watch = os.spawn("bench-watch", [&os, parent] {
            while (::getppid() == parent) os.sleep_until(os.now() + std::chrono::milliseconds{100});
            ::_exit(1);
          });
          body();
          ::_exit(0);
          return 0;
        }) {}

  os::ProcessId process() const { return process_.process(); }

 private:
  os::ForkedProcess process_;
};

}  // namespace ctn::tool
