// Which run of a node was under way at a time: how the lineage of data is known where messages carry the time at which
// they were sent, and what sends them cannot be asked (ROS 2).
//
// A node notes when its runs begin and end, by the system's clock, which is the one that middleware stamps messages
// with; who gets a message looks up the run of the predecessor within which it was sent. Runs of a node do not overlap,
// so there is one at most. Where the clock is set meanwhile, a run may not be found.
//
// All is in a file that the programs of an app share: for each of at most kSharedNodes nodes the last kRuns runs.
//
// Units: nanoseconds since the epoch. Thread safety: all calls from any thread, begin() and end() of a node by one at a
// time; wait-free. What another program wrote is not trusted: at worst a run is not found, or a wrong one is.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "common/hash.h"
#include "common/shared_file.h"

namespace catan_ros {

class RunTimes {
 public:
  static constexpr std::size_t kRuns = 64;

  // Makes the file if it is not there; without a path memory of this program alone. Null: it cannot be had, or the file
  // is not this user's.
  static std::unique_ptr<RunTimes> open(const std::string& path);

  // `run` is not 0.
  void begin(std::string_view node, std::uint64_t run, std::int64_t now);
  void end(std::string_view node, std::int64_t now);
  // The run of `node` within which that time is; 0: none that is known.
  std::uint64_t find(std::string_view node, std::int64_t time) const;

 private:
  struct Run {
    std::atomic<std::uint64_t> number{0};  // 0: being written, or none
    std::atomic<std::int64_t> begin{0};
    std::atomic<std::int64_t> end{0};  // 0: under way
  };
  struct Node {
    std::atomic<std::uint64_t> hash{0};  // of its name
    std::atomic<std::uint64_t> begun{0};
    std::array<Run, kRuns> runs{};
  };

  using Nodes = std::array<Node, kSharedNodes>;

  explicit RunTimes(std::unique_ptr<SharedFile<Nodes>> file) : file_(std::move(file)) {}
  Node* find_node(std::string_view name, bool make) const { return find_entry(file_->content(), hash_of(name), make); }

  std::unique_ptr<SharedFile<Nodes>> file_;
};

}  // namespace catan_ros
