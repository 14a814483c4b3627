#include "common/executor_callback.h"

#include <chrono>
#include <mutex>
#include <utility>

#include "common/bound_callback.h"
#include "common/thrown.h"

namespace catan_ros {
namespace {

constexpr std::chrono::seconds kWaitToSettle{1};
constexpr std::chrono::milliseconds kLookForEnd{50};

std::int64_t system_now() {
  return std::chrono::nanoseconds(std::chrono::system_clock::now().time_since_epoch()).count();
}

BoundCallbackOptions executor_options(const Binding& binding) {
  BoundCallbackOptions options;
  options.takes_all = binding.handles_all();
  options.runs_by_itself = binding.runs_by_itself;
  options.always_gives_output = binding.gives_output_unseen();
  return options;
}

}  // namespace

class ExecutorCallback::GroupTurn final : public Turn {
 public:
  explicit GroupTurn(ExecutorCallback& owner) : owner_(owner) {}
  bool take(const std::atomic<bool>& stop) override {
    {
      const std::lock_guard lock(owner_.mutex_);
      held_ = owner_.callback_.exclusion;
    }
    while (held_ != nullptr && !held_->try_lock_for(kLookForEnd)) {
      if (!stop.load()) continue;
      held_ = nullptr;
      return false;
    }
    return true;
  }
  void give_back() override {
    if (held_ != nullptr) std::exchange(held_, nullptr)->unlock();
  }

 private:
  ExecutorCallback& owner_;
  PriorityMutex* held_ = nullptr;
};

class ExecutorCallback::NotingRuns final : public Schedule {
 public:
  NotingRuns(Runs& runs, ExecutorCallback& owner) : runs_(runs), owner_(owner) {}
  ctn::Awaited await() override { return runs_.await(); }
  bool await_complete() override { return runs_.await_complete(); }
  void begin() override {
    owner_.begin(runs_);
    owner_.run_times_.begin(owner_.binding().node, runs_.number(), system_now());
  }
  void end(bool output) override {
    owner_.run_times_.end(owner_.binding().node, system_now());
    owner_.end(output);
  }

 private:
  Runs& runs_;
  ExecutorCallback& owner_;
};

ExecutorCallback::ExecutorCallback(Binding binding, RunTimes& run_times, Attach attach)
    : LocalNode(std::move(binding)), run_times_(run_times), attach_(std::move(attach)) {}

void ExecutorCallback::connect(Callback callback) {
  Callback replaced;  // let go without the mutex
  const std::lock_guard lock(mutex_);
  replaced = std::exchange(callback_, std::move(callback));
}

void ExecutorCallback::start() {
  if (thread_.joinable()) return;
  thread_ = std::thread([this] { run(); });
  const auto until = std::chrono::steady_clock::now() + kWaitToSettle;
  const std::lock_guard lock(settled_mutex_);
  while (!settled_ && settled_changed_.wait_until(settled_mutex_, until)) {
  }
}

void ExecutorCallback::stop() {
  inbox_.stop();
  if (thread_.joinable()) thread_.join();
}

void ExecutorCallback::run() {
  const auto settle = [this] {
    const std::lock_guard lock(settled_mutex_);
    settled_ = true;
    settled_changed_.notify_all();
  };
  const std::unique_ptr<Runs> runs = attach_(inbox_.stopped(), settle);
  bound_.store(runs != nullptr);
  settle();
  if (!runs) return;
  NotingRuns schedule(*runs, *this);
  GroupTurn turn(*this);
  BoundCallback called(executor_options(binding()), inbox_, turn);
  called.set_look_for_messages([this, &called] {
    if (always_gives_output_.load()) called.set_always_gives_output();
    collect();
  });
  bool is_timer = false;
  {
    const std::lock_guard lock(mutex_);
    is_timer = static_cast<bool>(callback_.direct);
  }
  if (is_timer && !binding().runs_by_itself) called.set_without_message([this] { return call_directly(); });
  called.set_let_go([&] { let_go(called, turn); }, [this] { set_bound(true); });
  called.run(schedule);
  set_bound(false);
}

void ExecutorCallback::set_bound(bool bound) {
  const std::lock_guard lock(mutex_);
  bound_.store(bound);
}

// What was collected is called first, by this thread, and by its executor what comes from now on.
void ExecutorCallback::let_go(BoundCallback& callback, Turn& turn) {
  if (!turn.take(inbox_.stopped())) return;
  set_bound(false);
  callback.call_rest();
  turn.give_back();
}

bool ExecutorCallback::call_directly() {
  std::function<bool()> direct;
  {
    const std::lock_guard lock(mutex_);
    direct = callback_.direct;
  }
  return direct && call_handing_on_exceptions(direct);
}

// By the node's thread, in a run or not: nobody of the program could catch it there.
bool ExecutorCallback::call_handing_on_exceptions(const std::function<bool()>& call) {
  return call_handing_on(call, true, [this](const std::exception_ptr& exception) { hand_on(exception); });
}

void ExecutorCallback::hand_on(const std::exception_ptr& exception) {
  std::function<void(std::exception_ptr)> thrown;
  {
    const std::lock_guard lock(mutex_);
    thrown = callback_.thrown;
  }
  if (!thrown) std::rethrow_exception(exception);
  thrown(exception);
}

void ExecutorCallback::collect() {
  const std::lock_guard lock(mutex_);
  if (!callback_.take || !bound()) return;
  std::optional<Call> newest;
  while (std::optional<Call> next = callback_.take()) {
    if (binding().handles_all()) {
      put(std::move(*next));
    } else {
      newest = std::move(next);
    }
  }
  if (newest) put(std::move(*newest));
}

bool ExecutorCallback::offer(Call call) {
  const std::lock_guard lock(mutex_);
  if (!bound()) return false;
  put(std::move(call));
  return true;
}

void ExecutorCallback::put(Call call) {
  Inbox::Entry entry{0, [this, sent = call.sent, made = std::move(call.call)] {
                       if (sent != 0 && in_run()) {
                         for (const std::string& predecessor : binding().predecessors) {
                           const std::uint64_t run = run_times_.find(predecessor, sent);
                           if (run != 0) note_taken_from(predecessor, run);
                         }
                       }
                       return call_handing_on_exceptions(made) ? Outcome::kCalled : Outcome::kNothing;
                     }};
  if (binding().handles_all()) {
    inbox_.put(std::move(entry));
  } else {
    inbox_.put_alone(std::move(entry));
  }
}

void ExecutorCallback::note_published(const std::string& topic) {
  if (binding().gives_output_on(topic)) BoundCallback::current()->note_output();
}

}  // namespace catan_ros
