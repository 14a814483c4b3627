#include "common/local_callback.h"

#include <algorithm>
#include <chrono>
#include <mutex>
#include <utility>

#include "common/bound_callback.h"

namespace catan_ros {
namespace {

BoundCallbackOptions callback_options(const Binding& binding) {
  BoundCallbackOptions options;
  options.takes_all = binding.takes_all;
  options.runs_by_itself = binding.runs_by_itself;
  options.always_gives_output = binding.always_gives_output;
  // Who triggers it has given its message before: there is none that is still on its way.
  options.patience = std::chrono::nanoseconds{0};
  return options;
}

}  // namespace

// The framework never calls a callback twice at the same time.
class LocalCallback::OneAtATime final : public Turn {
 public:
  explicit OneAtATime(PriorityMutex& mutex) : mutex_(mutex) {}
  bool take(const std::atomic<bool>& stop) override {
    mutex_.lock();
    if (!stop.load()) return true;
    mutex_.unlock();
    return false;
  }
  void give_back() override { mutex_.unlock(); }

 private:
  PriorityMutex& mutex_;
};

class LocalCallback::NotingRuns final : public Schedule {
 public:
  NotingRuns(Runs& runs, LocalCallback& owner) : runs_(runs), owner_(owner) {}
  ctn::Awaited await() override { return runs_.await(); }
  bool await_complete() override { return runs_.await_complete(); }
  void begin() override { owner_.begin(runs_); }
  void end(bool output) override { owner_.end(output); }

 private:
  Runs& runs_;
  LocalCallback& owner_;
};

LocalCallback::LocalCallback(Binding binding, MessageRuns& message_runs, Attach attach, Call call)
    : LocalNode(std::move(binding), message_runs), attach_(std::move(attach)), call_(std::move(call)) {}

void LocalCallback::start() {
  if (!thread_.joinable()) thread_ = std::thread([this] { run(); });
}

void LocalCallback::stop() {
  inbox_.stop();
  if (thread_.joinable()) thread_.join();
}

void LocalCallback::run() {
  const std::unique_ptr<Runs> runs = attach_(inbox_.stopped());
  if (!runs) return;
  bind();
  NotingRuns schedule(*runs, *this);
  OneAtATime turn(calling_);
  BoundCallback callback(callback_options(binding()), inbox_, turn);
  callback.set_let_go([&] { let_go(callback, turn); }, [this] { bind(); });
  callback.run(schedule);
}

// Those that the framework's thread called before have returned then.
void LocalCallback::bind() {
  {
    const std::lock_guard lock(mutex_);
    bound_ = true;
    for (Sent& sent : sent_) {
      const Message kept = std::exchange(sent.kept, nullptr);
      if (!kept) continue;
      sent.handled = true;
      put(kept);
    }
  }
  unbound_.wait_for_ends(inbox_.stopped());
}

// What has come is called first, by this thread.
void LocalCallback::let_go(BoundCallback& callback, Turn& turn) {
  if (!turn.take(inbox_.stopped())) return;
  {
    const std::lock_guard lock(mutex_);
    bound_ = false;
  }
  callback.call_rest();
  turn.give_back();
}

std::vector<LocalCallback::Sent>::iterator LocalCallback::find(const void* address) {
  return std::find_if(sent_.begin(), sent_.end(), [&](const Sent& sent) { return sent.address == address; });
}

void LocalCallback::expect(const void* message) {
  const std::lock_guard lock(mutex_);
  sent_.push_back({message, nullptr});
}

// Of what was not expected, the framework's thread takes care.
void LocalCallback::deliver(const Message& message) {
  const std::lock_guard lock(mutex_);
  const auto sent = find(message.get());
  if (sent == sent_.end()) return;
  sent->delivered = true;
  if (!sent->handled && bound_) {
    sent->handled = true;
    put(message);
  } else if (!sent->handled) {
    sent->kept = message;
  }
  if (sent->arrived) sent_.erase(sent);
}

bool LocalCallback::arrive_at_node(const Message& message) {
  const std::lock_guard lock(mutex_);
  const auto sent = find(message.get());
  bool handled = false;
  if (sent != sent_.end()) {
    sent->arrived = true;
    handled = std::exchange(sent->handled, true);
    sent->kept = nullptr;
    if (sent->delivered) sent_.erase(sent);
  }
  if (handled) return true;
  bound_ ? put(message) : unbound_.begin();
  return bound_;
}

void LocalCallback::arrived(const Message& message) {
  if (arrive_at_node(message)) return;
  const UnboundCalls::Ended at_end(unbound_);
  const std::lock_guard lock(calling_);
  if (!inbox_.stopped().load()) call_(message);
}

void LocalCallback::put(const Message& message) {
  binding().takes_all ? inbox_.put(entry_of(message)) : inbox_.put_alone(entry_of(message));
}

Inbox::Entry LocalCallback::entry_of(const Message& message) {
  return {0, [this, message] {
            if (in_run()) note_taken(MessageRuns::key_of_address(binding().name, message.get()));
            call_(message);
            return Outcome::kCalled;
          }};
}

void LocalCallback::note_published(const std::string& topic) {
  if (binding().gives_output_on(topic)) BoundCallback::current()->note_output();
}

}  // namespace catan_ros
