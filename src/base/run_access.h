// The runtime's side of a Run: what its public face (include/catan/run.h) keeps to itself.
#pragma once

#include <cstdint>
#include <span>

#include "catan/channel.h"
#include "catan/run.h"

namespace ctn {

class RunAccess {
 public:
  using Input = Run::Input;

  // Makes `run` ready for its next execution, with `inputs` inputs of which nothing is consumed yet.
  static void reset(Run& run, std::uint64_t number, std::size_t inputs) {
    run.number_ = number;
    run.mode_ = 0;
    run.emits_ = true;
    run.inputs_.assign(inputs, Input{});
  }

  static void set_threads(Run& run, int threads) { run.threads_ = threads; }

  static void consume(Run& run, std::size_t slot, std::uint64_t first, std::uint64_t last) {
    run.inputs_[slot] = {first, last};
  }

  static std::uint32_t mode(const Run& run) { return run.mode_; }
  static bool emits(const Run& run) { return run.emits_; }
  static std::span<const Input> inputs(const Run& run) { return run.inputs_; }

  // Publishes what the run wrote, or discards it where the run skipped its output.
  static void finish_writes(Run& run) {
    for (ChannelBase* channel : run.written_) {
      if (run.emits_) {
        channel->publish(run.number_);
      } else {
        channel->discard();
      }
    }
    run.written_.clear();
  }
};

}  // namespace ctn
