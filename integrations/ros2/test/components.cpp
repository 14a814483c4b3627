// Components as anyone writes them: Talker sends numbers on /numbers when its timer is due, Listener takes them and
// says on /heard how many it has had.
#include <chrono>

#include <rclcpp/rclcpp.hpp>
#include <rclcpp_components/register_node_macro.hpp>
#include <std_msgs/msg/int64.hpp>

namespace plain {

using std_msgs::msg::Int64;

class Talker : public rclcpp::Node {
 public:
  explicit Talker(const rclcpp::NodeOptions& options) : Node("talker", options) {
    out_ = create_publisher<Int64>("/numbers", 10);
    timer_ = create_wall_timer(std::chrono::milliseconds{20}, [this] {
      Int64 number;
      number.data = ++sent_;
      out_->publish(number);
    });
  }

 private:
  rclcpp::Publisher<Int64>::SharedPtr out_;
  rclcpp::TimerBase::SharedPtr timer_;
  std::int64_t sent_ = 0;
};

class Listener : public rclcpp::Node {
 public:
  explicit Listener(const rclcpp::NodeOptions& options) : Node("listener", options) {
    out_ = create_publisher<Int64>("/heard", 10);
    in_ = create_subscription<Int64>("/numbers", 10, [this](const Int64&) {
      Int64 heard;
      heard.data = ++heard_;
      out_->publish(heard);
    });
  }

 private:
  rclcpp::Publisher<Int64>::SharedPtr out_;
  rclcpp::SubscriptionBase::SharedPtr in_;
  std::int64_t heard_ = 0;
};

}  // namespace plain

// cppcheck-suppress unknownMacro
RCLCPP_COMPONENTS_REGISTER_NODE(plain::Talker)
RCLCPP_COMPONENTS_REGISTER_NODE(plain::Listener)
