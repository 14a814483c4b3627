// The port to ROS 1 passes the suite: each program of it is a ROS program, whose nodes are callbacks of one spinner.
//
// roscpp's functions are taken over by linking the library that is else preloaded, in front of roscpp.
#include <ros/ros.h>
#include <std_msgs/Int64.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <deque>
#include <filesystem>
#include <map>
#include <memory>
#include <thread>

#include "common/binding.h"
#include "conformance/helper.h"
#include "conformance/suite.h"
#include "ros1/test/roscore.h"

namespace ctn::conformance {
namespace {

std::string topic_of(const std::string& node) { return "/conformance/" + node; }

// Timers are told apart by their periods. One that is never due runs when it is triggered.
ros::Duration never(std::size_t index) { return ros::Duration(100'000.0 + static_cast<double>(index)); }

// A node as callbacks of ROS. Those of one spinner do not overlap, so there is no lock.
class RosNode {
 public:
  RosNode(ros::NodeHandle& handle, const Node& node, std::size_t index) : node_(node) {
    if (node.publishes) out_ = handle.advertise<std_msgs::Int64>(topic_of(node.name), 100);
    for (const Node::Input& input : node.inputs) {
      const bool triggers = takes_messages(node);
      inputs_.push_back(handle.subscribe<std_msgs::Int64>(
          topic_of(input.from), 0, [this, triggers, from = input.from](const std_msgs::Int64::ConstPtr& message) {
            taken_[from].push_back(message->data);
            if (triggers) call();
          }));
    }
    if (takes_messages(node)) return;
    const ros::Duration period =
        node.timer ? ros::Duration(static_cast<double>(node.timer->count()) * 1e-3) : never(index);
    timer_ = handle.createTimer(period, [this](const ros::TimerEvent&) { call(); });
  }
  RosNode(const RosNode&) = delete;
  RosNode& operator=(const RosNode&) = delete;

  static catan_ros::Binding binding(const Node& node, std::size_t index, const std::string& ros_node) {
    catan_ros::Binding binding;
    binding.node = node.name;
    binding.ros_node = ros_node;
    if (takes_messages(node)) {
      binding.name = topic_of(node.inputs[0].from);
    } else {
      binding.kind = catan_ros::Binding::Kind::kTimer;
      binding.period = node.timer ? std::chrono::nanoseconds(*node.timer)
                                  : std::chrono::nanoseconds(static_cast<std::int64_t>(never(index).toNSec()));
    }
    binding.takes_all =
        std::any_of(node.inputs.begin(), node.inputs.end(), [](const Node::Input& input) { return input.queue; });
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
  ros::Publisher out_;
  std::vector<ros::Subscriber> inputs_;
  ros::Timer timer_;
  std::map<std::string, std::vector<std::int64_t>> taken_;
  Helper helper_;
};

class RosNode::RosCall final : public Call {
 public:
  explicit RosCall(RosNode& node) : node_(node) {}
  std::vector<std::int64_t> take(const std::string& from) override { return std::exchange(node_.taken_[from], {}); }
  void publish(std::int64_t value) override {
    std_msgs::Int64 message;
    message.data = value;
    node_.out_.publish(message);
  }
  void on_another_thread(const std::function<void()>& work) override { node_.helper_.help(work); }

 private:
  RosNode& node_;
};

void RosNode::call() {
  RosCall call(*this);
  node_.callback(call);
}

class RosPort final : public Port {
 public:
  int run(const std::vector<Node>& nodes, const std::atomic<bool>& stop) override {
    const std::string ros_node = "/with_" + nodes[0].name;
    std::vector<catan_ros::Binding> bindings;
    for (std::size_t index = 0; index < nodes.size(); ++index) {
      bindings.push_back(RosNode::binding(nodes[index], index, ros_node));
    }
    ::setenv(catan_ros::kBindingsVariable, catan_ros::to_text(bindings).c_str(), 1);
    int count = 0;
    ros::init(count, nullptr, ros_node.substr(1), ros::init_options::NoSigintHandler);
    {
      ros::NodeHandle handle;
      std::deque<std::unique_ptr<RosNode>> running;
      for (std::size_t index = 0; index < nodes.size(); ++index) {
        running.push_back(std::make_unique<RosNode>(handle, nodes[index], index));
      }
      std::thread stopper([&] {
        while (!stop.load()) std::this_thread::sleep_for(std::chrono::milliseconds{2});
        ros::shutdown();
      });
      ros::spin();
      stopper.join();
    }
    return 0;
  }
};

std::unique_ptr<Port> make_port() { return std::make_unique<RosPort>(); }

// A master for the tests of this process.
class Master final : public testing::Environment {
 public:
  void SetUp() override {
    folder_ = testing::TempDir() + "catan-ros1-port-XXXXXX";
    if (::mkdtemp(folder_.data()) == nullptr) throw std::runtime_error("no folder " + folder_);
    roscore_ = std::make_unique<catan_ros::Roscore>(folder_);
  }
  void TearDown() override {
    roscore_.reset();
    std::filesystem::remove_all(folder_);
  }

 private:
  std::string folder_;
  std::unique_ptr<catan_ros::Roscore> roscore_;
};

const testing::Environment* const kMaster = testing::AddGlobalTestEnvironment(new Master);

INSTANTIATE_TEST_SUITE_P(Ros1, PortSuite, testing::Values(PortUnderTest{"ros1", make_port}), name_of);

}  // namespace
}  // namespace ctn::conformance
