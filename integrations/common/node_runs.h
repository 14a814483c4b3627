// The runs of a node, and what the one under way has taken from which runs of its predecessors.
//
//   taken      messages that the run was called with, or has read
//   kept       what the program or the node had before; counts where none of that node was taken
//   let go     of those that the program kept before, which it has let go of in the run; counts in place of kept ones
//
// Thread safety: used by the node's thread alone.
#pragma once

#include <catan/client.h>

#include <cstdint>
#include <string>
#include <vector>

#include "common/bound_callback.h"

namespace catan_ros {

// Where lineage is known.
class Runs : public Schedule {
 public:
  virtual std::uint64_t number() const = 0;  // of the run under way
  // By the run under way, an output of that run of `from`.
  virtual void take(const std::string& from, std::uint64_t run) = 0;
  // It has that output from before.
  virtual void keep(const std::string& from, std::uint64_t run) = 0;
};

// Those of a node that a server schedules.
class NodeRuns final : public Runs {
 public:
  explicit NodeRuns(ctn::AttachedNode node) : node_(node) {}

  ctn::Awaited await() override { return node_.await(); }
  bool await_complete() override { return node_.await_complete(); }
  void begin() override;
  void end(bool output) override;

  std::uint64_t number() const override { return run_.number(); }
  void take(const std::string& from, std::uint64_t run) override;
  void keep(const std::string& from, std::uint64_t run) override { kept_.push_back({from, run, false}); }
  void let_go(const std::string& from, std::uint64_t run);

 private:
  struct Taken {
    std::string from;
    std::uint64_t first;
    std::uint64_t last;
  };
  struct Kept {
    std::string from;
    std::uint64_t run;
    bool let_go;
  };
  std::vector<Taken>::iterator find(const std::string& from);

  ctn::AttachedNode node_;
  ctn::Run run_;
  std::vector<Taken> taken_;
  std::vector<Kept> kept_;
};

}  // namespace catan_ros
