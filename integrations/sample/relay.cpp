#include "relay.h"

#include <algorithm>
#include <utility>

namespace relay {
namespace {

// How long a thread that waits for a message may take to notice stop().
constexpr std::chrono::milliseconds kLook{20};

}  // namespace

Executor::~Executor() { stop(); }

void Executor::add(Component component) {
  auto actor = std::make_unique<Actor>();
  for (const Subscription& subscription : component.subscriptions) actor->inboxes.push_back({subscription, {}});
  actor->component = std::move(component);
  actors_.push_back(std::move(actor));
}

void Executor::spin() {
  for (const auto& actor : actors_) actor->thread = std::thread([this, &actor] { run(*actor); });
  for (const auto& actor : actors_) actor->thread.join();
}

void Executor::run(Actor& actor) {
  const std::unique_ptr<Pacing> pacing = hook_ != nullptr ? hook_->thread_begins(actor.component) : nullptr;
  if (hook_ != nullptr && !pacing) return;
  if (actor.component.has_helper) actor.helper = std::thread([this, &actor] { run_helper(actor); });
  auto due = std::chrono::steady_clock::now();
  while (pacing && pacing->paces() ? pacing->wait() : wait(actor, due)) {
    if (pacing) pacing->begin();
    const bool published = call(actor);
    if (pacing) pacing->end(published);
  }
  end_helper(actor);
}

// For a message or the timer. False: stopped.
bool Executor::wait(Actor& actor, std::chrono::steady_clock::time_point& due) {
  std::unique_lock lock(actor.mutex);
  const auto has_message = [&] {
    return std::any_of(actor.inboxes.begin(), actor.inboxes.end(), [](const Inbox& i) { return !i.messages.empty(); });
  };
  if (actor.component.timer) due = std::max(due + *actor.component.timer, std::chrono::steady_clock::now());
  while (!stopping()) {
    const auto now = std::chrono::steady_clock::now();
    if (actor.component.timer ? now >= due : has_message()) return true;
    actor.arrived.wait_until(lock, actor.component.timer ? std::min(due, now + kLook) : now + kLook);
  }
  return false;
}

// Whether it published anything.
bool Executor::call(Actor& actor) {
  Call call(actor);
  {
    const std::lock_guard lock(actor.mutex);
    for (Inbox& inbox : actor.inboxes) {
      call.taken_.push_back({inbox.subscription.topic, {inbox.messages.begin(), inbox.messages.end()}});
      inbox.messages.clear();
    }
  }
  actor.component.callback(call);
  for (const Message message : call.published_) deliver(actor.component.publishes, message);
  return !call.published_.empty();
}

void Executor::deliver(const std::string& topic, Message message) {
  for (const auto& actor : actors_) {
    const std::lock_guard lock(actor->mutex);
    for (Inbox& inbox : actor->inboxes) {
      if (inbox.subscription.topic != topic) continue;
      if (inbox.subscription.keep == Keep::kNewest) inbox.messages.clear();
      inbox.messages.push_back(message);
      actor->arrived.notify_one();
    }
  }
}

void Executor::run_helper(Actor& actor) {
  if (hook_ != nullptr) hook_->thread_helps(actor.component);
  std::unique_lock lock(actor.help_mutex);
  for (;;) {
    actor.help_changed.wait(lock, [&] { return actor.help || actor.helper_ends; });
    if (!actor.help) return;
    actor.help();
    actor.help = nullptr;
    actor.help_changed.notify_all();
  }
}

void Executor::end_helper(Actor& actor) {
  if (!actor.helper.joinable()) return;
  {
    const std::lock_guard lock(actor.help_mutex);
    actor.helper_ends = true;
  }
  actor.help_changed.notify_all();
  actor.helper.join();
}

std::vector<Message> Call::take(const std::string& topic) const {
  for (const Taken& taken : taken_) {
    if (taken.topic == topic) return taken.messages;
  }
  return {};
}

void Call::help(std::function<void()> work) {
  std::unique_lock lock(actor_.help_mutex);
  actor_.help = std::move(work);
  actor_.help_changed.notify_all();
  actor_.help_changed.wait(lock, [&] { return !actor_.help; });
}

}  // namespace relay
