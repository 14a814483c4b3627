#include "catan_ros2/executor.hpp"

#include <algorithm>
#include <stdexcept>
#include <thread>

#include "ros2/dispatch.h"

namespace catan_ros2 {

Executor::Executor(const rclcpp::ExecutorOptions& options, std::size_t threads)
    : rclcpp::Executor(options),
      threads_(threads > 0 ? threads : std::max<std::size_t>(std::thread::hardware_concurrency(), 1)),
      dispatch_(std::make_unique<Dispatch>(*this)) {}

Executor::~Executor() = default;

void Executor::spin() {
  if (spinning.exchange(true)) throw std::runtime_error("spin() called while already spinning");
  dispatch_->spin();
}

void Executor::add_node(detail::Taken<detail::Node> node, bool notify) {
  dispatch_->know(node);
  rclcpp::Executor::add_node(node, notify);
}

void Executor::add_callback_group(detail::Taken<rclcpp::CallbackGroup::SharedPtr> group,
                                  detail::Taken<detail::Node> node, bool notify) {
  dispatch_->know(node);
  rclcpp::Executor::add_callback_group(group, node, notify);
}

}  // namespace catan_ros2
