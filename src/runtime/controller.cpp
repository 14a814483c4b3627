#include "runtime/controller.h"

#include <span>

namespace ctn::runtime {
namespace {

std::uint64_t encode(TimePoint time) { return static_cast<std::uint64_t>(time.time_since_epoch().count()); }
TimePoint decode(std::uint64_t word) { return TimePoint{Nanos{static_cast<Nanos::rep>(word)}}; }

}  // namespace

Controller::Controller(Controls& controls, const std::vector<SubchainPorts>& subchains, std::size_t reader, int core,
                       Attention& attention)
    : controls_(controls),
      subchains_(subchains),
      reader_(reader),
      core_(core),
      attention_(attention),
      threads_seen_(subchains.size(), 0),
      reports_(kReports, kWords) {}

void Controller::stop() {
  stopping_.store(true, std::memory_order_release);
  attention_.nudge(controls_.os);
}

void Controller::trigger(SubchainId id, std::uint64_t number, TimePoint due) {
  subchains_[id.index()].ports.front()->trigger(number);
  report(Report::kTrigger, id, number, encode(due), encode(now()));
}

void Controller::hold(SubchainId id, const os::CpuSet& cpus) {
  signal(id).listener.store(&attention_, std::memory_order_seq_cst);
  threads_joined(id);
  move_threads(id, cpus);
}

void Controller::move_threads(SubchainId id, const os::CpuSet& cpus) {
  for (const NodePort* port : subchains_[id.index()].ports) {
    port->for_each_thread([&](os::ThreadId thread) { controls_.enforcer.move_now(thread, cpus); });
  }
}

void Controller::set_level(SubchainId id, os::Level level) {
  for (const NodePort* port : subchains_[id.index()].ports) {
    port->for_each_thread([&](os::ThreadId thread) { controls_.enforcer.set_level_now(thread, level); });
  }
}

void Controller::hand_over(SubchainId id, const dispatch::RunState& state) {
  want_completions(id, false);
  controls_.handovers[id.index()].put(state);
  // A newer assignment than the one looked at here wakes everybody when it is published.
  controls_.attention_of(look().places[id.index()], id).nudge(controls_.os);
}

bool Controller::threads_joined(SubchainId id) {
  const std::uint32_t joined = signal(id).threads_joined.load(std::memory_order_acquire);
  return std::exchange(threads_seen_[id.index()], joined) != joined;
}

// --- Reports ---

void Controller::report(Report kind, SubchainId id, std::uint64_t a, std::uint64_t b, std::uint64_t c) {
  const std::array<std::uint64_t, kWords> words{static_cast<std::uint64_t>(kind), id.index(), a, b, c};
  reports_.push(words);
}

void Controller::report_hang(SubchainId id, bool began, TimePoint at) {
  report(began ? Report::kHangBegan : Report::kHangEnded, id, encode(at), 0, 0);
}

void Controller::report_slot(SubchainId id, TimePoint planned, TimePoint begin, TimePoint end) {
  report(Report::kSlot, id, encode(planned), encode(begin), encode(end));
}

void Controller::report_steal(SubchainId thief, SubchainId victim, TimePoint begin, TimePoint end) {
  report(Report::kSteal, thief, victim.index(), encode(begin), encode(end));
}

void Controller::drain(ReportSink& sink) {
  reports_.drain([&](std::span<const std::uint64_t> words) { deliver(words, sink); });
}

void Controller::deliver(std::span<const std::uint64_t> words, ReportSink& sink) const {
  const SubchainId id{static_cast<std::size_t>(words[1])};
  switch (static_cast<Report>(words[0])) {
    case Report::kTrigger:
      return sink.triggered({id, words[2], decode(words[3]), decode(words[4])});
    case Report::kHangBegan:
    case Report::kHangEnded:
      return sink.hang_changed(id, static_cast<Report>(words[0]) == Report::kHangBegan);
    case Report::kSlot:
      return sink.slot_over({core_, id, decode(words[2]), decode(words[3]), decode(words[4])});
    case Report::kSteal:
      return sink.stole(
          {core_, id, SubchainId{static_cast<std::size_t>(words[2])}, decode(words[3]), decode(words[4])});
  }
}

}  // namespace ctn::runtime
