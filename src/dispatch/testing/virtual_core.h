// A core in virtual time, driven by the dispatcher of a shared core; for tests. Subchains' runs need given amounts of
// CPU time; which of them has the CPU is decided by os/fake/fake_cpus.h, from the levels that the dispatcher sets. An
// ordinary thread that is always busy takes what they leave. Subchains at the ordinary level get nothing: the worst
// that can happen to them.
//
// It records which thread ran when and all that the dispatcher decided, and throws a Breach where the dispatcher breaks
// its contract: two subchains active at once, a trigger while a run is under way, asking to be called at once again and
// again. Several cores can exchange subchains: what one has handed over is `adopt`ed by another.
//
// Units: Nanos from 0. Thread safety: none; one owner.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "dispatch/shared_core_dispatcher.h"
#include "os/fake/fake_cpus.h"

namespace ctn::dispatch {

struct Breach : std::logic_error {
  using std::logic_error::logic_error;
};

class VirtualCore {
 public:
  // CPU time of a subchain's run, by its number from 1.
  using Cost = std::function<Nanos(SubchainId, std::uint64_t)>;
  // How much later than asked for the dispatcher gets to its n-th call by a timer.
  using Lateness = std::function<Nanos(std::uint64_t)>;

  // A subchain's threads, as they are: they move from core to core with its runs.
  struct Threads {
    std::uint64_t sent = 0;
    std::uint64_t completed = 0;
    Nanos left{0};  // of the run under way
    MemberLevel level = MemberLevel::kOrdinary;
  };
  struct Ran {
    std::optional<SubchainId> subchain;  // none: the ordinary thread
    MemberLevel level = MemberLevel::kOrdinary;
    TimePoint begin{};
    TimePoint end{};
    friend bool operator==(const Ran&, const Ran&) = default;
  };
  struct Triggered {
    std::uint64_t number = 0;
    TimePoint due{};
    TimePoint sent{};
    friend bool operator==(const Triggered&, const Triggered&) = default;
  };
  struct Swap {
    TimePoint at{};
    std::vector<SubchainId> members;
  };

  VirtualCore(const SharedCoreSchedule& schedule, Cost cost, Lateness lateness = {})
      : dispatcher(TimePoint{}, schedule), cost_(std::move(cost)), lateness_(std::move(lateness)) {
    cpus_.add(kOrdinaryThread, os::Level::kOrdinary, kCpu);
    cpus_.consume(kOrdinaryThread, Nanos::max());
  }

  // With all members of the schedule, none of which ever ran.
  static VirtualCore with_all(const SharedCoreSchedule& schedule, Cost cost, Lateness lateness = {}) {
    VirtualCore core(schedule, std::move(cost), std::move(lateness));
    for (const SharedCoreSlot& slot : schedule.slots) core.adopt(slot.subchain, {}, {});
    return core;
  }

  void adopt(SubchainId subchain, const RunState& state, const Threads& with) {
    if (with.level != MemberLevel::kOrdinary) throw Breach("a subchain is handed over above the ordinary level");
    threads[subchain] = with;
    dispatcher.adopt(subchain, state);
    call_at_ = now;
  }

  void change_schedule(const SharedCoreSchedule& schedule) {
    dispatcher.change_schedule(schedule);
    call_at_ = now;
  }

  void run_until(TimePoint end) {
    while (true) {
      if (now >= call_at_) call();
      if (now >= end) return;
      cpus_.assign();
      pass(std::min({end, call_at_, now + *cpus_.next_event()}));
      if (const std::optional<os::ThreadId> ready = cpus_.ready()) finish_run(*subchain_of(*ready));
    }
  }
  void run_for(Nanos duration) { run_until(now + duration); }

  // Which threads had the CPU, in order.
  std::vector<Ran> trace() const {
    std::vector<Ran> trace;
    for (const os::FakeCpus::Stretch& stretch : cpus_.stretches()) trace.push_back(ran_in(stretch));
    return trace;
  }

  // CPU time in [begin, end), as recorded.
  Nanos cpu_time(std::optional<SubchainId> subchain, TimePoint begin, TimePoint end,
                 std::optional<MemberLevel> level = {}) const {
    Nanos sum{0};
    for (const os::FakeCpus::Stretch& stretch : cpus_.stretches()) {
      const Ran ran = ran_in(stretch);
      if (ran.subchain != subchain || (level && ran.level != *level)) continue;
      sum += std::max(Nanos{0}, std::min(ran.end, end) - std::max(ran.begin, begin));
    }
    return sum;
  }
  Nanos ordinary_time(TimePoint begin, TimePoint end) const { return cpu_time({}, begin, end); }

  // "0:4 .:1 1:2", in milliseconds: which subchain ran for how long, one after the other; "." is the ordinary thread,
  // "b" in front says that it was in the background.
  std::string timeline() const {
    std::string text;
    for (const Ran& ran : trace()) {
      if (!text.empty()) text += ' ';
      if (ran.subchain && ran.level == MemberLevel::kBackground) text += 'b';
      text += ran.subchain ? std::to_string(ran.subchain->index()) : ".";
      std::string length = std::to_string(to_millis(ran.end - ran.begin).count());
      length.erase(length.find_last_not_of('0') + 1);
      if (length.back() == '.') length.pop_back();
      text += ':' + length;
    }
    return text;
  }

  SharedCoreDispatcher dispatcher;
  TimePoint now{};
  std::map<SubchainId, Threads> threads;  // of those that are here
  std::map<SubchainId, std::vector<Triggered>> triggers;
  std::map<SubchainId, std::vector<TimePoint>> completions;
  std::vector<TimePoint> frames;  // when each began
  std::vector<SlotUse> slots;
  std::vector<Steal> steals;
  std::vector<std::pair<TimePoint, SharedCoreDispatcher::Hang>> hangs;
  std::vector<Swap> swaps;
  std::vector<std::pair<SubchainId, std::pair<RunState, Threads>>> handed_over;  // and not yet taken elsewhere
  std::uint64_t level_changes = 0;
  std::uint64_t calls = 0;

 private:
  static constexpr os::ThreadId kOrdinaryThread{0};
  static inline const os::CpuSet kCpu{0};

  static os::ThreadId thread_of(SubchainId subchain) {
    return os::ThreadId{static_cast<std::int32_t>(subchain.index()) + 1};
  }
  static std::optional<SubchainId> subchain_of(os::ThreadId thread) {
    if (thread == kOrdinaryThread) return std::nullopt;
    return SubchainId(static_cast<std::size_t>(static_cast<std::int32_t>(thread) - 1));
  }
  static os::Level level_of(MemberLevel level) {
    return level == MemberLevel::kActive ? os::Level::kActive : os::Level::kBackground;
  }
  static MemberLevel level_of(os::Level level) {
    if (level == os::Level::kOrdinary) return MemberLevel::kOrdinary;
    return level == os::Level::kActive ? MemberLevel::kActive : MemberLevel::kBackground;
  }

  static Ran ran_in(const os::FakeCpus::Stretch& stretch) {
    return {subchain_of(stretch.thread), level_of(stretch.level), stretch.begin, stretch.end};
  }

  // Those that compete for the CPU have a run under way and are raised.
  void compete(SubchainId subchain) {
    const Threads& each = threads.at(subchain);
    const os::ThreadId thread = thread_of(subchain);
    if (each.level == MemberLevel::kOrdinary || each.sent == each.completed) {
      cpus_.remove(thread);
    } else if (cpus_.has(thread)) {
      cpus_.set_level(thread, level_of(each.level));
    } else {
      cpus_.add(thread, level_of(each.level), kCpu);
      cpus_.consume(thread, each.left);
    }
  }

  void pass(TimePoint until) {
    if (until == now) return;
    for (const os::ThreadId thread : cpus_.pass(now, until - now)) {
      if (const std::optional<SubchainId> subchain = subchain_of(thread)) threads.at(*subchain).left -= until - now;
    }
    now = until;
  }

  void finish_run(SubchainId subchain) {
    ++threads.at(subchain).completed;
    compete(subchain);
    completions[subchain].push_back(now);
    if (wake_ == subchain) call_at_ = now;
  }

  // As a driver does it: again and again while that is asked for.
  void call() {
    constexpr int kMaxSwapsAtOnce = 3;
    for (int again = 0;; ++again) {
      if (again > kMaxSwapsAtOnce) throw Breach("the dispatcher asks for the present again and again");
      std::vector<std::uint64_t> completed;
      for (const SharedCoreSlot& slot : dispatcher.schedule().slots) {
        const auto found = threads.find(slot.subchain);
        completed.push_back(found == threads.end() ? 0 : found->second.completed);
      }
      ++calls;
      const SharedCoreDispatcher::Decision& decision = dispatcher.step(now, completed);
      apply(decision);
      wake_ = decision.wake_on_completion;
      call_at_ = decision.ask_at;
      if (call_at_ > now) break;
      if (!decision.swapped) throw Breach("the dispatcher asks for the present without a reason");
    }
    if (lateness_ && call_at_ != kNever) call_at_ += lateness_(calls);
  }

  void apply(const SharedCoreDispatcher::Decision& decision) {
    for (const SharedCoreDispatcher::LevelChange& change : decision.levels) {
      if (threads.at(change.subchain).level == change.level) throw Breach("a level change that changes nothing");
      threads.at(change.subchain).level = change.level;
      compete(change.subchain);
      ++level_changes;
      const auto active = std::count_if(threads.begin(), threads.end(),
                                        [](const auto& each) { return each.second.level == MemberLevel::kActive; });
      if (active > 1) throw Breach("two subchains are active at once");
    }
    for (const SharedCoreDispatcher::Trigger& trigger : decision.triggers) send(trigger);
    for (const SharedCoreDispatcher::HandOver& each : decision.handed_over) {
      handed_over.push_back({each.subchain, {each.state, threads.at(each.subchain)}});
      cpus_.remove(thread_of(each.subchain));
      threads.erase(each.subchain);
    }
    if (dispatcher.frames() != frames.size()) frames.push_back(now);
    steals.insert(steals.end(), decision.steals.begin(), decision.steals.end());
    slots.insert(slots.end(), decision.slots.begin(), decision.slots.end());
    for (const SharedCoreDispatcher::Hang& hang : decision.hangs) hangs.emplace_back(now, hang);
    if (decision.swapped) {
      swaps.push_back({now, {}});
      for (const auto& [subchain, each] : threads) swaps.back().members.push_back(subchain);
    }
  }

  void send(const SharedCoreDispatcher::Trigger& trigger) {
    Threads& each = threads.at(trigger.subchain);
    if (each.sent > each.completed) throw Breach("a trigger while a run is under way");
    if (trigger.number != each.sent + 1) throw Breach("triggers are not counted one by one");
    if (trigger.due > now) throw Breach("a trigger before it is due");
    ++each.sent;
    each.left = cost_(trigger.subchain, each.sent);
    compete(trigger.subchain);
    triggers[trigger.subchain].push_back({trigger.number, trigger.due, now});
  }

  Cost cost_;
  Lateness lateness_;
  os::FakeCpus cpus_;
  TimePoint call_at_{};
  std::optional<SubchainId> wake_;
};

}  // namespace ctn::dispatch
