// One execution of a node, as its function sees it. Lives for the call; used only by the node's own thread.
#pragma once

#include <cstdint>
#include <vector>

namespace ctn {

class ChannelBase;

class Run {
 public:
  std::uint64_t number() const { return number_; }  // counts from 1

  // On how many threads the run should work, the node's own included: as planned, or max_threads of the app file where
  // no plan says. More gain nothing, since they share the cores that the node has; others than the node's own are made
  // by the program and join by Session::adopt_this_thread.
  int threads() const { return threads_; }

  // The node's mode in this run, an index into `modes` of the app file. Default 0.
  void set_mode(std::uint32_t mode) { mode_ = mode; }
  // This run gives no output: successors are not triggered, and what it wrote is discarded.
  void skip_output() { emits_ = false; }

 private:
  friend class ChannelBase;
  friend class RunAccess;  // the runtime
  struct Input {
    std::uint64_t first = 0;  // 0: nothing consumed
    std::uint64_t last = 0;
  };

  std::uint64_t number_ = 0;
  std::uint32_t mode_ = 0;
  int threads_ = 1;
  bool emits_ = true;
  std::vector<Input> inputs_;          // one a predecessor; sized once, reused
  std::vector<ChannelBase*> written_;  // channels to publish when the run ends
};

}  // namespace ctn
