#include "common/bound_callback.h"

#include <thread>
#include <utility>

namespace catan_ros {
namespace {

thread_local BoundCallback* t_current = nullptr;
thread_local bool t_discarding = false;

// While another thread is in the callback.
constexpr std::chrono::milliseconds kBetweenTries{1};
constexpr int kMaxTries = 100;

}  // namespace

BoundCallback* BoundCallback::current() { return t_current; }

bool BoundCallback::discarding() { return t_discarding; }
BoundCallback::Discard::Discard() { t_discarding = true; }
BoundCallback::Discard::~Discard() { t_discarding = false; }

void BoundCallback::run(Schedule& schedule) {
  while (!inbox_.stopped()) {
    const ctn::Awaited awaited = schedule.await();
    if (awaited == ctn::Awaited::kStopped) return;
    const bool goes_on = awaited == ctn::Awaited::kTrigger ? run_once(schedule) : go_without(schedule);
    if (!goes_on) return;
  }
}

// False: it was stopped.
bool BoundCallback::run_once(Schedule& schedule) {
  const bool has_message = wait_for_message();
  if (has_message) wait_for_newer_message();
  if (inbox_.stopped()) return false;
  if (!has_message && !without_message_) {
    schedule.begin();
    schedule.end(false);
    return true;
  }
  if (!turn_.take(inbox_.stopped())) return false;
  schedule.begin();
  output_ = false;
  t_current = this;
  const int calls = call_waiting();
  t_current = nullptr;
  schedule.end(calls > 0 && (output_ || options_.always_gives_output));
  turn_.give_back();
  if (calls > 0 && after_call_) after_call_();
  return true;
}

bool BoundCallback::go_without(Schedule& schedule) {
  if (let_go_) let_go_();
  if (!schedule.await_complete()) return false;
  if (take_back_) take_back_();
  return true;
}

void BoundCallback::call_rest() {
  for (std::size_t waiting = inbox_.size(); waiting > 0 && !inbox_.stopped(); --waiting) call_one();
}

void BoundCallback::let_go_of_older() {
  if (!options_.takes_newest) return;
  const Discard discard;
  for (;;) {
    const std::optional<Outcome> outcome = inbox_.call_first_beyond(1);
    if (!outcome || *outcome == Outcome::kAgain) return;
  }
}

bool BoundCallback::wait_for_message() {
  if (look_for_messages_) look_for_messages_();
  if (options_.runs_by_itself) return inbox_.wait(std::nullopt);
  return without_message_ ? inbox_.size() > 0 : inbox_.wait(options_.patience);
}

void BoundCallback::wait_for_newer_message() {
  if (!options_.takes_newest || options_.runs_by_itself || !newest_sent_) return;
  if (const std::optional<Time> sent = newest_sent_()) inbox_.wait_for_newer(*sent, options_.newer_patience);
}

void BoundCallback::discard_older() {
  const Discard discard;
  while (inbox_.size() > 1) {
    if (inbox_.call_first() == Outcome::kAgain) return;
  }
}

// How often the program's code was called.
int BoundCallback::call_waiting() {
  int calls = 0;
  if (options_.takes_newest) discard_older();
  std::size_t waiting = options_.takes_all ? inbox_.size() : 1;
  for (; waiting > 0 && inbox_.size() > 0; --waiting) calls += call_one() ? 1 : 0;
  if (calls > 0 || !without_message_) return calls;
  return inbox_.call_without_entry(without_message_) ? 1 : 0;
}

// Whether the program's code was called. What was removed meanwhile is not.
bool BoundCallback::call_one() {
  for (int tries = 0; tries < kMaxTries; ++tries) {
    const std::optional<Outcome> outcome = inbox_.call_first();
    if (outcome != Outcome::kAgain) return outcome == Outcome::kCalled;
    std::this_thread::sleep_for(kBetweenTries);
  }
  return false;
}

}  // namespace catan_ros
