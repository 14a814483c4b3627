// What `ros2 launch` does with a container: asks it to load components.
//
//   ros2_load_components CONTAINER PACKAGE [--intra-process] [--again] PLUGIN...
//
// With --again it has them unloaded after two seconds, and loads them once more. Exit code 1: the container did not.
#include <chrono>
#include <cstdio>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <composition_interfaces/srv/load_node.hpp>
#include <composition_interfaces/srv/unload_node.hpp>
#include <rclcpp/rclcpp.hpp>

namespace {

using composition_interfaces::srv::LoadNode;
using composition_interfaces::srv::UnloadNode;
using namespace std::chrono_literals;

template <class Service>
typename Service::Response::SharedPtr ask(const rclcpp::Node::SharedPtr& node, const std::string& name,
                                          const typename Service::Request::SharedPtr& request) {
  const auto client = node->create_client<Service>(name);
  if (!client->wait_for_service(10s)) return nullptr;
  auto answer = client->async_send_request(request);
  if (rclcpp::spin_until_future_complete(node, answer, 10s) != rclcpp::FutureReturnCode::SUCCESS) return nullptr;
  return answer.get();
}

bool load(const rclcpp::Node::SharedPtr& node, const std::string& container, const std::string& package,
          const std::string& plugin, bool intra_process, std::vector<std::uint64_t>& ids) {
  const auto request = std::make_shared<LoadNode::Request>();
  request->package_name = package;
  request->plugin_name = plugin;
  if (intra_process) {
    rcl_interfaces::msg::Parameter within;
    within.name = "use_intra_process_comms";
    within.value.type = rcl_interfaces::msg::ParameterType::PARAMETER_BOOL;
    within.value.bool_value = true;
    request->extra_arguments.push_back(within);
  }
  const auto answer = ask<LoadNode>(node, container + "/_container/load_node", request);
  if (!answer || !answer->success) {
    std::fprintf(stderr, "%s was not loaded: %s\n", plugin.c_str(),
                 answer ? answer->error_message.c_str() : "no answer");
    return false;
  }
  ids.push_back(answer->unique_id);
  return true;
}

}  // namespace

int main(int count, char** words) {
  rclcpp::init(count, words);
  const auto node = std::make_shared<rclcpp::Node>("load_components");
  bool intra_process = false;
  int rounds = 1;
  std::vector<std::string> plugins;
  for (int i = 3; i < count; ++i) {
    const std::string word = words[i];
    if (word == "--intra-process") {
      intra_process = true;
    } else if (word == "--again") {
      rounds = 2;
    } else {
      plugins.push_back(word);
    }
  }
  for (int round = 1; round <= rounds; ++round) {
    std::vector<std::uint64_t> ids;
    for (const std::string& plugin : plugins) {
      if (!load(node, words[1], words[2], plugin, intra_process, ids)) return 1;
    }
    if (round == rounds) break;
    std::this_thread::sleep_for(2s);
    for (const std::uint64_t id : ids) {
      const auto request = std::make_shared<UnloadNode::Request>();
      request->unique_id = id;
      const auto answer = ask<UnloadNode>(node, std::string(words[1]) + "/_container/unload_node", request);
      if (!answer || !answer->success) return 1;
    }
  }
  rclcpp::shutdown();
  return 0;
}
