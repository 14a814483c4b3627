// libcatan_ros1.so: what the functions do that libcatan_ros1_preload.so takes the place of.
//
// A callback that a binding names gets a queue of its own when the program asks for it (NodeHandle::subscribe and its
// like): from then on roscpp does the rest, by its public interface.
#include <ros/names.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <mutex>
#include <utility>

#include <boost/make_shared.hpp>
#include <boost/ref.hpp>

#include "common/observation.h"
#include "common/priority_mutex.h"
#include "ros1/hooks.h"
#include "ros1/nodelet_hooks.h"
#include "ros1/noting_helper.h"
#include "ros1/observer.h"
#include "ros1/program.h"
#include "ros1/turns_of_queues.h"

namespace catan_ros {
namespace {

Program* g_program = nullptr;

ros::CallbackQueueInterface& queue_of(const ros::NodeHandle& handle, ros::CallbackQueueInterface* asked_for) {
  return asked_for != nullptr ? *asked_for : *handle.getCallbackQueue();
}

// Messages wait for a trigger, where a spinner would have called each at once: all that are to be handled must fit. Of
// the others the newest is to, and one that is left over (BoundCallback). Not less than the program asked for, since
// they may go to its own queue (BoundNode). 0: as many as come.
std::uint32_t room_for(const Binding& binding, std::uint32_t asked_for) {
  constexpr std::uint32_t kAll = 1000;
  constexpr std::uint32_t kNewest = 2;
  return asked_for == 0 ? 0 : std::max(asked_for, binding.takes_all ? kAll : kNewest);
}

// The same callback, for which roscpp keeps the queue that it is called from for as long as it has the callback.
template <class Helper>
boost::shared_ptr<Helper> keeping(boost::shared_ptr<Helper> helper, Program::CandidatePtr queue) {
  Helper* const same = helper.get();
  return {same, [helper = std::move(helper), queue = std::move(queue)](Helper*) mutable {
            helper.reset();
            queue.reset();
          }};
}

// The options are the program's, which may use them again.
ros::Subscriber subscribe(ros::NodeHandle& handle, ros::SubscribeOptions& options, Subscribe next) {
  ros::CallbackQueueInterface& queue = queue_of(handle, options.callback_queue);
  const std::string topic = handle.resolveName(options.topic);
  if (!g_program->is_bound()) return (handle.*next)(options);
  const Program::CandidatePtr own_queue = g_program->find(Binding::Kind::kTopic, topic, queue);
  ros::SubscribeOptions own = options;
  KeptMessages::Topic& kept = g_program->kept().topic(topic);
  if (g_program->notes_messages()) {
    g_program->note_subscription(topic, queue);
    own.helper = boost::make_shared<NotingHelper>(options.helper, boost::ref(kept));
  } else if (own_queue != nullptr) {
    own.helper = boost::make_shared<BoundHelper>(options.helper, boost::ref(kept));
  } else {
    own.helper = boost::make_shared<CountedHelper>(options.helper, boost::ref(kept));
  }
  if (own_queue != nullptr) {
    own.callback_queue = own_queue.get();
    own.helper = keeping(std::move(own.helper), own_queue);
    own.queue_size = room_for(own_queue->node().binding(), options.queue_size);
    if (options.tracked_object) own_queue->keep_all();
    own_queue->node().start();
  }
  ros::Subscriber subscriber = (handle.*next)(own);
  options.topic = own.topic;
  options.callback_queue = &queue;
  return subscriber;
}

ros::ServiceServer advertise_service(ros::NodeHandle& handle, ros::AdvertiseServiceOptions& options,
                                     AdvertiseService next) {
  ros::CallbackQueueInterface& queue = queue_of(handle, options.callback_queue);
  const Program::CandidatePtr own_queue =
      g_program->find(Binding::Kind::kService, handle.resolveName(options.service), queue);
  if (own_queue == nullptr) return (handle.*next)(options);
  ros::AdvertiseServiceOptions own = options;
  own.callback_queue = own_queue.get();
  own.helper = keeping(options.helper, own_queue);
  own_queue->node().start();
  ros::ServiceServer server = (handle.*next)(own);
  options.service = own.service;
  options.callback_queue = &queue;
  return server;
}

// A timer's function, which roscpp calls when it is due, and a trigger before that: to the program each call's time
// before is that of the call before, whoever made it. Thread safety: any thread.
template <class Event, class Callback>
class TimedFunction {
 public:
  using Time = decltype(Event::current_real);

  explicit TimedFunction(Callback callback) : callback_(std::move(callback)) {}

  void call(Event event) {
    {
      const std::lock_guard lock(mutex_);
      if (was_called_) event.last_real = last_;
      last_ = event.current_real;
      was_called_ = true;
    }
    callback_(event);
  }
  void call_now() {
    Event event;
    {
      const std::lock_guard lock(mutex_);
      event.last_expected = event.last_real = last_;
    }
    event.current_expected = event.current_real = Time::now();
    call(event);
  }

 private:
  const Callback callback_;
  PriorityMutex mutex_;
  Time last_{};  // 0 before the first call
  bool was_called_ = false;
};

// Under simulated time a timer is called when it is due by that, and not before: it may stand still.
bool may_be_called_before_due(const ros::TimerEvent*) { return ros::Time::isSystemTime(); }
bool may_be_called_before_due(const void*) { return true; }

// Calls a timer's function as if it were due now.
template <class Options, class Event>
class DirectCall {
 public:
  using Function = TimedFunction<Event, decltype(Options::callback)>;

  DirectCall(const Options& options, std::shared_ptr<Function> function)
      : function_(std::move(function)), tracked_(options.tracked_object), is_tracked_(options.tracked_object) {}

  bool operator()() {
    if (!may_be_called_before_due(static_cast<const Event*>(nullptr))) return false;
    const ros::VoidConstPtr object = tracked_.lock();
    if (is_tracked_ && !object) return false;
    function_->call_now();
    return true;
  }

 private:
  std::shared_ptr<Function> function_;
  ros::VoidConstWPtr tracked_;
  bool is_tracked_;
};

template <class Timer, class Event, class Options, class Next>
Timer create(const ros::NodeHandle& handle, Options& options, Next next) {
  ros::CallbackQueueInterface& queue = queue_of(handle, options.callback_queue);
  // What is called once has no period.
  const Program::CandidatePtr own_queue =
      options.oneshot ? nullptr : g_program->find_timer(std::chrono::nanoseconds{options.period.toNSec()}, queue);
  if (own_queue == nullptr) return (handle.*next)(options);
  Options own = options;
  own.callback_queue = own_queue.get();
  using Direct = DirectCall<Options, Event>;
  auto function = std::make_shared<typename Direct::Function>(options.callback);
  // As long as roscpp has the function it may use the queue.
  own.callback = [function, own_queue](const Event& event) { function->call(event); };
  own_queue->set_direct_call(Direct(options, std::move(function)), options.autostart);
  own_queue->node().start();
  Timer timer = (handle.*next)(own);
  options.callback_queue = &queue;
  return timer;
}

ros::Timer create_timer(const ros::NodeHandle& handle, ros::TimerOptions& options, CreateTimer next) {
  return create<ros::Timer, ros::TimerEvent>(handle, options, next);
}

ros::WallTimer create_wall_timer(const ros::NodeHandle& handle, ros::WallTimerOptions& options, CreateWallTimer next) {
  return create<ros::WallTimer, ros::WallTimerEvent>(handle, options, next);
}

ros::SteadyTimer create_steady_timer(const ros::NodeHandle& handle, ros::SteadyTimerOptions& options,
                                     CreateSteadyTimer next) {
  return create<ros::SteadyTimer, ros::SteadyTimerEvent>(handle, options, next);
}

// Before it is sent, so that who gets it finds the run.
void publish(const ros::Publisher& publisher, const SerializeMessage& serialize, ros::SerializedMessage& message,
             Publish next) {
  BoundNode* const node = BoundNode::current();
  if (node == nullptr) return (publisher.*next)(serialize, message);
  const std::string topic = publisher.getTopic();
  node->note_sending(topic);
  if (message.message) node->note_sent(MessageRuns::key_of_address(topic, message.message.get()));
  const SerializeMessage noting = [&] {
    ros::SerializedMessage serialized = serialize();
    const PublishedKeys keys = keys_of(topic, serialized);
    node->note_sent(keys.whole);
    node->note_sent(keys.without_sequence);
    return serialized;
  };
  (publisher.*next)(noting, message);
  node->note_published(topic);
}

const char* current_node() {
  const BoundNode* const node = BoundNode::current();
  return node != nullptr ? node->binding().node.c_str() : nullptr;
}

void adopt(const char* node) { g_program->adopt_this_thread(node); }

void share(pid_t thread) { g_program->share_thread(thread); }

void shut_down() { g_program->stop(); }

// As long as a loop is known to wait, it has no turn: a run is before that, or it wakes the loop.
bool enter(const ros::CallbackQueue* queue, bool in_loop) {
  TurnsOfQueue* const turns = find_turns(queue);
  if (turns == nullptr) return false;
  if (in_loop) turns->begin_loop();
  turns->enter();
  return in_loop;
}

void leave(const ros::CallbackQueue* queue, bool in_loop) {
  TurnsOfQueue* const turns = find_turns(queue);
  if (turns == nullptr) return;
  turns->leave();
  if (in_loop) turns->end_loop();
}

void* begin(const ros::CallbackQueue* queue) {
  Turns* const turns = find_turns(queue);
  return turns != nullptr && turns->begin() ? turns : nullptr;
}

void end(void* begun) { static_cast<Turns*>(begun)->end(true); }

// A program without bindings is as without Catan.
void add_queue_of_bound(const ros::CallbackQueueInterface* queue, bool one_at_a_time) {
  if (g_program->is_bound()) add_nodelet_queue(queue, one_at_a_time);
}

// Its nodelet is unloaded then, whose timers are stopped without waiting for their callbacks.
void remove_queue_of_bound(const ros::CallbackQueueInterface* queue) {
  g_program->give_up(queue);
  remove_nodelet_queue(queue);
}

void set_nodelet_of_bound(const ros::CallbackQueueInterface* queue, const std::string& name) {
  if (g_program->is_bound()) set_nodelet(queue, name);
}

void* call_nodelet(const ros::CallbackQueueInterface* queue) { return nodelet_queues().call(queue); }

void called_nodelet(void* taken) { NodeletQueues::called(taken); }

}  // namespace
}  // namespace catan_ros

extern "C" const catan_ros::Hooks* catan_ros1_hooks() {
  using namespace catan_ros;
  if (const char* const folder = std::getenv(kObserveVariable)) return observing_hooks(folder);
  const char* const text = std::getenv(kBindingsVariable);
  std::optional<std::vector<Binding>> bindings = parse_bindings(text != nullptr ? text : "");
  if (!bindings || bindings->empty()) return nullptr;
  const char* const messages = std::getenv(kMessageRunsVariable);
  g_program = new Program(std::move(*bindings), messages != nullptr ? messages : "");
  static const Hooks kHooks{subscribe,
                            advertise_service,
                            create_timer,
                            create_wall_timer,
                            create_steady_timer,
                            publish,
                            current_node,
                            adopt,
                            share,
                            shut_down,
                            &has_turns(),
                            enter,
                            leave,
                            &catan_ros::begin,
                            &catan_ros::end,
                            add_queue_of_bound,
                            remove_queue_of_bound,
                            set_nodelet_of_bound,
                            call_nodelet,
                            called_nodelet};
  return &kHooks;
}
