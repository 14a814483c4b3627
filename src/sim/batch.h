// Many simulations at once, on all CPUs of this machine. What comes out does not depend on how many threads there are.
//
// Thread safety: as each function says.
#pragma once

#include <atomic>
#include <cstddef>
#include <functional>
#include <utility>

namespace ctn::sim {

// Calls work(0) to work(count - 1), each once, from `threads` threads (0: one a CPU); returns when all have returned.
// `work` is called from several threads at once; an exception of the lowest index is thrown on.
void for_each_in_parallel(std::size_t count, std::size_t threads, const std::function<void(std::size_t)>& work);

// Tells how much is done of what several threads do: one call at a time, with no lock held and no thread waiting for
// it. What is done during a call is told by the thread that makes it, when the call has returned.
class Progress {
 public:
  // `tell` may be empty. `done`: so much is done already.
  explicit Progress(std::function<void(std::size_t done)> tell, std::size_t done = 0)
      : tell_(std::move(tell)), told_(done) {}

  // One more is done. From any thread.
  void add();

 private:
  const std::function<void(std::size_t)> tell_;
  std::atomic<std::size_t> untold_{0};
  std::size_t told_;  // of the thread that made `untold_` other than 0
};

}  // namespace ctn::sim
