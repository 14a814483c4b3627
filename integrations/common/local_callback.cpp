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
  bool wait() override { return runs_.wait(); }
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
  BoundCallback(callback_options(binding()), inbox_, turn).run(schedule);
}

void LocalCallback::bind() {
  const std::lock_guard lock(mutex_);
  bound_ = true;
  for (Sent& sent : sent_) {
    if (const Message kept = std::exchange(sent.kept, nullptr)) put(kept);
  }
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
  const bool called = sent->called;
  sent->delivered = true;
  if (!bound_ && !called) sent->kept = message;
  if (sent->arrived) sent_.erase(sent);
  if (bound_ && !called) put(message);
}

bool LocalCallback::arrive_at_node(const Message& message) {
  const std::lock_guard lock(mutex_);
  const auto sent = find(message.get());
  if (sent == sent_.end()) {
    if (bound_) put(message);
    return bound_;
  }
  sent->arrived = true;
  sent->called = !bound_;
  if (sent->delivered) sent_.erase(sent);
  return bound_;
}

void LocalCallback::arrived(const Message& message) {
  if (arrive_at_node(message)) return;
  const std::lock_guard lock(calling_);
  if (!inbox_.stopped().load()) call_(message);
}

void LocalCallback::put(const Message& message) {
  binding().takes_all ? inbox_.put(entry_of(message)) : inbox_.put_alone(entry_of(message));
}

Inbox::Entry LocalCallback::entry_of(const Message& message) {
  return {0, [this, message] {
            note_taken(MessageRuns::key_of_address(binding().name, message.get()));
            call_(message);
            return Outcome::kCalled;
          }};
}

void LocalCallback::note_published(const std::string& topic) {
  if (binding().gives_output_on(topic)) BoundCallback::current()->note_output();
}

}  // namespace catan_ros
