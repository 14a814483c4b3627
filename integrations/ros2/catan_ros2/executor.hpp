// An executor of ROS 2 whose callbacks Catan schedules: write catan_ros2::Executor where the program has
// rclcpp::executors::SingleThreadedExecutor or MultiThreadedExecutor. Nodes of the app are callbacks, named by ROS node
// and topic, timer or service (docs/ros2.md); `catan ros2 run` says which. Without it the executor is as those two are.
//
// Each callback that is a node is called in a thread of its own, when the server triggers it. All others are called as
// ever. What may not overlap does not: with one thread no two callbacks at all, as with a SingleThreadedExecutor; with
// more, none of the same mutually exclusive callback group.
//
// spin() schedules; spin_some(), spin_once() and their like call callbacks as without Catan. One executor of a process
// is scheduled at a time.
//
// Thread safety: as rclcpp::Executor.
#pragma once

#include <cstddef>
#include <memory>
#include <type_traits>

#include <rclcpp/executor.hpp>

namespace catan_ros2 {

namespace detail {

using Node = rclcpp::node_interfaces::NodeBaseInterface::SharedPtr;

// Whether rclcpp::Executor takes nodes and groups by value; later versions take references.
template <class Argument, class = void>
struct IsTaken : std::false_type {};
template <class Argument>
struct IsTaken<Argument, std::void_t<decltype(static_cast<void (rclcpp::Executor::*)(Argument, bool)>(
                             &rclcpp::Executor::add_node))>> : std::true_type {};

template <class Argument>
using Taken = std::conditional_t<IsTaken<Node>::value, Argument, const Argument&>;

}  // namespace detail

class Dispatch;

class Executor : public rclcpp::Executor {
 public:
  // `threads`: as the MultiThreadedExecutor's, 0 for as many as there are CPUs; 1 is a SingleThreadedExecutor.
  // Callbacks that are nodes have threads besides.
  explicit Executor(const rclcpp::ExecutorOptions& options = rclcpp::ExecutorOptions(), std::size_t threads = 1);
  ~Executor() override;

  // Until cancel(), or until ROS is shut down. Errors: std::runtime_error where it spins already.
  void spin() override;

  std::size_t get_number_of_threads() const { return threads_; }

  using rclcpp::Executor::add_node;
  void add_node(detail::Taken<detail::Node> node, bool notify = true) override;
  void add_callback_group(detail::Taken<rclcpp::CallbackGroup::SharedPtr> group, detail::Taken<detail::Node> node,
                          bool notify = true) override;

 private:
  friend class Dispatch;
  const std::size_t threads_;
  const std::unique_ptr<Dispatch> dispatch_;
};

}  // namespace catan_ros2
