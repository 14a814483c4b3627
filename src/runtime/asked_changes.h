// What is asked to be different while a session runs (catan/changes.h): checked where it is asked, all of it or
// nothing, and taken by the housekeeping thread in its next step, which follows at once.
//
// Thread safety: every call from any thread (it locks).
#pragma once

#include <cstdint>
#include <mutex>
#include <optional>
#include <utility>

#include "base/result.h"
#include "catan/changes.h"
#include "graph/app.h"
#include "os/cpu_set.h"

namespace ctn::runtime {

class AskedChanges {
 public:
  struct State {
    graph::App app;   // with the weights and bounds that hold
    os::CpuSet cpus;  // that nodes may use, of the CPUs that were given
  };

  AskedChanges(graph::App app, os::CpuSet given) : given_(given), state_{std::move(app), std::move(given)} {}

  // Errors: everything that is wrong; then nothing is changed. kCaller.
  Status ask(const Changes& changes);
  // As asked last, if anything was since it was last taken.
  std::optional<State> take();
  // As asked last, and how often anything was.
  State now() const;
  std::uint64_t count() const;

 private:
  Result<os::CpuSet> choose(const Changes& changes) const;

  const os::CpuSet given_;
  mutable std::mutex mutex_;  // guards what follows
  State state_;
  std::uint64_t count_ = 0;
  bool taken_ = true;
};

}  // namespace ctn::runtime
