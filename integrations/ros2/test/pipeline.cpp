// A pipeline with a heavy branch, of plain rclcpp nodes, spun by an executor of choice, which measures itself:
//
//   camera (timer) -> detect -> plan -> motor
//          \-> map                                the heavy branch
//
//   ros2_pipeline EXECUTOR SECONDS    EXECUTOR: single, multi, catan
//
// Messages carry when the run of the camera began that they go back to. What is printed is of the seconds after
// three of warm-up: response times as Catan defines them, for two outputs in a row from the begin of the first one's
// camera run to the end of the second.
#include <time.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <mutex>
#include <numeric>
#include <string>
#include <thread>
#include <vector>

#include <rclcpp/rclcpp.hpp>
#include <std_msgs/msg/int64.hpp>

#include "catan_ros2/executor.hpp"

namespace {

using std_msgs::msg::Int64;
using namespace std::chrono_literals;

constexpr std::chrono::milliseconds kWarmUp{3000};
constexpr std::chrono::milliseconds kCameraPeriod{33};

std::chrono::nanoseconds steady_now() { return std::chrono::steady_clock::now().time_since_epoch(); }

std::chrono::nanoseconds cpu_now() {
  timespec now{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return std::chrono::seconds{now.tv_sec} + std::chrono::nanoseconds{now.tv_nsec};
}

void compute(std::chrono::nanoseconds cost) {
  const auto until = cpu_now() + cost;
  while (cpu_now() < until) {
  }
}

class ResponseTimes {
 public:
  explicit ResponseTimes(std::chrono::nanoseconds from) : from_(from) {}

  // An output that goes back to a camera run that began then.
  void note(std::chrono::nanoseconds origin) {
    const auto now = steady_now();
    if (before_.count() > 0 && now > from_)
      all_.push_back(std::chrono::duration<double, std::milli>(now - before_).count());
    before_ = origin;
  }
  void print(const char* chain) {
    std::sort(all_.begin(), all_.end());
    if (all_.empty()) all_.push_back(0.0);
    const double mean = std::accumulate(all_.begin(), all_.end(), 0.0) / static_cast<double>(all_.size());
    std::printf(R"("%s": {"count": %zu, "mean_ms": %.2f, "p95_ms": %.2f})", chain, all_.size(), mean,
                all_[all_.size() * 95 / 100]);
  }

 private:
  const std::chrono::nanoseconds from_;
  std::chrono::nanoseconds before_{0};
  std::vector<double> all_;
};

class Camera final : public rclcpp::Node {
 public:
  Camera() : Node("camera") {
    out_ = create_publisher<Int64>("/image", 1);
    timer_ = create_wall_timer(kCameraPeriod, [this] {
      Int64 image;
      image.data = steady_now().count();
      compute(2ms);
      out_->publish(image);
    });
  }

 private:
  rclcpp::Publisher<Int64>::SharedPtr out_;
  rclcpp::TimerBase::SharedPtr timer_;
};

// Computes for so long, and passes on what its input goes back to; or notes the response.
class Stage final : public rclcpp::Node {
 public:
  Stage(const std::string& name, const std::string& in, const std::string& out, std::chrono::nanoseconds cost,
        ResponseTimes* noted)
      : Node(name) {
    if (!out.empty()) out_ = create_publisher<Int64>(out, 1);
    in_ = create_subscription<Int64>(in, 1, [this, cost, noted](const Int64& message) {
      compute(cost);
      if (out_) out_->publish(message);
      if (noted != nullptr) noted->note(std::chrono::nanoseconds{message.data});
    });
  }

 private:
  rclcpp::Publisher<Int64>::SharedPtr out_;
  rclcpp::SubscriptionBase::SharedPtr in_;
};

std::unique_ptr<rclcpp::Executor> executor_named(const std::string& name) {
  if (name == "single") return std::make_unique<rclcpp::executors::SingleThreadedExecutor>();
  if (name == "multi") return std::make_unique<rclcpp::executors::MultiThreadedExecutor>();
  if (name == "catan") return std::make_unique<catan_ros2::Executor>(rclcpp::ExecutorOptions(), 2);
  return nullptr;
}

}  // namespace

int main(int count, char** words) {
  rclcpp::init(count, words);
  const std::string name = count > 1 ? words[1] : "";
  const std::unique_ptr<rclcpp::Executor> executor = executor_named(name);
  const double seconds = count > 2 ? std::strtod(words[2], nullptr) : 0.0;
  if (!executor || !(seconds > 0.0 && seconds < 3600.0)) {
    std::fprintf(stderr, "usage: ros2_pipeline single|multi|catan SECONDS\n");
    return 2;
  }
  const auto from = steady_now() + kWarmUp;
  ResponseTimes track(from);
  ResponseTimes map(from);
  const std::vector<std::shared_ptr<rclcpp::Node>> nodes{
      std::make_shared<Camera>(),
      std::make_shared<Stage>("detect", "/image", "/people", 20ms, nullptr),
      std::make_shared<Stage>("plan", "/people", "/command", 3ms, nullptr),
      std::make_shared<Stage>("motor", "/command", "", 1ms, &track),
      std::make_shared<Stage>("map", "/image", "", 60ms, &map),
  };
  for (const auto& node : nodes) executor->add_node(node);
  std::thread stopper([&] {
    std::this_thread::sleep_for(kWarmUp + std::chrono::duration<double>(seconds));
    executor->cancel();
  });
  executor->spin();
  stopper.join();
  std::printf(R"({"executor": "%s", )", name.c_str());
  track.print("track");
  std::printf(", ");
  map.print("map");
  std::printf("}\n");
  rclcpp::shutdown();
  return 0;
}
