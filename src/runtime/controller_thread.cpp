#include "runtime/controller_thread.h"

#include <algorithm>
#include <span>
#include <utility>

#include "driver/core_driver.h"
#include "driver/subchain_pacer.h"
#include "runtime/starvation.h"

namespace ctn::runtime {

ControllerThread::ControllerThread(Controls& controls, const std::vector<SubchainLinks>& subchains, std::size_t number)
    : controls_(controls),
      subchains_(subchains),
      number_(number),
      cell_(controls.region.controller_cell(number)),
      reports_(kReports, kWords) {
  held_.reserve(subchains.size());
  if (of_core()) {
    driver_ = std::make_unique<driver::CoreDriver>(*this, core(), subchains.size());
  } else {
    driver_ = std::make_unique<driver::SubchainPacer>(*this, SubchainId(number));
  }
}

void ControllerThread::run() {
  for (;;) {
    // Before it looks whether to stop: the thread that stops it counts a wake after saying so.
    const std::uint32_t seen = wake_count();
    if (stopping_.load(std::memory_order_acquire)) return;
    const TimePoint until = driver_->step(controls_.os.now());
    steps_.fetch_add(1, std::memory_order_relaxed);
    sleep(seen, until);
  }
}

void ControllerThread::stop() {
  stopping_.store(true, std::memory_order_release);
  cell_.wake(controls_.os);
}

void ControllerThread::sleep(std::uint32_t seen, TimePoint until) {
  const bool awake = std::exchange(event_came_, false);
  const TimePoint asleep = controls_.os.now();
  if (!wakes_.take(asleep)) {
    controls_.os.sleep_until(std::min(until, asleep + WakeBudget::kPause));
    return;
  }
  if (awake || controls_.os.wait(cell_.word, seen, until) != os::WaitResult::kTimedOut) return;
  steps_by_timer_.fetch_add(1, std::memory_order_relaxed);
  wakes_.refund();
  const TimePoint woke = controls_.os.now();
  if (!woke_too_late(asleep, until, woke) || !controls_.enforcer.real_time()) return;
  const auto cpu = static_cast<std::uint64_t>(std::max(controls_.os.current_cpu(), 0));
  report(Report::kWokeLate, SubchainId{0}, cpu, to_word(std::max(asleep, until)), to_word(woke));
}

// --- Which controller has which subchain ---

std::optional<dispatch::RunState> ControllerThread::take(SubchainId id) {
  const std::optional<dispatch::RunState> state = controls_.handovers[id.index()].take();
  if (!state) return std::nullopt;
  listen(id);
  held_.push_back({id, threads_joined(id)});
  return state;
}

void ControllerThread::hand_over(SubchainId id, const dispatch::RunState& state) {
  await_completion(id, false, 0);
  std::erase_if(held_, [&](const Held& each) { return each.subchain == id; });
  controls_.handovers[id.index()].put(state);
  // A newer assignment than the one looked at here wakes all controllers when it is published.
  controls_.wake(driver::holder_of(id, assignment().places[id.index()], subchains_.size()));
}

// --- Threads ---

void ControllerThread::move(SubchainId id, const os::CpuSet& cpus) {
  for (const NodeLink* node : subchains_[id.index()].nodes) {
    node->for_each_thread([&](os::ThreadId thread) { controls_.enforcer.move_now(thread, cpus); });
  }
}

void ControllerThread::set_level(SubchainId id, os::Level level) {
  for (const NodeLink* node : subchains_[id.index()].nodes) {
    node->for_each_thread([&](os::ThreadId thread) { controls_.enforcer.set_level_now(thread, level); });
  }
}

void ControllerThread::set_levels(SubchainId id, const policy::SubchainPlace& place) {
  const std::vector<NodeLink*>& nodes = subchains_[id.index()].nodes;
  for (std::size_t position = 0; position < nodes.size(); ++position) {
    nodes[position]->for_each_thread(
        [&](os::ThreadId thread) { controls_.enforcer.set_level_now(thread, place.level_of(position)); });
  }
}

std::uint32_t ControllerThread::threads_joined(SubchainId id) const {
  std::uint32_t joined = 0;
  for (const NodeLink* node : subchains_[id.index()].nodes) joined += node->threads_joined();
  return joined;
}

bool ControllerThread::threads_joined() {
  bool any = false;
  for (Held& held : held_) {
    const std::uint32_t joined = threads_joined(held.subchain);
    any = any || joined != held.joined;
    held.joined = joined;
  }
  return any;
}

// --- Runs ---

void ControllerThread::trigger(SubchainId id, std::uint64_t number, TimePoint due) {
  subchains_[id.index()].trigger(number);
  report(Report::kTrigger, id, number, to_word(due), to_word(controls_.os.now()));
}

void ControllerThread::listen(SubchainId id) const {
  signal(id).holder.store(static_cast<std::uint32_t>(number_ + 1), std::memory_order_seq_cst);
}

void ControllerThread::await_completion(SubchainId id, bool wanted, std::uint64_t known) {
  // Writes the holder again, since other processes may have overwritten it.
  if (wanted) listen(id);
  signal(id).wants_completions.store(wanted ? 1 : 0, std::memory_order_seq_cst);
  if (wanted && completed(id) != known) event_came_ = true;
}

OutputCell& ControllerThread::output_cell(const plan::Leader& leader) const {
  if (const SubchainId* const subchain = std::get_if<SubchainId>(&leader)) return signal(*subchain);
  return controls_.region.node(std::get<NodeId>(leader)).led;
}

ControllerThread::Outputs ControllerThread::outputs(const plan::Leader& leader) const {
  const OutputCell& cell = output_cell(leader);
  const std::uint64_t count = cell.outputs.load(std::memory_order_seq_cst);
  return {count, to_time(static_cast<std::uint64_t>(cell.newest_output.load(std::memory_order_relaxed)))};
}

bool ControllerThread::await_outputs(const plan::Leader& leader, std::uint64_t count) {
  const bool has_room = output_cell(leader).subscribe(number_, count);
  // Counts that are not true may wrap around.
  if (static_cast<std::int64_t>(outputs(leader).count - count) >= 0) event_came_ = true;
  return has_room;
}

// --- Reports ---

void ControllerThread::report(Report kind, SubchainId id, std::uint64_t a, std::uint64_t b, std::uint64_t c) {
  const std::array<std::uint64_t, kWords> words{static_cast<std::uint64_t>(kind), id.index(), a, b, c};
  reports_.push(words);
}

void ControllerThread::slot_over(const dispatch::SlotUse& slot) {
  report(Report::kSlot, slot.subchain, to_word(slot.planned), to_word(slot.begin), to_word(slot.end));
}

void ControllerThread::stole(const dispatch::Steal& steal) {
  report(Report::kSteal, steal.thief, steal.victim.index(), to_word(steal.begin), to_word(steal.end));
}

void ControllerThread::hang_changed(SubchainId id, bool began, TimePoint at) {
  report(began ? Report::kHangBegan : Report::kHangEnded, id, to_word(at), 0, 0);
}

void ControllerThread::over_budget(const dispatch::Overrun& overrun) {
  report(Report::kOverBudget, overrun.subchain, overrun.number, to_word(overrun.at),
         static_cast<std::uint64_t>(overrun.cpu.count()));
}

void ControllerThread::drain(ReportSink& sink) {
  reports_.drain([&](std::span<const std::uint64_t> words) { deliver(words, sink); });
}

void ControllerThread::deliver(std::span<const std::uint64_t> words, ReportSink& sink) const {
  const SubchainId id{static_cast<std::size_t>(words[1])};
  switch (static_cast<Report>(words[0])) {
    case Report::kTrigger:
      return sink.triggered({id, words[2], to_time(words[3]), to_time(words[4])});
    case Report::kHangBegan:
    case Report::kHangEnded:
      return sink.hang_changed(id, static_cast<Report>(words[0]) == Report::kHangBegan, to_time(words[2]));
    case Report::kOverBudget:
      return sink.over_budget({id, words[2], to_time(words[3]), Nanos{static_cast<Nanos::rep>(words[4])}});
    case Report::kSlot:
      return sink.slot_over({core(), id, to_time(words[2]), to_time(words[3]), to_time(words[4])});
    case Report::kSteal:
      return sink.stole(
          {core(), id, SubchainId{static_cast<std::size_t>(words[2])}, to_time(words[3]), to_time(words[4])});
    case Report::kWokeLate:
      return sink.woke_late(static_cast<int>(words[2]), to_time(words[3]), to_time(words[4]));
  }
}

}  // namespace ctn::runtime
