// How an Executor spins: one thread waits for what is ready. It hands callbacks that are nodes to these (common/
// executor_callback.h), and the others to the threads that spin, of which the one that called spin() is the first.
//
// A callback that waits for a thread keeps its mutually exclusive group closed, as rclcpp has it, so nothing else of
// that group becomes ready; one of a group that is not exclusive would become ready again and again, so the waiting
// thread waits until it has been begun.
//
// What a node's callback throws comes out of one of the threads that spin, as rclcpp has it: out of spin(), or, where
// that is another of several, it ends the program.
//
// Thread safety: know() from any thread; the rest by the thread that spins.
#pragma once

#include <condition_variable>
#include <deque>
#include <exception>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include <rclcpp/rclcpp.hpp>

#include "catan_ros2/executor.hpp"
#include "common/executor_program.h"
#include "common/priority_mutex.h"
#include "common/thrown.h"

namespace catan_ros2 {

class Dispatch {
 public:
  explicit Dispatch(Executor& executor) : executor_(executor) {}

  void know(const detail::Node& node);
  // Precondition: executor.spinning is set. Returns when it is not any more.
  void spin();

 private:
  using Executable = std::shared_ptr<rclcpp::AnyExecutable>;
  class Ended;
  struct Known {
    std::weak_ptr<void> entity;
    catan_ros::ExecutorCallback* callback = nullptr;  // null: it is no node
  };
  struct Group {
    std::weak_ptr<rclcpp::CallbackGroup> group;
    catan_ros::PriorityMutex exclusion;
  };

  bool spins() const;
  template <class Waiting>
  static void look_anew(Waiting& executor);
  template <class Waiting>
  static void forget_found(Waiting& executor);
  void run_plainly();
  // By the thread that waits.
  void wait_for_work();
  void look_for_callbacks();
  bool hand_over(const rclcpp::AnyExecutable& ready);
  template <class Entity>
  catan_ros::ExecutorCallback* callback_of(const std::shared_ptr<Entity>& entity,
                                           const rclcpp::CallbackGroup::SharedPtr& group);
  std::string node_of(const rclcpp::CallbackGroup::SharedPtr& group, bool& intra_process);
  catan_ros::PriorityMutex* exclusion_of(const rclcpp::CallbackGroup::SharedPtr& group);
  void put(Executable ready);
  // By the threads that spin.
  void run_scheduled();
  Executable take();
  void execute(rclcpp::AnyExecutable& ready);
  // By a node's thread.
  void hand_on(std::exception_ptr thrown);
  void end();

  Executor& executor_;
  std::mutex nodes_mutex_;
  std::vector<rclcpp::node_interfaces::NodeBaseInterface::WeakPtr> nodes_;

  std::mutex wait_mutex_;
  std::unique_ptr<catan_ros::ExecutorProgram> program_;
  std::map<const void*, Known> known_;
  catan_ros::PriorityMutex one_at_a_time_;
  std::mutex groups_mutex_;
  std::deque<Group> groups_;

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Executable> ready_;
  catan_ros::ThrownExceptions thrown_;  // put under mutex_
  bool ended_ = false;
};

}  // namespace catan_ros2
