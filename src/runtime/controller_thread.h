// The thread of a controller (driver/controller.h): it looks at the board, lets its driver step, and sleeps until the
// driver is to step again. What the driver decides it carries out with system calls and cells of the region; what was
// done leaves through a ring. It runs at the dispatcher level and never waits for a thread below it. The thread of a
// core's controller is pinned to that core's CPU, so that no node of the core runs while it decides. Timers are
// absolute, so delays do not add up.
//
// Units: in the types. Thread safety: run() is the thread's body, and what an actuator does belongs to it; the rest may
// be called from one other thread.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <span>
#include <vector>

#include "driver/actuator.h"
#include "driver/controller.h"
#include "graph/app.h"
#include "os/os.h"
#include "record/events.h"
#include "runtime/assignment_board.h"
#include "runtime/clock_board.h"
#include "runtime/enforcer.h"
#include "runtime/node_link.h"
#include "runtime/run_clock.h"
#include "runtime/wake_budget.h"
#include "runtime/word_ring.h"

namespace ctn::runtime {

// What the controllers of a session share. Lives as long as the session.
struct Controls {
  Controls(os::Os& system, Enforcer& levels, const Region& memory, const graph::Graph& graph, std::size_t cores)
      : os(system),
        enforcer(levels),
        region(memory),
        board(graph.subchains().size() + cores),
        clocks(graph.nodes().size()),
        handovers(graph.subchains().size()) {}

  // By its number (driver/controller.h), which is that of its cell in the region, on which it sleeps.
  void wake(std::size_t controller) { region.controller_cell(controller).wake(os); }
  void wake_all() {
    for (std::size_t controller = 0; controller < region.controller_cells(); ++controller) wake(controller);
  }

  os::Os& os;
  Enforcer& enforcer;
  const Region& region;
  AssignmentBoard board;  // its readers: controllers, by number
  ClockBoard clocks;
  std::deque<Handover> handovers;
};

// Takes what controllers did, in the housekeeping thread.
class ReportSink {
 public:
  virtual ~ReportSink() = default;
  virtual void triggered(const record::Trigger& trigger) = 0;
  virtual void slot_over(const record::SlotUse& slot) = 0;
  virtual void stole(const record::Steal& steal) = 0;
  virtual void hang_changed(SubchainId subchain, bool began, TimePoint at) = 0;
  virtual void over_budget(const record::Overrun& overrun) = 0;
  virtual void woke_late(int cpu, TimePoint due, TimePoint woke) = 0;  // starvation.h
};

class ControllerThread final : public driver::Actuator {
 public:
  // Its number tells which subchain or core it is for. All references outlive it.
  ControllerThread(Controls& controls, const std::vector<SubchainLinks>& subchains, std::size_t number);

  void run();
  void stop();

  // All since the last call.
  void drain(ReportSink& sink);
  std::uint64_t lost_reports() const { return reports_.lost(); }
  // How often it has looked what there is to do.
  std::uint64_t steps() const { return steps_.load(std::memory_order_relaxed); }
  // Of these, so many because the time had come; read before steps().
  std::uint64_t steps_by_timer() const { return steps_by_timer_.load(std::memory_order_relaxed); }
  // How often it ignored a wake, because there had been too many.
  std::uint64_t ignored_wakes() const { return wakes_.ignored_wakes(); }

  // Counts what it is woken for; to be read before looking at what there is to do.
  std::uint32_t wake_count() const { return cell_.word.load(std::memory_order_acquire); }
  // Until it is woken (its wake count is no longer `seen`) or `until` has come; not at all if a completion or
  // output that it asked for has come already. A controller that is woken without end sleeps all the same
  // (wake_budget.h).
  void sleep(std::uint32_t seen, TimePoint until);

 private:
  // --- driver::Actuator ---
  const Assignment& assignment() override { return controls_.board.read(number_); }
  std::optional<dispatch::RunState> take(SubchainId id) override;
  void hand_over(SubchainId id, const dispatch::RunState& state) override;
  void move(SubchainId id, const os::CpuSet& cpus) override;
  void set_level(SubchainId id, os::Level level) override;
  void set_levels(SubchainId id, const policy::SubchainPlace& place) override;
  bool threads_joined() override;
  void trigger(SubchainId id, std::uint64_t number, TimePoint due) override;
  std::uint64_t completed(SubchainId id) const override { return signal(id).completed.load(std::memory_order_seq_cst); }
  void await_completion(SubchainId id, bool wanted, std::uint64_t known) override;
  void begin_run(SubchainId id) override { clock_.begin(subchains_[id.index()]); }
  Nanos cpu_time(SubchainId id) override { return clock_.used(subchains_[id.index()]); }
  Outputs outputs(const plan::Leader& leader) const override;
  bool await_outputs(const plan::Leader& leader, std::uint64_t count) override;
  void ignore_outputs(const plan::Leader& leader) override { output_cell(leader).unsubscribe(number_); }
  std::optional<Ticks> clock(NodeId node) const override { return controls_.clocks.read(node); }
  void slot_over(const dispatch::SlotUse& slot) override;
  void stole(const dispatch::Steal& steal) override;
  void hang_changed(SubchainId id, bool began, TimePoint at) override;
  void over_budget(const dispatch::Overrun& overrun) override;

  static constexpr std::size_t kReports = 8192;
  static constexpr std::size_t kWords = 5;
  enum class Report : std::uint64_t { kTrigger, kHangBegan, kHangEnded, kOverBudget, kSlot, kSteal, kWokeLate };
  struct Held {
    SubchainId subchain;
    std::uint32_t joined = 0;  // threads, when they were counted last
  };

  bool of_core() const { return number_ >= subchains_.size(); }
  int core() const { return static_cast<int>(number_ - subchains_.size()); }
  SignalCell& signal(SubchainId id) const { return *subchains_[id.index()].signal; }
  OutputCell& output_cell(const plan::Leader& leader) const;
  std::uint32_t threads_joined(SubchainId id) const;
  void listen(SubchainId id) const;

  void report(Report kind, SubchainId id, std::uint64_t a, std::uint64_t b, std::uint64_t c);
  void deliver(std::span<const std::uint64_t> words, ReportSink& sink) const;

  Controls& controls_;
  const std::vector<SubchainLinks>& subchains_;  // by SubchainId
  std::size_t number_;
  ControllerCell& cell_;
  std::unique_ptr<driver::Controller> driver_;
  std::vector<Held> held_;
  RunClock clock_;           // of the one run at a time that it limits
  bool event_came_ = false;  // an end of a run or an output, between a decision and asking for it
  WordRing reports_;
  WakeBudget wakes_;
  std::atomic<bool> stopping_{false};
  std::atomic<std::uint64_t> steps_{0};
  std::atomic<std::uint64_t> steps_by_timer_{0};
};

}  // namespace ctn::runtime
