// One execution of a node, as its function sees it. Lives for the call; used only by the node's own thread.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
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
  // In a virtual run (catan/simulation.h): what the run's work was worth, in CPU time on a core of speed 1, all of its
  // threads added up. It is taken in place of what the cost file says; several calls add up. In a session nothing
  // comes of it: there the CPU time counts that the run really uses.
  void charge(std::chrono::nanoseconds cpu);
  // What the run has been charged so far, in a session, too: beside the CPU time that it used it says how much faster
  // or slower the machine is than the one where the work's worth was measured (SimulationOptions::slowdowns).
  std::chrono::nanoseconds charged() const { return charged_.value_or(std::chrono::nanoseconds{0}); }
  // This run gives no output: successors are not triggered, and what it wrote is discarded.
  void skip_output() { emits_ = false; }

  // --- The age of its inputs ---
  // How old what this run takes from node `input` was when the run began: the time since the begin of the source run
  // that it goes back to, and of the oldest of these where it goes back to several. A source is a node that no other
  // node of the app feeds, external ones aside. Of a queue, the oldest of what the run has taken so far; before it has
  // taken any, the first that waits. Where nothing is there to take, what a run took last, which a node may still use.
  //
  // May be asked before read() or after: it takes the newest value of a channel as read() does, which is then noted as
  // consumed; a queue keeps what it has. kNoInput, which is more than any limit, where nothing has come from `input`
  // yet, and where the node has no such input (a misspelt name): so what was never given never passes for fresh.
  static constexpr std::chrono::nanoseconds kNoInput = std::chrono::nanoseconds::max();
  std::chrono::nanoseconds age(std::string_view input);

  // Whether an input is older than its edge's `max_age` in the app file. With `on_stale: skip` such a run gives no
  // output, whatever its function does; it is called all the same, since its state may need the input. An input from
  // which nothing has come yet is not stale. Takes inputs that have a limit, as age() does.
  bool stale();

 private:
  friend class ChannelBase;
  friend class RunAccess;  // the runtime
  // What a value goes back to: the begin of the oldest source run, on the clock that begin_ is of.
  using Origin = std::chrono::nanoseconds;
  static constexpr Origin kNoOrigin{-1};
  struct Input {
    std::uint64_t first = 0;  // 0: nothing consumed
    std::uint64_t last = 0;
    Origin origin = kNoOrigin;  // of what was consumed in this run, or else last; kNoOrigin: nothing was ever
  };
  struct InputEdge {
    std::string from;
    std::chrono::nanoseconds max_age = kNoInput;
    bool skips = false;  // when it is stale
    bool queue = false;
    ChannelBase* channel = nullptr;  // null: none, or none that this node reads
  };
  std::chrono::nanoseconds age_of(const Input& input) const;
  std::chrono::nanoseconds age_at(std::size_t input_index);

  static constexpr std::uint32_t kNoNode = 0xffffffff;
  std::uint32_t node_ = kNoNode;  // whose run it is, by its place in the app
  std::uint64_t number_ = 0;
  std::uint32_t mode_ = 0;
  int threads_ = 1;
  bool emits_ = true;
  std::optional<std::chrono::nanoseconds> charged_;  // so far; none: nothing was
  std::chrono::nanoseconds refused_charge_{0};       // below 0: the first that was
  std::chrono::nanoseconds begin_{0};
  const std::vector<InputEdge>* edges_ = nullptr;  // one a predecessor; null: not known
  std::vector<Input> inputs_;                      // one a predecessor; sized once, reused
  std::vector<ChannelBase*> written_;              // channels to publish when the run ends
};

}  // namespace ctn
