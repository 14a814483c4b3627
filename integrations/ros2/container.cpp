// catan_component_container: loads components as rclcpp_components' containers do, and spins them with
// catan_ros2::Executor.
//
//   catan_component_container [--single-threaded] [--ros-args ...]
//
// Without an option callbacks of one mutually exclusive group do not overlap, as in component_container_mt, whose
// parameter thread_num it takes; with --single-threaded no callbacks do, as in component_container.
#include <algorithm>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include <rclcpp/rclcpp.hpp>
#include <rclcpp_components/component_manager.hpp>

#include "catan_ros2/executor.hpp"

int main(int count, char** words) {
  std::vector<std::string> own = rclcpp::init_and_remove_ros_arguments(count, words);
  bool single = false;
  for (std::size_t i = 1; i < own.size(); ++i) {
    if (own[i] == "--single-threaded") {
      single = true;
      continue;
    }
    std::fprintf(stderr, "catan_component_container: %s is no option of it; there is --single-threaded\n",
                 own[i].c_str());
    return 2;
  }
  const auto manager = std::make_shared<rclcpp_components::ComponentManager>();
  // As many as there are CPUs, and two at least: one is another thing.
  std::size_t threads = std::max<std::size_t>(std::thread::hardware_concurrency(), 2);
  if (manager->has_parameter("thread_num")) {
    threads = static_cast<std::size_t>(std::max<std::int64_t>(manager->get_parameter("thread_num").as_int(), 1));
  }
  const auto executor = std::make_shared<catan_ros2::Executor>(rclcpp::ExecutorOptions(), single ? 1 : threads);
  manager->set_executor(executor);
  executor->add_node(manager);
  executor->spin();
  rclcpp::shutdown();
  return 0;
}
