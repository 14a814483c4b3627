// The memory through which nodes and their scheduler communicate: triggers, ends of runs, reports of runs. Each app has
// one region. In one process it lies on the heap; between processes it is a shared mapping. On the hot path all
// communication goes through it, with no system call but the futex.
//
// One block, laid out in this order by rules that depend on the app alone, so that every process that has read the app
// knows where everything is. Where the policy has subchains cut, the header says so, and what is said of the app is
// said of the app so cut:
//   RegionHeader
//   the app file's text
//   Heartbeat
//   ControllerCell  one a subchain, then one a core: the controller sleeps on it
//   SignalCell      one a subchain
//   NodeCell        one a node
//   a ring          one a node that is not external: RingHeader, then kReports reports (report.h)
//
// Every process that has the region may write anything into it at any time. So no index found there is used without a
// check of its range, and no thread spins on a value; what the scheduler must rely on, it keeps in memory of its own.
//
// Units: bytes; Nanos in words of 64 bits. Thread safety: all cells are atomics.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "base/time.h"
#include "graph/app.h"
#include "os/threads.h"
#include "runtime/word_ring.h"

namespace ctn::runtime {

class Region;

struct RegionHeader {
  static constexpr std::uint64_t kMagic = 0x6e61746163ULL;  // "catan"
  static constexpr std::uint32_t kVersion = 8;

  std::uint64_t magic = kMagic;
  std::uint32_t version = kVersion;
  std::uint32_t cores = 0;
  std::uint64_t size = 0;  // of all
  std::uint64_t text_size = 0;
  std::uint64_t cut = 0;  // 1: for the app with its subchains cut (graph/cut.h)
};

// The server's heartbeat: programs tell by it that a server still exists but does nothing, as when it was stopped.
struct alignas(64) Heartbeat {
  std::atomic<std::uint32_t> beats{0};
  // In ns: a server that runs is never this late with the next. 0: no heartbeat.
  std::atomic<std::int64_t> max_heartbeat_gap{0};
};

// What a controller (controller_thread.h) sleeps on.
struct alignas(64) ControllerCell {
  std::atomic<std::uint32_t> word{0};

  // Wakes the controller, which then checks everything again.
  void wake(os::Threads& threads);
};

// Outputs of a subchain's tail, or of an unscheduled node, for the controllers that follow them.
struct OutputCell {
  static constexpr std::size_t kMaxSubscribers = 4;

  std::atomic<std::uint64_t> outputs{0};       // that were given
  std::atomic<std::int64_t> newest_output{0};  // ns; when that came
  // 0: free. Else 1 + the number of a controller, in the lowest kControllerBits, and above them, as far as it has room,
  // the count of outputs from which on the controller is woken at each.
  static constexpr int kControllerBits = 20;
  std::array<std::atomic<std::uint64_t>, kMaxSubscribers> subscribers{};

  // By the node that gives them: counts an output, and wakes the controllers that wait for it.
  void give_output(os::Threads& threads, const Region& region, TimePoint at);
  // By a controller: it is woken once there are so many outputs, and at each one beyond. False: there is no room. It
  // does so again and again, since other processes may have overwritten it.
  bool subscribe(std::size_t controller, std::uint64_t count);
  void unsubscribe(std::size_t controller);
};

// Between the nodes of a subchain and the controllers that hold it, and follow its outputs.
struct alignas(64) SignalCell : OutputCell {
  std::atomic<std::uint64_t> completed{0};          // the newest token whose run has ended
  std::atomic<std::uint32_t> holder{0};             // 1 + the number of the controller that holds it; 0: none
  std::atomic<std::uint32_t> wants_completions{0};  // only then is the holder woken when a run ends
  std::atomic<std::int64_t> period{0};              // ns; what nodes go on at without a scheduler. 0: unknown
  std::atomic<std::int32_t> threads{0};             // on how many a node's run should work; 0: no plan says
  // 1: a node is missing, and nothing is triggered until it is there (incomplete_subchains.h). Nodes that ask for it
  // are woken when that changes; before the next trigger it is 0 again.
  std::atomic<std::uint32_t> incomplete{0};
};

static_assert(sizeof(SignalCell) == 128, "else others are elsewhere, and kVersion is another");

struct alignas(64) NodeCell {
  static constexpr std::size_t kMaxThreads = graph::kMaxThreads;
  static constexpr std::size_t kOutputs = 64;  // so many have their origin here

  // What an output goes back to (record/ages.h). `number` is that of the run; with kWriting, the rest is about to
  // change.
  struct Output {
    static constexpr std::uint64_t kWriting = std::uint64_t{1} << 63U;
    std::atomic<std::uint64_t> number{0};
    std::atomic<std::int64_t> origin{0};     // ns of the monotonic clock
    std::atomic<std::uint64_t> previous{0};  // number of the output before it; 0: none
  };

  // What the node sleeps on: low half of the newest token; of a node that follows, a count of what it was given.
  std::atomic<std::uint32_t> word{0};
  std::atomic<std::uint64_t> number{0};                         // of the newest run that began; 0: none
  std::atomic<std::uint64_t> newest_output{0};                  // number of the newest run that gave output; 0: none
  alignas(64) std::atomic<std::uint32_t> threads{0};            // none from here on, of the ones below
  std::array<std::atomic<std::int32_t>, kMaxThreads> thread{};  // 0: none, or ended
  alignas(64) std::array<Output, kOutputs> outputs{};           // by number modulo kOutputs
  alignas(64) OutputCell led;                                   // of an unscheduled node: for subchains that follow it

  // Run `run` of the node gives output: what it goes back to, and then that it is there. By the node.
  void give(std::uint64_t run, std::int64_t origin);
  // The origin of the output of run `run`, and the oldest origin of the outputs from `first` to `last`, which is an
  // output: from 0 up, whatever another process wrote. kUnknown: another output has taken its place, or it was none.
  static constexpr std::int64_t kUnknown = -1;
  std::int64_t origin_of(std::uint64_t run) const { return find(run).origin; }
  std::int64_t oldest_origin(std::uint64_t first, std::uint64_t last) const;

 private:
  struct Found {
    std::int64_t origin = kUnknown;
    std::uint64_t previous = 0;
  };
  Found find(std::uint64_t run) const;
};

class Region {
 public:
  static constexpr std::size_t kReports = 4096;

  static std::size_t size_for(const graph::Graph& graph, std::size_t cores, std::string_view text);

  // Lays out memory that is all zero, of size_for() bytes, aligned to 64. The memory outlives the region.
  // `cut`: the graph is that of the text's app with its subchains cut.
  static Region create(const graph::Graph& graph, std::size_t cores, std::string_view text, std::span<std::byte> memory,
                       bool cut = false);

  // Memory that another process has laid out. Errors (kEnvironment): it is not a region, or of another version, or not
  // of the size that it says. First read the app from text(), and cut it where is_cut() says so, then open() with its
  // graph.
  static Result<std::string> text(std::span<const std::byte> memory);
  static Result<bool> is_cut(std::span<const std::byte> memory);
  static Result<Region> open(const graph::Graph& graph, std::span<std::byte> memory);

  Heartbeat& heartbeat() const { return *heartbeat_; }
  std::size_t controller_cells() const { return controller_cells_.size(); }
  ControllerCell& controller_cell(std::size_t index) const { return controller_cells_[index]; }
  SignalCell& signal(SubchainId subchain) const { return signals_[subchain.index()]; }
  NodeCell& node(NodeId node) const { return nodes_[node.index()]; }
  // Of a node that is not external.
  RingWriter reports_writer(NodeId node) const;
  RingReader reports_reader(NodeId node) const;

 private:
  struct Layout;
  struct Ring {
    RingHeader* header = nullptr;
    std::span<std::uint64_t> words;
    std::size_t stride = 0;
  };

  Region(const graph::Graph& graph, const Layout& layout, std::span<std::byte> memory);

  Heartbeat* heartbeat_;
  std::span<ControllerCell> controller_cells_;
  std::span<SignalCell> signals_;
  std::span<NodeCell> nodes_;
  std::vector<Ring> rings_;  // by NodeId
};

// A region on the heap, for one process.
class LocalRegion {
 public:
  LocalRegion(const graph::Graph& graph, std::size_t cores);

  Region& region() { return region_; }

 private:
  struct alignas(64) Line {
    std::array<std::byte, 64> bytes;
  };
  std::vector<Line> memory_;
  Region region_;
};

}  // namespace ctn::runtime
