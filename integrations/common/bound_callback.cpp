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
  while (!inbox_.stopped() && schedule.wait()) {
    const bool has_message = wait_for_message();
    if (has_message) wait_for_newer_message();
    if (inbox_.stopped()) return;
    if (!has_message && !without_message_) {
      schedule.begin();
      schedule.end(false);
      continue;
    }
    if (!turn_.take(inbox_.stopped())) return;
    schedule.begin();
    output_ = false;
    t_current = this;
    const int calls = call_waiting();
    t_current = nullptr;
    schedule.end(calls > 0 && (output_ || options_.always_gives_output));
    turn_.give_back();
  }
}

bool BoundCallback::wait_for_message() {
  if (look_for_messages_) look_for_messages_();
  if (options_.runs_by_itself) return inbox_.wait(std::nullopt);
  return without_message_ ? inbox_.size() > 0 : inbox_.wait(options_.patience);
}

// Of several messages that lie there the newest may be that one: whether it is, frameworks that keep no more do not
// tell.
void BoundCallback::wait_for_newer_message() {
  if (!options_.takes_newest || options_.runs_by_itself || !newest_sent_ || inbox_.size() != 1) return;
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
