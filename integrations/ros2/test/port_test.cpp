// The port to ROS 2 passes the suite: each program of it is a ROS 2 program, whose nodes are callbacks of one node of
// ROS and of one executor; once with one thread, once with several.
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <deque>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <rclcpp/rclcpp.hpp>
#include <std_msgs/msg/int64.hpp>

#include "catan_ros2/executor.hpp"
#include "common/binding.h"
#include "conformance/helper.h"
#include "conformance/suite.h"

namespace ctn::conformance {
namespace {

using std_msgs::msg::Int64;

std::string topic_of(const std::string& node) { return "/conformance/" + node; }

// Timers are told apart by their periods. One that is never due runs when it is triggered.
std::chrono::nanoseconds never(std::size_t index) { return std::chrono::hours{1000 + index}; }

// A node as callbacks of ROS. Those of one group do not overlap, so there is no lock.
class RosCallbacks {
 public:
  RosCallbacks(rclcpp::Node& ros, const Node& node, std::size_t index) : node_(node) {
    // An ordinary thread collects what a queue node takes, and may be late by more messages than any depth.
    const rclcpp::QoS depth{rclcpp::KeepAll()};
    if (node.publishes) out_ = ros.create_publisher<Int64>(topic_of(node.name), depth);
    for (const Node::Input& input : node.inputs) {
      const bool triggers = takes_messages(node);
      inputs_.push_back(ros.create_subscription<Int64>(topic_of(input.from), depth,
                                                       [this, triggers, from = input.from](const Int64& message) {
                                                         taken_[from].push_back(message.data);
                                                         if (triggers) call();
                                                       }));
    }
    if (takes_messages(node)) return;
    const std::chrono::nanoseconds period = node.timer ? std::chrono::nanoseconds(*node.timer) : never(index);
    timer_ = ros.create_wall_timer(period, [this] { call(); });
  }
  RosCallbacks(const RosCallbacks&) = delete;
  RosCallbacks& operator=(const RosCallbacks&) = delete;

  static catan_ros::Binding binding(const Node& node, std::size_t index, const std::string& ros_node) {
    catan_ros::Binding binding;
    binding.node = node.name;
    binding.ros_node = ros_node;
    if (takes_messages(node)) {
      binding.name = topic_of(node.inputs[0].from);
    } else {
      binding.kind = catan_ros::Binding::Kind::kTimer;
      binding.period = node.timer ? std::chrono::nanoseconds(*node.timer) : never(index);
    }
    for (const Node::Input& input : node.inputs) {
      binding.takes_all |= input.queue;
      binding.predecessors.push_back(input.from);
    }
    binding.runs_by_itself = node.timer.has_value();
    binding.always_gives_output = !node.publishes;
    binding.output_topics = {topic_of(node.name)};
    return binding;
  }

 private:
  class RosCall;

  // A node that takes the newest message of one other is its subscription; any other a timer's callback, for which
  // subscriptions that are not bound collect messages.
  static bool takes_messages(const Node& node) {
    return node.inputs.size() == 1 && !node.inputs[0].queue && !node.timer;
  }

  void call();

  const Node node_;
  rclcpp::Publisher<Int64>::SharedPtr out_;
  std::vector<rclcpp::SubscriptionBase::SharedPtr> inputs_;
  rclcpp::TimerBase::SharedPtr timer_;
  std::map<std::string, std::vector<std::int64_t>> taken_;
  Helper helper_;
};

class RosCallbacks::RosCall final : public Call {
 public:
  explicit RosCall(RosCallbacks& node) : node_(node) {}
  std::vector<std::int64_t> take(const std::string& from) override { return std::exchange(node_.taken_[from], {}); }
  void publish(std::int64_t value) override {
    Int64 message;
    message.data = value;
    node_.out_->publish(message);
  }
  void on_another_thread(const std::function<void()>& work) override { node_.helper_.help(work); }

 private:
  RosCallbacks& node_;
};

void RosCallbacks::call() {
  RosCall call(*this);
  node_.callback(call);
}

class Ros2Port final : public Port {
 public:
  explicit Ros2Port(std::size_t threads) : threads_(threads) {}

  int run(const std::vector<Node>& nodes, const std::atomic<bool>& stop) override {
    const std::string name = "with_" + nodes[0].name;
    std::vector<catan_ros::Binding> bindings;
    for (std::size_t index = 0; index < nodes.size(); ++index) {
      bindings.push_back(RosCallbacks::binding(nodes[index], index, "/" + name));
    }
    ::setenv(catan_ros::kBindingsVariable, catan_ros::to_text(bindings).c_str(), 1);
    rclcpp::init(0, nullptr, rclcpp::InitOptions(), rclcpp::SignalHandlerOptions::None);
    {
      const auto ros = std::make_shared<rclcpp::Node>(name);
      std::deque<std::unique_ptr<RosCallbacks>> running;
      for (std::size_t index = 0; index < nodes.size(); ++index) {
        running.push_back(std::make_unique<RosCallbacks>(*ros, nodes[index], index));
      }
      catan_ros2::Executor executor(rclcpp::ExecutorOptions(), threads_);
      executor.add_node(ros);
      std::thread stopper([&] {
        while (!stop.load()) std::this_thread::sleep_for(std::chrono::milliseconds{2});
        executor.cancel();
      });
      executor.spin();
      stopper.join();
    }
    rclcpp::shutdown();
    return 0;
  }

 private:
  const std::size_t threads_;
};

std::unique_ptr<Port> make_single() { return std::make_unique<Ros2Port>(1); }
std::unique_ptr<Port> make_multi() { return std::make_unique<Ros2Port>(3); }

// Programs of this test alone are to hear of each other.
class OwnDomain final : public testing::Environment {
 public:
  void SetUp() override {
    ::setenv("ROS_DOMAIN_ID", std::to_string(1 + ::getpid() % 100).c_str(), 1);
    ::setenv("ROS_LOCALHOST_ONLY", "1", 1);
  }
};

const testing::Environment* const kDomain = testing::AddGlobalTestEnvironment(new OwnDomain);

INSTANTIATE_TEST_SUITE_P(Ros2, PortSuite,
                         testing::Values(PortUnderTest{"single", make_single}, PortUnderTest{"multi", make_multi}),
                         name_of);

}  // namespace
}  // namespace ctn::conformance
