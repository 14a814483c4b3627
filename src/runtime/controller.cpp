#include "runtime/controller.h"

#include <algorithm>
#include <span>
#include <utility>

#include "runtime/starvation.h"

namespace ctn::runtime {

Controller::Controller(Controls& controls, const std::vector<SubchainLinks>& subchains, std::size_t number, int core)
    : controls_(controls),
      subchains_(subchains),
      number_(number),
      core_(core),
      attention_(controls.region.attention(number)),
      threads_seen_(subchains.size(), 0),
      reports_(kReports, kWords) {}

void Controller::stop() {
  stopping_.store(true, std::memory_order_release);
  attention_.nudge(controls_.os);
}

void Controller::sleep(std::uint32_t seen, TimePoint until, bool awake) {
  const TimePoint asleep = now();
  if (!wakes_.take(asleep)) {
    controls_.os.sleep_until(std::min(until, asleep + WakeBudget::kDeaf));
    return;
  }
  if (awake || controls_.os.wait(attention_.word, seen, until) != os::WaitResult::kTimedOut) return;
  wakes_.give_back();
  const TimePoint woke = now();
  if (!woke_too_late(asleep, until, woke) || !controls_.enforcer.real_time()) return;
  const auto cpu = static_cast<std::uint64_t>(std::max(controls_.os.current_cpu(), 0));
  report(Report::kWokeLate, SubchainId{0}, cpu, to_word(std::max(asleep, until)), to_word(woke));
}

void Controller::trigger(SubchainId id, std::uint64_t number, TimePoint due) {
  // What has not begun has not ended, whatever is written there; else this run would count as ended at once.
  if (completed(id) >= number) signal(id).completed.store(number - 1, std::memory_order_seq_cst);
  subchains_[id.index()].nodes.front()->trigger(number);
  report(Report::kTrigger, id, number, to_word(due), to_word(now()));
}

void Controller::hold(SubchainId id, const os::CpuSet& cpus) {
  signal(id).listener.store(static_cast<std::uint32_t>(number_ + 1), std::memory_order_seq_cst);
  threads_joined(id);
  move_threads(id, cpus);
}

void Controller::move_threads(SubchainId id, const os::CpuSet& cpus) {
  for (const NodeLink* node : subchains_[id.index()].nodes) {
    node->for_each_thread([&](os::ThreadId thread) { controls_.enforcer.move_now(thread, cpus); });
  }
}

void Controller::set_level(SubchainId id, os::Level level) {
  for (const NodeLink* node : subchains_[id.index()].nodes) {
    node->for_each_thread([&](os::ThreadId thread) { controls_.enforcer.set_level_now(thread, level); });
  }
}

void Controller::set_levels(SubchainId id, const policy::SubchainPlace& place) {
  const std::vector<NodeLink*>& nodes = subchains_[id.index()].nodes;
  for (std::size_t position = 0; position < nodes.size(); ++position) {
    nodes[position]->for_each_thread(
        [&](os::ThreadId thread) { controls_.enforcer.set_level_now(thread, place.level_of(position)); });
  }
}

void Controller::hand_over(SubchainId id, const dispatch::RunState& state) {
  want_completions(id, false);
  controls_.handovers[id.index()].put(state);
  // A newer assignment than the one looked at here wakes everybody when it is published.
  controls_.nudge(controls_.holder_of(look().places[id.index()], id));
}

bool Controller::threads_joined(SubchainId id) {
  std::uint32_t joined = 0;
  for (const NodeLink* node : subchains_[id.index()].nodes) joined += node->threads_joined();
  return std::exchange(threads_seen_[id.index()], joined) != joined;
}

// --- Reports ---

void Controller::report(Report kind, SubchainId id, std::uint64_t a, std::uint64_t b, std::uint64_t c) {
  const std::array<std::uint64_t, kWords> words{static_cast<std::uint64_t>(kind), id.index(), a, b, c};
  reports_.push(words);
}

void Controller::report_hang(SubchainId id, bool began, TimePoint at) {
  report(began ? Report::kHangBegan : Report::kHangEnded, id, to_word(at), 0, 0);
}

void Controller::report_slot(SubchainId id, TimePoint planned, TimePoint begin, TimePoint end) {
  report(Report::kSlot, id, to_word(planned), to_word(begin), to_word(end));
}

void Controller::report_steal(SubchainId thief, SubchainId victim, TimePoint begin, TimePoint end) {
  report(Report::kSteal, thief, victim.index(), to_word(begin), to_word(end));
}

void Controller::drain(ReportSink& sink) {
  reports_.drain([&](std::span<const std::uint64_t> words) { deliver(words, sink); });
}

void Controller::deliver(std::span<const std::uint64_t> words, ReportSink& sink) const {
  const SubchainId id{static_cast<std::size_t>(words[1])};
  switch (static_cast<Report>(words[0])) {
    case Report::kTrigger:
      return sink.triggered({id, words[2], to_time(words[3]), to_time(words[4])});
    case Report::kHangBegan:
    case Report::kHangEnded:
      return sink.hang_changed(id, static_cast<Report>(words[0]) == Report::kHangBegan, to_time(words[2]));
    case Report::kSlot:
      return sink.slot_over({core_, id, to_time(words[2]), to_time(words[3]), to_time(words[4])});
    case Report::kWokeLate:
      return sink.woke_late(static_cast<int>(words[2]), to_time(words[3]), to_time(words[4]));
    case Report::kSteal:
      return sink.stole(
          {core_, id, SubchainId{static_cast<std::size_t>(words[2])}, to_time(words[3]), to_time(words[4])});
  }
}

}  // namespace ctn::runtime
