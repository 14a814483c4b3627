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
#include "runtime/assignment_board.h"
#include "runtime/enforcer.h"
#include "runtime/node_link.h"
#include "runtime/wake_budget.h"
#include "runtime/word_ring.h"

namespace ctn::runtime {

// What the controllers of a session share. Lives as long as the session.
struct Controls {
  Controls(os::Os& system, Enforcer& levels, const Region& memory, std::size_t subchains, std::size_t cores)
      : os(system), enforcer(levels), region(memory), board(subchains + cores), handovers(subchains) {}

  // What a controller sleeps on; they are numbered as the region's attentions are: subchains, then cores.
  std::size_t number_of_core(int core) const { return handovers.size() + static_cast<std::size_t>(core); }
  // Whoever is to have a subchain by an assignment.
  std::size_t holder_of(const policy::SubchainPlace& place, SubchainId subchain) const {
    return place.core >= 0 ? number_of_core(place.core) : subchain.index();
  }
  void nudge(std::size_t controller) { region.attention(controller).nudge(os); }
  void nudge_all() {
    for (std::size_t controller = 0; controller < region.attentions(); ++controller) nudge(controller);
  }

  os::Os& os;
  Enforcer& enforcer;
  const Region& region;
  AssignmentBoard board;  // its readers: controllers, by number
  std::deque<Handover> handovers;
};

// Takes what controllers did, in the housekeeping thread.
class ReportSink {
 public:
  virtual ~ReportSink() = default;
  virtual void triggered(const record::Trigger& trigger) = 0;
  virtual void slot_over(const record::Slot& slot) = 0;
  virtual void stole(const record::Steal& steal) = 0;
  virtual void hang_changed(SubchainId subchain, bool began, TimePoint at) = 0;
  virtual void woke_late(int cpu, TimePoint due, TimePoint woke) = 0;  // starvation.h
};

class Controller {
 public:
  virtual ~Controller() = default;
  virtual void run() = 0;
  void stop();

  // All since the last call.
  void drain(ReportSink& sink);
  std::uint64_t lost_reports() const { return reports_.lost(); }
  // How often it would not be woken, as it had been too often.
  std::uint64_t floods() const { return wakes_.floods(); }

 protected:
  // `core`: -1 where it has none.
  Controller(Controls& controls, const std::vector<SubchainLinks>& subchains, std::size_t number, int core);

  bool stopping() const { return stopping_.load(std::memory_order_acquire); }
  std::uint32_t attention_now() const { return attention_.word.load(std::memory_order_acquire); }
  // Until it is nudged (its attention is no longer `seen`) or `until` has come. `awake`: not at all, there is news
  // already. Who is woken without end sleeps all the same (wake_budget.h).
  void sleep(std::uint32_t seen, TimePoint until, bool awake = false);
  const Assignment& look() { return controls_.board.look(number_); }
  TimePoint now() { return controls_.os.now(); }

  SignalCell& signal(SubchainId id) const { return *subchains_[id.index()].signal; }
  std::uint64_t completed(SubchainId id) const { return signal(id).completed.load(std::memory_order_seq_cst); }
  // Its end of a run wakes this controller, if `wanted`.
  // Says anew where, as others may have written there.
  void want_completions(SubchainId id, bool wanted) {
    if (wanted) signal(id).listener.store(static_cast<std::uint32_t>(number_ + 1), std::memory_order_seq_cst);
    signal(id).wants_completions.store(wanted ? 1 : 0, std::memory_order_seq_cst);
  }
  void trigger(SubchainId id, std::uint64_t number, TimePoint due);

  // Takes a subchain into its hands: its runs report here, its threads run on `cpus`.
  void hold(SubchainId id, const os::CpuSet& cpus);
  void move_threads(SubchainId id, const os::CpuSet& cpus);
  void set_level(SubchainId id, os::Level level);
  void set_levels(SubchainId id, const policy::SubchainPlace& place);  // as the place says
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
  enum class Report : std::uint64_t { kTrigger, kHangBegan, kHangEnded, kSlot, kSteal, kWokeLate };

  void report(Report kind, SubchainId id, std::uint64_t a, std::uint64_t b, std::uint64_t c);
  void deliver(std::span<const std::uint64_t> words, ReportSink& sink) const;

  Controls& controls_;
  const std::vector<SubchainLinks>& subchains_;  // by SubchainId
  std::size_t number_;
  int core_;
  Attention& attention_;
  std::vector<std::uint32_t> threads_seen_;  // by SubchainId: how often threads had joined
  WordRing reports_;
  WakeBudget wakes_;
  std::atomic<bool> stopping_{false};
};

}  // namespace ctn::runtime
