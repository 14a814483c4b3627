#include "ros2/dispatch.h"

#include <dlfcn.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <functional>
#include <utility>

#include "common/local_node.h"
#include "common/thread_hook.h"
#include "ros2/entities.h"

namespace catan_ros2 {
namespace {

using catan_ros::ExecutorCallback;
using catan_ros::ExecutorProgram;
using catan_ros::PriorityMutex;
using catan_ros::ServerConnection;

// How often callbacks are looked for that are never ready by themselves, such as timers that a trigger takes the place
// of, where nothing else happens.
constexpr std::chrono::milliseconds kBetweenScans{250};

// The one executor of this process that is scheduled; null: none.
std::atomic<ExecutorProgram*> g_scheduled{nullptr};

void tell(ServerConnection::Severity severity, const std::string& text) {
  const rclcpp::Logger logger = rclcpp::get_logger("catan");
  if (severity == ServerConnection::Severity::kError) {
    RCLCPP_ERROR(logger, "%s", text.c_str());
  } else {
    RCLCPP_WARN(logger, "%s", text.c_str());
  }
}

// Whether threads that callbacks make can be told of: the library is there where the program was started with it.
void hook_ros2_threads(bool hooked) {
  static const catan_ros::ThreadHook kHook{[] {
                                             const auto* const node = catan_ros::LocalNode::current();
                                             return node != nullptr ? node->binding().node.c_str() : nullptr;
                                           },
                                           [](const char* node) {
                                             if (ExecutorProgram* const program = g_scheduled.load())
                                               program->adopt_this_thread(node);
                                           },
                                           [](pid_t thread) {
                                             if (ExecutorProgram* const program = g_scheduled.load())
                                               program->share_thread(thread);
                                           }};
  void* const found = ::dlsym(RTLD_DEFAULT, catan_ros::kSetThreadHook);
  if (found != nullptr) reinterpret_cast<catan_ros::SetThreadHook>(found)(hooked ? &kHook : nullptr);
}

// Of which rclcpp has one callback at a time.
bool is_exclusive(const rclcpp::CallbackGroup::SharedPtr& group) {
  return group && group->type() == rclcpp::CallbackGroupType::MutuallyExclusive;
}

// Wakes the thread that waits: in Humble a member, later a pointer.
template <class Condition>
void trigger(Condition& condition) {
  if constexpr (requires { condition->trigger(); }) {
    condition->trigger();
  } else {
    condition.trigger();
  }
}

}  // namespace

void Dispatch::know(const detail::Node& node) {
  const std::lock_guard lock(nodes_mutex_);
  std::erase_if(nodes_, [](const auto& one) { return one.expired(); });
  nodes_.emplace_back(node);
}

// From Jazzy on an executor keeps what it waits for from one wait to the next, and what it has found: where a group has
// been closed meanwhile, a wait for it would return at once, again and again. Humble looks anew each time.
template <class Waiting>
void Dispatch::look_anew(Waiting& executor) {
  if constexpr (requires { executor.entities_need_rebuild_; }) executor.entities_need_rebuild_.store(true);
}

// Else it would hold what the program lets go of.
template <class Waiting>
void Dispatch::forget_found(Waiting& executor) {
  if constexpr (requires { executor.wait_result_; }) {
    const std::lock_guard lock(executor.mutex_);
    executor.wait_result_.reset();
  }
}

bool Dispatch::spins() const { return rclcpp::ok(executor_.context_) && executor_.spinning.load(); }

// At the end of spin(), also where a callback throws: all threads have ended then.
class Dispatch::Ended {
 public:
  explicit Ended(Dispatch& owner, std::vector<std::thread>& threads) : owner_(owner), threads_(threads) {}
  ~Ended() {
    owner_.end();
    for (std::thread& thread : threads_) thread.join();
    if (owner_.program_) {
      owner_.program_->stop();
      hook_ros2_threads(false);
      g_scheduled.store(nullptr);
    }
    owner_.known_.clear();
    owner_.ready_.clear();
    owner_.program_.reset();
    forget_found(owner_.executor_);
    owner_.executor_.spinning.store(false);
  }
  Ended(const Ended&) = delete;
  Ended& operator=(const Ended&) = delete;

 private:
  Dispatch& owner_;
  std::vector<std::thread>& threads_;
};

void Dispatch::spin() {
  std::vector<std::thread> threads;
  const Ended at_end(*this, threads);
  ended_ = false;
  thrown_.clear();
  program_ = ExecutorProgram::from_environment(tell);
  ExecutorProgram* none = nullptr;
  if (program_ && !g_scheduled.compare_exchange_strong(none, program_.get())) {
    tell(ServerConnection::Severity::kWarning,
         "another executor of this process is scheduled; what this one calls is not: give all nodes to one");
    program_.reset();
  }
  const auto run = program_ ? &Dispatch::run_scheduled : &Dispatch::run_plainly;
  if (program_) {
    hook_ros2_threads(true);
    program_->start();
    threads.emplace_back([this] { wait_for_work(); });
  }
  for (std::size_t more = 1; more < executor_.threads_; ++more) threads.emplace_back([this, run] { (this->*run)(); });
  (this->*run)();
}

void Dispatch::end() {
  {
    const std::lock_guard lock(mutex_);
    ended_ = true;
  }
  changed_.notify_all();
  if (executor_.spinning.exchange(false)) trigger(executor_.interrupt_guard_condition_);
}

// Without Catan.
void Dispatch::run_plainly() {
  while (spins()) {
    rclcpp::AnyExecutable ready;
    {
      const std::lock_guard lock(wait_mutex_);
      if (!spins()) return;
      if (!executor_.get_next_executable(ready)) continue;
    }
    execute(ready);
  }
}

// Then what was closed may be ready, and whoever waits is to look. The destructor must not open the group again, which
// may be closed for another one by then.
void Dispatch::execute(rclcpp::AnyExecutable& ready) {
  executor_.execute_any_executable(ready);
  if (is_exclusive(ready.callback_group) && rclcpp::ok(executor_.context_))
    trigger(executor_.interrupt_guard_condition_);
  ready.callback_group.reset();
}

// --- The thread that waits ---

// A node that waits for a message from elsewhere is woken by it, so it is no ordinary thread, but only once it has made
// the nodes' threads, which begin with its CPUs.
void Dispatch::wait_for_work() {
  look_for_callbacks();
  program_->share_thread(::gettid());
  while (spins()) {
    const auto ready = std::make_shared<rclcpp::AnyExecutable>();
    if (!executor_.get_next_executable(*ready, kBetweenScans)) {
      look_for_callbacks();
    } else if (!hand_over(*ready)) {
      put(ready);
    }
  }
  end();
}

void Dispatch::look_for_callbacks() {
  std::erase_if(known_, [](const auto& one) { return one.second.entity.expired(); });
  for (const auto& weak : executor_.get_all_callback_groups()) {
    const auto group = weak.lock();
    if (!group) continue;
    const auto look = [&](const auto& entity) { static_cast<void>(callback_of(entity, group)); };
    group->collect_all_ptrs(
        look, look, [](const rclcpp::ClientBase::SharedPtr&) {}, look,
        [&](const rclcpp::Waitable::SharedPtr& waitable) {
          using IntraProcess = rclcpp::experimental::SubscriptionIntraProcessBase;
          if (const auto subscription = std::dynamic_pointer_cast<IntraProcess>(waitable)) {
            look(subscription);
          }
        });
  }
}

// False: it is to be called as without Catan.
bool Dispatch::hand_over(const rclcpp::AnyExecutable& ready) {
  const auto bound = [](ExecutorCallback* callback) { return callback != nullptr && callback->bound(); };
  const auto collected = [&](const auto& entity) {
    ExecutorCallback* const callback = callback_of(entity, ready.callback_group);
    if (bound(callback)) callback->collect();
    return bound(callback);
  };
  if (ready.subscription) return collected(ready.subscription);
  if (ready.service) return collected(ready.service);
  if (ready.timer) {
    ExecutorCallback* const callback = callback_of(ready.timer, ready.callback_group);
    if (!bound(callback)) return false;
    return !callback->binding().runs_by_itself || callback->offer(call_of(ready.timer, ready));
  }
  if (!ready.waitable) return false;
  const auto found = known_.find(ready.waitable.get());
  if (found == known_.end() || !bound(found->second.callback)) return false;
  return found->second.callback->offer(call_of(ready.waitable, ready.data));
}

// The node that a subscription, service or timer is; null: none. A new one takes the place of one that is gone; of two
// that are there, the first is the node.
template <class Entity>
ExecutorCallback* Dispatch::callback_of(const std::shared_ptr<Entity>& entity,
                                        const rclcpp::CallbackGroup::SharedPtr& group) {
  // Of a waitable its own address, by which the executor knows it.
  const void* key = entity.get();
  if constexpr (std::is_base_of_v<rclcpp::Waitable, Entity>) key = static_cast<const rclcpp::Waitable*>(entity.get());
  const auto found = known_.find(key);
  if (found != known_.end() && found->second.entity.lock() == entity) return found->second.callback;
  bool intra_process = false;
  const std::string node = node_of(group, intra_process);
  ExecutorCallback* callback = program_->find(node, kind_of(*entity), name_of(*entity), period_of(*entity));
  const bool is_taken = std::any_of(known_.begin(), known_.end(), [&](const auto& one) {
    return callback != nullptr && one.second.callback == callback && !one.second.entity.expired();
  });
  constexpr bool kIsIntraProcess = std::is_base_of_v<rclcpp::Waitable, Entity>;
  if (is_taken && !kIsIntraProcess) {
    tell(ServerConnection::Severity::kWarning,
         node + " has another callback of " + (name_of(*entity).empty() ? "that period" : name_of(*entity)) +
             "; the first one is node " + callback->binding().node + ", the other is not scheduled");
    callback = nullptr;
  }
  known_[key] = {entity, callback};
  if (callback == nullptr) return nullptr;
  if (intra_process) callback->set_always_gives_output();
  if (!is_taken) {
    ExecutorCallback::Callback made = callback_for(entity);
    made.exclusion = exclusion_of(group);
    made.thrown = [this](std::exception_ptr thrown) { hand_on(std::move(thrown)); };
    callback->connect(std::move(made));
  }
  callback->start();
  return callback;
}

// Its full name; empty: not known.
std::string Dispatch::node_of(const rclcpp::CallbackGroup::SharedPtr& group, bool& intra_process) {
  const std::lock_guard lock(nodes_mutex_);
  for (const auto& weak : nodes_) {
    const auto node = weak.lock();
    if (!node || !node->callback_group_in_node(group)) continue;
    intra_process = node->get_use_intra_process_default();
    return node->get_fully_qualified_name();
  }
  return {};
}

PriorityMutex* Dispatch::exclusion_of(const rclcpp::CallbackGroup::SharedPtr& group) {
  if (executor_.threads_ == 1) return &one_at_a_time_;
  if (!is_exclusive(group)) return nullptr;
  const std::lock_guard lock(groups_mutex_);
  const auto known =
      std::find_if(groups_.begin(), groups_.end(), [&](const Group& one) { return one.group.lock() == group; });
  if (known != groups_.end()) return &known->exclusion;
  Group& added = groups_.emplace_back();
  added.group = group;
  return &added.exclusion;
}

void Dispatch::put(Executable ready) {
  const bool exclusive = is_exclusive(ready->callback_group);
  if (exclusive) look_anew(executor_);
  std::unique_lock lock(mutex_);
  ready_.push_back(std::move(ready));
  changed_.notify_all();
  if (!exclusive) changed_.wait(lock, [this] { return ready_.empty() || ended_; });
}

void Dispatch::hand_on(std::exception_ptr thrown) {
  const std::lock_guard lock(mutex_);
  thrown_.put(std::move(thrown));
  changed_.notify_all();
}

// --- The threads that spin ---

Dispatch::Executable Dispatch::take() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return !ready_.empty() || !thrown_.empty() || ended_; });
  thrown_.throw_first();
  if (ended_) return nullptr;
  Executable first = std::move(ready_.front());
  ready_.pop_front();
  changed_.notify_all();
  return first;
}

void Dispatch::run_scheduled() {
  while (const Executable ready = take()) {
    PriorityMutex* const exclusion = exclusion_of(ready->callback_group);
    std::unique_lock<PriorityMutex> held;
    if (exclusion != nullptr) held = std::unique_lock(*exclusion);
    execute(*ready);
  }
}

}  // namespace catan_ros2
