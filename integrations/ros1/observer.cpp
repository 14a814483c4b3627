#include "ros1/observer.h"

#include <ros/console.h>
#include <ros/names.h>
#include <ros/service_callback_helper.h>
#include <ros/subscription_callback_helper.h>
#include <ros/this_node.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <memory>
#include <mutex>
#include <utility>

#include <boost/make_shared.hpp>

#include "common/observation.h"
#include "ros1/nodelet_hooks.h"

namespace catan_ros {
namespace {

std::chrono::nanoseconds read_clock(clockid_t clock) {
  timespec time{};
  ::clock_gettime(clock, &time);
  return std::chrono::seconds{time.tv_sec} + std::chrono::nanoseconds{time.tv_nsec};
}

// Never let go: threads of the program may use it until the process is gone.
class Observer {
 public:
  explicit Observer(std::string folder) : folder_(std::move(folder)) {}

  // The program's name is known from its first callback on. Null: nothing can be written.
  ObservationLog* log() {
    std::call_once(opened_, [this] {
      log_ = ObservationLog::open(folder_, ros::this_node::getName());
      if (!log_) ROS_WARN("catan: nothing can be written to %s; this program is not observed", folder_.c_str());
    });
    return log_.get();
  }

 private:
  const std::string folder_;
  std::once_flag opened_;
  std::unique_ptr<ObservationLog> log_;
};

Observer* g_observer = nullptr;

// A callback from when it is called to its return, in its thread. A callback that spins has others within.
class RunUnderWay {
 public:
  struct Begin {
    std::chrono::nanoseconds time = read_clock(CLOCK_MONOTONIC);
    std::chrono::nanoseconds cpu_time = read_clock(CLOCK_THREAD_CPUTIME_ID);
  };

  RunUnderWay(ObservationLog& log, std::size_t callback, const Begin& begin, std::string from = {})
      : log_(log), callback_(callback), begin_(begin), outer_(std::exchange(t_current, this)) {
    run_.from = std::move(from);
  }
  ~RunUnderWay() {
    t_current = outer_;
    run_.thread = ::gettid();
    run_.begin = begin_.time;
    run_.cpu_time = read_clock(CLOCK_THREAD_CPUTIME_ID) - begin_.cpu_time;
    log_.add_run(callback_, run_);
  }
  RunUnderWay(const RunUnderWay&) = delete;
  RunUnderWay& operator=(const RunUnderWay&) = delete;

  static void note_published(const std::string& topic) {
    if (t_current == nullptr) return;
    std::vector<std::string>& published = t_current->run_.published;
    if (std::find(published.begin(), published.end(), topic) == published.end()) published.push_back(topic);
  }

 private:
  static thread_local RunUnderWay* t_current;

  ObservationLog& log_;
  const std::size_t callback_;
  const Begin begin_;
  RunUnderWay* const outer_;
  ObservedRun run_;
};

thread_local RunUnderWay* RunUnderWay::t_current = nullptr;

// In all but that it is observed the program's own.
class ObservedSubscription final : public ros::SubscriptionCallbackHelper {
 public:
  ObservedSubscription(ros::SubscriptionCallbackHelperPtr inner, ObservationLog& log, std::size_t callback)
      : inner_(std::move(inner)), log_(log), callback_(callback) {}

  ros::VoidConstPtr deserialize(const ros::SubscriptionCallbackHelperDeserializeParams& params) override {
    const RunUnderWay::Begin begin;
    ros::VoidConstPtr message = inner_->deserialize(params);
    t_made = {this, message.get(), begin};
    return message;
  }
  void call(ros::SubscriptionCallbackHelperCallParams& params) override {
    const void* const message = params.event.getConstMessage().get();
    const Made made = std::exchange(t_made, Made{});
    const bool made_now = made.by == this && made.message == message;
    const RunUnderWay run(log_, callback_, made_now ? made.begin : RunUnderWay::Begin{},
                          params.event.getPublisherName());
    inner_->call(params);
  }
  const std::type_info& getTypeInfo() override { return inner_->getTypeInfo(); }
  bool isConst() override { return inner_->isConst(); }
  bool hasHeader() override { return inner_->hasHeader(); }

 private:
  // The last message that the thread made, just before it is called with it.
  struct Made {
    const ObservedSubscription* by = nullptr;
    const void* message = nullptr;
    RunUnderWay::Begin begin{{}, {}};
  };
  static thread_local Made t_made;

  ros::SubscriptionCallbackHelperPtr inner_;
  ObservationLog& log_;
  const std::size_t callback_;
};

thread_local ObservedSubscription::Made ObservedSubscription::t_made;

class ObservedService final : public ros::ServiceCallbackHelper {
 public:
  ObservedService(ros::ServiceCallbackHelperPtr inner, ObservationLog& log, std::size_t callback)
      : inner_(std::move(inner)), log_(log), callback_(callback) {}
  bool call(ros::ServiceCallbackHelperCallParams& params) override {
    const RunUnderWay run(log_, callback_, {});
    return inner_->call(params);
  }

 private:
  ros::ServiceCallbackHelperPtr inner_;
  ObservationLog& log_;
  const std::size_t callback_;
};

// It is to be called from that queue; null: from the handle's.
void set_owner(ObservedCallback& callback, const ros::NodeHandle& handle,
               const ros::CallbackQueueInterface* asked_for) {
  const ros::CallbackQueueInterface& queue = asked_for != nullptr ? *asked_for : *handle.getCallbackQueue();
  callback.nodelet = nodelet_of(queue);
  callback.one_at_a_time = !callback.nodelet.empty() && calls_one_at_a_time(queue);
}

// The options are the program's, which may use them again.
ros::Subscriber observed_subscribe(ros::NodeHandle& handle, ros::SubscribeOptions& options, Subscribe next) {
  ObservationLog* const log = g_observer->log();
  if (log == nullptr) return (handle.*next)(options);
  ObservedCallback callback;
  set_owner(callback, handle, options.callback_queue);
  callback.name = handle.resolveName(options.topic);
  callback.type = options.datatype;
  ros::SubscribeOptions own = options;
  own.helper = boost::make_shared<ObservedSubscription>(options.helper, *log, log->add(callback));
  ros::Subscriber subscriber = (handle.*next)(own);
  options.topic = own.topic;
  options.callback_queue = own.callback_queue;
  return subscriber;
}

ros::ServiceServer observed_service(ros::NodeHandle& handle, ros::AdvertiseServiceOptions& options,
                                    AdvertiseService next) {
  ObservationLog* const log = g_observer->log();
  if (log == nullptr) return (handle.*next)(options);
  ObservedCallback callback;
  callback.kind = Binding::Kind::kService;
  set_owner(callback, handle, options.callback_queue);
  callback.name = handle.resolveName(options.service);
  callback.type = options.datatype;
  ros::AdvertiseServiceOptions own = options;
  own.helper = boost::make_shared<ObservedService>(options.helper, *log, log->add(callback));
  ros::ServiceServer server = (handle.*next)(own);
  options.service = own.service;
  options.callback_queue = own.callback_queue;
  return server;
}

// One that is due only once is part of what starts it.
template <class Timer, class Event, class Options, class Next>
Timer create_observed(const ros::NodeHandle& handle, Options& options, Next next) {
  ObservationLog* const log = g_observer->log();
  if (log == nullptr || options.oneshot || options.period.toNSec() <= 0) return (handle.*next)(options);
  ObservedCallback callback;
  callback.kind = Binding::Kind::kTimer;
  set_owner(callback, handle, options.callback_queue);
  callback.period = std::chrono::nanoseconds{options.period.toNSec()};
  Options own = options;
  own.callback = [inner = options.callback, log, number = log->add(callback)](const Event& event) {
    const RunUnderWay run(*log, number, {});
    inner(event);
  };
  Timer timer = (handle.*next)(own);
  options.callback_queue = own.callback_queue;
  return timer;
}

ros::Timer create_observed_timer(const ros::NodeHandle& handle, ros::TimerOptions& options, CreateTimer next) {
  return create_observed<ros::Timer, ros::TimerEvent>(handle, options, next);
}

ros::WallTimer create_observed_wall_timer(const ros::NodeHandle& handle, ros::WallTimerOptions& options,
                                          CreateWallTimer next) {
  return create_observed<ros::WallTimer, ros::WallTimerEvent>(handle, options, next);
}

ros::SteadyTimer create_observed_steady_timer(const ros::NodeHandle& handle, ros::SteadyTimerOptions& options,
                                              CreateSteadyTimer next) {
  return create_observed<ros::SteadyTimer, ros::SteadyTimerEvent>(handle, options, next);
}

void publish_observed(const ros::Publisher& publisher, const SerializeMessage& serialize,
                      ros::SerializedMessage& message, Publish next) {
  (publisher.*next)(serialize, message);
  RunUnderWay::note_published(publisher.getTopic());
}

const char* no_node() { return nullptr; }
void adopt_nothing(const char*) {}
void nothing_to_shut_down() {}
void* no_turn_of_nodelets(const ros::CallbackQueueInterface*) { return nullptr; }
void no_turn_to_give_back(void*) {}

const std::atomic<bool> kNoTurns{false};

}  // namespace

const Hooks* observing_hooks(const std::string& folder) {
  g_observer = new Observer(folder);
  // Without turns what is for them is not called.
  static const Hooks kHooks{observed_subscribe,
                            observed_service,
                            create_observed_timer,
                            create_observed_wall_timer,
                            create_observed_steady_timer,
                            publish_observed,
                            no_node,
                            adopt_nothing,
                            nullptr,
                            nothing_to_shut_down,
                            &kNoTurns,
                            nullptr,
                            nullptr,
                            nullptr,
                            nullptr,
                            add_nodelet_queue,
                            remove_nodelet_queue,
                            set_nodelet,
                            no_turn_of_nodelets,
                            no_turn_to_give_back};
  return &kHooks;
}

}  // namespace catan_ros
