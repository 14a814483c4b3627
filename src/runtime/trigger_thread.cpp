#include "runtime/trigger_thread.h"

#include <array>
#include <utility>

namespace ctn::runtime {
namespace {

constexpr std::size_t kPacings = 16;
constexpr std::size_t kPacingWords = 5;

std::array<std::uint64_t, kPacingWords> encode(const dispatch::Pacing& pacing) {
  return {static_cast<std::uint64_t>(pacing.period.count()), static_cast<std::uint64_t>(pacing.in_flight_limit),
          static_cast<std::uint64_t>(pacing.hang_after.count()),
          static_cast<std::uint64_t>(pacing.after_completion.count()),
          static_cast<std::uint64_t>(pacing.shortest.count())};
}

dispatch::Pacing decode(std::span<const std::uint64_t> words) {
  return {.period = Nanos{static_cast<Nanos::rep>(words[0])},
          .in_flight_limit = static_cast<int>(words[1]),
          .hang_after = Nanos{static_cast<Nanos::rep>(words[2])},
          .after_completion = Nanos{static_cast<Nanos::rep>(words[3])},
          .shortest = Nanos{static_cast<Nanos::rep>(words[4])}};
}

}  // namespace

TriggerThread::TriggerThread(os::Os& os, SubchainId subchain, std::vector<NodePort*> ports, SubchainSignal& signal,
                             Enforcer& enforcer, const dispatch::Pacing& initial)
    : os_(os),
      subchain_(subchain),
      ports_(std::move(ports)),
      signal_(signal),
      enforcer_(enforcer),
      initial_(initial),
      pacings_(kPacings, kPacingWords),
      reports_(kReports, 3) {}

void TriggerThread::run() {
  dispatch::SubchainTrigger trigger(os_.now(), initial_);
  while (!stopping_.load(std::memory_order_acquire)) {
    const std::uint32_t seen = signal_.attention.load(std::memory_order_acquire);
    adopt_new_pacing(trigger);
    const std::uint64_t completed = signal_.completed.load(std::memory_order_seq_cst);
    const TimePoint now = os_.now();
    const dispatch::SubchainTrigger::Decision decision = trigger.step(now, completed);
    act(decision, now, trigger.sent());

    signal_.wants_completions.store(decision.ask_on_completion, std::memory_order_seq_cst);
    if (decision.ask_on_completion && signal_.completed.load(std::memory_order_seq_cst) != completed) continue;
    os_.wait(signal_.attention, seen, decision.ask_at);
  }
}

void TriggerThread::stop() {
  stopping_.store(true, std::memory_order_release);
  signal_.nudge(os_);
}

void TriggerThread::change_pacing(const dispatch::Pacing& pacing) {
  // A full ring means that the thread has not looked for long; it will look at the next one.
  pacings_.push(encode(pacing));
  signal_.nudge(os_);
}

void TriggerThread::adopt_new_pacing(dispatch::SubchainTrigger& trigger) {
  pacings_.drain([&](std::span<const std::uint64_t> words) { trigger.change_pacing(os_.now(), decode(words)); });
}

void TriggerThread::act(const dispatch::SubchainTrigger::Decision& decision, TimePoint now, std::uint64_t number) {
  if (decision.hang_began || decision.hang_ended) {
    contain(decision.hang_began);
    report(decision.hang_began ? kHangBegan : kHangEnded, now, now);
  }
  if (decision.trigger) {
    ports_.front()->trigger(number);
    report(number, *decision.trigger, now);
  }
}

void TriggerThread::contain(bool hanging) {
  const os::Level level = hanging ? os::Level::kOrdinary : os::Level::kActive;
  for (const NodePort* port : ports_) {
    for (const os::ThreadId thread : port->threads()) enforcer_.set_level_now(thread, level);
  }
}

void TriggerThread::report(std::uint64_t what, TimePoint due, TimePoint sent) {
  const std::array<std::uint64_t, 3> words{what, static_cast<std::uint64_t>(due.time_since_epoch().count()),
                                           static_cast<std::uint64_t>(sent.time_since_epoch().count())};
  reports_.push(words);
}

}  // namespace ctn::runtime
