// What all threads that trigger subchains have in common: they run at the dispatcher level and never wait for anybody
// below it. What they are to do they read from a board (assignment.h); what they did leaves through a ring; a subchain
// passes from one to the other by a hand-over. At any time one controller holds a subchain, or nobody does.
//
//   TriggerThread  one a subchain: paces it while it has its CPUs to itself
//   CoreThread     one a core: takes turns among those that share it
//
// Each is also the watchdog of what it holds: a run that hangs is contained, so that it cannot take the machine with
// it.
//
// Units: in the types. Thread safety: run() is the thread's body; the rest may be called from one other thread.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <span>
#include <vector>

#include "graph/app.h"
#include "os/os.h"
#include "record/events.h"
#include "runtime/assignment.h"
#include "runtime/enforcer.h"
#include "runtime/node_port.h"
#include "runtime/word_ring.h"

namespace ctn::runtime {

// What the controllers of a session share. Lives as long as the session.
struct Controls {
  Controls(os::Os& system, Enforcer& levels, std::size_t subchains, std::size_t cores)
      : os(system),
        enforcer(levels),
        board(subchains + cores),
        handovers(subchains),
        of_subchain(subchains),
        of_core(cores) {}

  // Whoever is to have a subchain by an assignment sleeps on this.
  Attention& attention_of(const SubchainPlace& place, SubchainId subchain) {
    return place.core >= 0 ? of_core[static_cast<std::size_t>(place.core)] : of_subchain[subchain.index()];
  }
  void nudge_all() {
    for (Attention& attention : of_subchain) attention.nudge(os);
    for (Attention& attention : of_core) attention.nudge(os);
  }

  os::Os& os;
  Enforcer& enforcer;
  AssignmentBoard board;  // its readers: subchains, then cores
  std::deque<Handover> handovers;
  std::deque<Attention> of_subchain;
  std::deque<Attention> of_core;
};

// Takes what controllers did, in the housekeeper's thread.
class ReportSink {
 public:
  virtual ~ReportSink() = default;
  virtual void triggered(const record::Trigger& trigger) = 0;
  virtual void slot_over(const record::Slot& slot) = 0;
  virtual void stole(const record::Steal& steal) = 0;
  virtual void hang_changed(SubchainId subchain, bool began) = 0;
};

class Controller {
 public:
  virtual ~Controller() = default;
  virtual void run() = 0;
  void stop();

  // All since the last call.
  void drain(ReportSink& sink);
  std::uint64_t lost_reports() const { return reports_.lost(); }

 protected:
  // `core`: -1 where it has none.
  Controller(Controls& controls, const std::vector<SubchainPorts>& subchains, std::size_t reader, int core,
             Attention& attention);

  bool stopping() const { return stopping_.load(std::memory_order_acquire); }
  std::uint32_t attention_now() const { return attention_.word.load(std::memory_order_acquire); }
  void sleep(std::uint32_t seen, TimePoint until) { controls_.os.wait(attention_.word, seen, until); }
  const Assignment& look() { return controls_.board.look(reader_); }
  TimePoint now() { return controls_.os.now(); }

  SubchainSignal& signal(SubchainId id) const { return *subchains_[id.index()].signal; }
  std::uint64_t completed(SubchainId id) const { return signal(id).completed.load(std::memory_order_seq_cst); }
  // Its end of a run wakes this controller, if `wanted`.
  void want_completions(SubchainId id, bool wanted) {
    signal(id).wants_completions.store(wanted, std::memory_order_seq_cst);
  }
  void trigger(SubchainId id, std::uint64_t number, TimePoint due);

  // Takes a subchain into its hands: its runs report here, its threads run on `cpus`.
  void hold(SubchainId id, const os::CpuSet& cpus);
  void move_threads(SubchainId id, const os::CpuSet& cpus);
  void set_level(SubchainId id, os::Level level);
  // Lets go of it, and tells whoever is to have it now.
  void hand_over(SubchainId id, const dispatch::RunState& state);
  // Whether threads have joined the subchain's nodes since it was last asked.
  bool threads_joined(SubchainId id);

  void report_hang(SubchainId id, bool began, TimePoint at);
  void report_slot(SubchainId id, TimePoint planned, TimePoint begin, TimePoint end);
  void report_steal(SubchainId thief, SubchainId victim, TimePoint begin, TimePoint end);

 private:
  static constexpr std::size_t kReports = 8192;
  static constexpr std::size_t kWords = 5;
  enum class Report : std::uint64_t { kTrigger, kHangBegan, kHangEnded, kSlot, kSteal };

  void report(Report kind, SubchainId id, std::uint64_t a, std::uint64_t b, std::uint64_t c);
  void deliver(std::span<const std::uint64_t> words, ReportSink& sink) const;

  Controls& controls_;
  const std::vector<SubchainPorts>& subchains_;  // by SubchainId
  std::size_t reader_;
  int core_;
  Attention& attention_;
  std::vector<std::uint32_t> threads_seen_;  // by SubchainId: how often threads had joined
  WordRing reports_;
  std::atomic<bool> stopping_{false};
};

}  // namespace ctn::runtime
