// What rclcpp has for a callback, taken now and called later: of subscriptions, services and timers, by their public
// functions, in all versions from Humble on.
//
// Thread safety: take() by one thread at a time for each; calls from any. The program may let go of its subscription,
// service or timer meanwhile: then nothing is called.
#pragma once

#include <rcl/timer.h>
#include <rclcpp/version.h>

#include <chrono>
#include <memory>
#include <optional>
#include <utility>

#include <rclcpp/experimental/subscription_intra_process_base.hpp>
#include <rclcpp/rclcpp.hpp>

#include "common/executor_callback.h"

namespace catan_ros2 {

using Call = catan_ros::ExecutorCallback::Call;

// The name under which a callback is bound; of timers the period, of what has no name nothing.
inline std::string name_of(const rclcpp::SubscriptionBase& subscription) { return subscription.get_topic_name(); }
inline std::string name_of(rclcpp::ServiceBase& service) { return service.get_service_name(); }
inline std::string name_of(const rclcpp::TimerBase&) { return {}; }
inline std::string name_of(const rclcpp::experimental::SubscriptionIntraProcessBase& subscription) {
  return subscription.get_topic_name();
}

inline std::chrono::nanoseconds period_of(rclcpp::TimerBase& timer) {
  std::int64_t period = 0;
  return rcl_timer_get_period(timer.get_timer_handle().get(), &period) == RCL_RET_OK ? std::chrono::nanoseconds{period}
                                                                                     : std::chrono::nanoseconds{0};
}
template <class Entity>
std::chrono::nanoseconds period_of(Entity&) {
  return std::chrono::nanoseconds{0};
}

inline catan_ros::Binding::Kind kind_of(const rclcpp::SubscriptionBase&) { return catan_ros::Binding::Kind::kTopic; }
inline catan_ros::Binding::Kind kind_of(const rclcpp::ServiceBase&) { return catan_ros::Binding::Kind::kService; }
inline catan_ros::Binding::Kind kind_of(const rclcpp::TimerBase&) { return catan_ros::Binding::Kind::kTimer; }
inline catan_ros::Binding::Kind kind_of(const rclcpp::experimental::SubscriptionIntraProcessBase&) {
  return catan_ros::Binding::Kind::kTopic;
}

inline std::optional<Call> take(const std::weak_ptr<rclcpp::SubscriptionBase>& from) {
  const auto subscription = from.lock();
  if (!subscription) return std::nullopt;
  rclcpp::MessageInfo info;
  if (subscription->is_serialized()) {
    std::shared_ptr<rclcpp::SerializedMessage> message = subscription->create_serialized_message();
    if (!subscription->take_serialized(*message, info)) return std::nullopt;
    return Call{info.get_rmw_message_info().source_timestamp, [from, message, info] {
                  const auto there = from.lock();
                  if (!there) return false;
                  std::shared_ptr<rclcpp::SerializedMessage> own = message;
                  there->handle_serialized_message(own, info);
                  there->return_serialized_message(own);
                  return true;
                }};
  }
  std::shared_ptr<void> taken = subscription->create_message();
  if (!subscription->take_type_erased(taken.get(), info)) return std::nullopt;
  return Call{info.get_rmw_message_info().source_timestamp, [from, message = std::move(taken), info]() mutable {
                const auto there = from.lock();
                if (!there) return false;
                there->handle_message(message, info);
                there->return_message(message);
                return true;
              }};
}

inline std::optional<Call> take(const std::weak_ptr<rclcpp::ServiceBase>& from) {
  const auto service = from.lock();
  if (!service) return std::nullopt;
  const auto header = service->create_request_header();
  const std::shared_ptr<void> request = service->create_request();
  if (!service->take_type_erased_request(request.get(), *header)) return std::nullopt;
  return Call{0, [from, header, request] {
                const auto there = from.lock();
                if (there) there->handle_request(header, request);
                return there != nullptr;
              }};
}

// A timer's callback, now, whether it is due or not; false: it was cancelled, or is gone. `due`: when it was, as rclcpp
// tells its callback from Jazzy on; null: now.
inline bool call_now(const std::weak_ptr<rclcpp::TimerBase>& from,
                     [[maybe_unused]] std::shared_ptr<void> due = nullptr) {
  const auto timer = from.lock();
  if (!timer || timer->is_canceled()) return false;
#if RCLCPP_VERSION_GTE(28, 1, 0)
  if (!due) {
    const auto info = std::make_shared<rcl_timer_call_info_t>();
    info->expected_call_time = info->actual_call_time =
        std::chrono::nanoseconds(std::chrono::steady_clock::now().time_since_epoch()).count();
    due = info;
  }
  timer->execute_callback(due);
#else
  timer->execute_callback();
#endif
  return true;
}

// One that is due: the executor has said so to rclcpp.
inline Call call_of(const std::weak_ptr<rclcpp::TimerBase>& from, const rclcpp::AnyExecutable& ready) {
  return {0, [from, due = ready.data] { return call_now(from, due); }};
}

// The function that takes a pointer that may be replaced is the only one in Humble, and deprecated from Jazzy on.
template <class Waitable>
void execute(Waitable& waitable, std::shared_ptr<void>& data) {
  if constexpr (requires { waitable.execute(std::as_const(data)); }) {
    waitable.execute(std::as_const(data));
  } else {
    waitable.execute(data);
  }
}

inline Call call_of(const rclcpp::Waitable::SharedPtr& waitable, std::shared_ptr<void> taken) {
  return {0, [from = std::weak_ptr(waitable), data = std::move(taken)]() mutable {
            const auto there = from.lock();
            if (there) execute(*there, data);
            return there != nullptr;
          }};
}

inline catan_ros::ExecutorCallback::Callback callback_for(const std::shared_ptr<rclcpp::TimerBase>& timer) {
  return {{}, [from = std::weak_ptr(timer)] { return call_now(from); }, nullptr};
}
inline catan_ros::ExecutorCallback::Callback callback_for(
    const std::shared_ptr<rclcpp::experimental::SubscriptionIntraProcessBase>&) {
  return {};
}
template <class Entity>
catan_ros::ExecutorCallback::Callback callback_for(const std::shared_ptr<Entity>& entity) {
  return {[from = std::weak_ptr(entity)] { return take(from); }, {}, nullptr};
}

}  // namespace catan_ros2
