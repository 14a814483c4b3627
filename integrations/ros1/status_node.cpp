// The ROS node of `catan ros node`: tells ROS's own tools of the app, and lets them change it (docs/ros1.md). A library
// that the command loads, so that the command needs no ROS.
#include "ros1/status_node.h"

#include <diagnostic_msgs/DiagnosticArray.h>
#include <dynamic_reconfigure/ConfigDescription.h>
#include <dynamic_reconfigure/Reconfigure.h>
#include <ros/callback_queue.h>
#include <ros/master.h>
#include <ros/ros.h>
#include <std_msgs/Float64.h>
#include <std_msgs/String.h>

#include <algorithm>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace catan_ros {
namespace {

constexpr double kEverySeconds = 1.0;
constexpr double kLookAtMasterEverySeconds = 2.0;
constexpr double kMaxSetting = 1e6;  // what a slider ends at
constexpr const char* kGroup = "Default";

std_msgs::String message_of(const std::string& text) {
  std_msgs::String message;
  message.data = text;
  return message;
}

diagnostic_msgs::DiagnosticStatus message_of(const Diagnostic& diagnostic) {
  diagnostic_msgs::DiagnosticStatus status;
  status.name = "catan: " + diagnostic.name;
  status.hardware_id = "catan";
  status.level = static_cast<signed char>(diagnostic.level);
  status.message = diagnostic.message;
  for (const auto& [key, value] : diagnostic.values) {
    diagnostic_msgs::KeyValue pair;
    pair.key = key;
    pair.value = value;
    status.values.push_back(pair);
  }
  return status;
}

// Settings as dynamic_reconfigure's tools have them: one group of numbers.
dynamic_reconfigure::Config config_of(const std::vector<Setting>& settings, double (*value)(const Setting&)) {
  dynamic_reconfigure::Config config;
  for (const Setting& setting : settings) {
    dynamic_reconfigure::DoubleParameter parameter;
    parameter.name = setting.name;
    parameter.value = value(setting);
    config.doubles.push_back(parameter);
  }
  dynamic_reconfigure::GroupState group;
  group.name = kGroup;
  group.state = true;
  config.groups.push_back(group);
  return config;
}

dynamic_reconfigure::Config config_of(const std::vector<Setting>& settings) {
  return config_of(settings, [](const Setting& setting) { return setting.value; });
}

dynamic_reconfigure::ConfigDescription description_of(const std::vector<Setting>& settings) {
  dynamic_reconfigure::ConfigDescription description;
  dynamic_reconfigure::Group group;
  group.name = kGroup;
  for (const Setting& setting : settings) {
    dynamic_reconfigure::ParamDescription parameter;
    parameter.name = setting.name;
    parameter.type = "double";
    parameter.description = setting.description;
    group.parameters.push_back(parameter);
  }
  description.groups.push_back(group);
  description.min = config_of(settings, [](const Setting&) { return 0.0; });
  description.max = config_of(settings, [](const Setting&) { return kMaxSetting; });
  description.dflt = config_of(settings);
  return description;
}

bool same_names(const std::vector<Setting>& one, const std::vector<Setting>& other) {
  if (one.size() != other.size()) return false;
  for (std::size_t index = 0; index < one.size(); ++index) {
    if (one[index].name != other[index].name) return false;
  }
  return true;
}

class StatusNode {
 public:
  StatusNode(ShownApp& app, bool allow_control)
      : app_(app),
        own_("~"),
        diagnostics_(handle_.advertise<diagnostic_msgs::DiagnosticArray>("/diagnostics", 10)),
        live_(own_.advertise<std_msgs::String>("live", 1)),
        plan_(own_.advertise<std_msgs::String>("plan", 1, true)),
        descriptions_(own_.advertise<dynamic_reconfigure::ConfigDescription>("parameter_descriptions", 1, true)),
        updates_(own_.advertise<dynamic_reconfigure::Config>("parameter_updates", 1, true)),
        timer_(own_.createWallTimer(ros::WallDuration(kEverySeconds), [this](const ros::WallTimerEvent&) { tell(); })) {
    if (allow_control) service_ = own_.advertiseService("set_parameters", &StatusNode::change, this);
    tell();
  }

 private:
  void tell() {
    const AppStatus status = app_.read();
    diagnostic_msgs::DiagnosticArray diagnostics;
    diagnostics.header.stamp = ros::Time::now();
    for (const Diagnostic& diagnostic : status.diagnostics) diagnostics.status.push_back(message_of(diagnostic));
    diagnostics_.publish(diagnostics);
    if (!status.live.empty()) live_.publish(message_of(status.live));
    if (status.plan != told_plan_ && !status.plan.empty()) plan_.publish(message_of(told_plan_ = status.plan));
    for (const ResponseTime& response : status.response_times) {
      tell(response.name + "/mean_ms", response.mean_ms);
      tell(response.name + "/p95_ms", response.p95_ms);
    }
    if (!status.settings.empty()) tell(status.settings);
  }

  void tell(const std::string& figure, const std::optional<double>& value) {
    const auto [entry, is_new] = figures_.try_emplace(figure);
    if (is_new) entry->second = own_.advertise<std_msgs::Float64>("response_time/" + figure, 10);
    if (!value) return;
    std_msgs::Float64 message;
    message.data = *value;
    entry->second.publish(message);
  }

  void tell(const std::vector<Setting>& settings) {
    const bool others = !same_names(settings, settings_);
    const dynamic_reconfigure::Config config = config_of(settings);
    if (others) descriptions_.publish(description_of(settings));
    if (others || config.doubles != config_of(settings_).doubles) updates_.publish(config);
    settings_ = settings;
  }

  // False, so that the caller sees a failure: nothing has changed.
  bool change(dynamic_reconfigure::Reconfigure::Request& request,
              dynamic_reconfigure::Reconfigure::Response& response) {
    std::vector<std::pair<std::string, double>> values;
    for (const auto& parameter : request.config.doubles) values.emplace_back(parameter.name, parameter.value);
    // A value such as 5 comes as an integer from a command line.
    for (const auto& parameter : request.config.ints) values.emplace_back(parameter.name, parameter.value);
    const std::string refused = app_.change(values);
    if (!refused.empty()) {
      ROS_ERROR("catan: %s", refused.c_str());
      return false;
    }
    tell();
    response.config = config_of(settings_);
    return true;
  }

  ShownApp& app_;
  ros::NodeHandle handle_;
  ros::NodeHandle own_;
  ros::Publisher diagnostics_;
  ros::Publisher live_;
  ros::Publisher plan_;
  ros::Publisher descriptions_;
  ros::Publisher updates_;
  ros::WallTimer timer_;
  ros::ServiceServer service_;
  std::map<std::string, ros::Publisher> figures_;
  std::string told_plan_;
  std::vector<Setting> settings_;
};

// A master has come that does not know this node: the one that it registered with has ended. Without a master: no.
bool is_unknown_to_master() {
  ros::V_string nodes;
  if (!ros::master::check() || !ros::master::getNodes(nodes)) return false;
  return std::find(nodes.begin(), nodes.end(), ros::this_node::getName()) == nodes.end();
}

// Until the node has to register again, or the process is to end.
void spin() {
  do {
    const ros::WallTime look_at = ros::WallTime::now() + ros::WallDuration(kLookAtMasterEverySeconds);
    while (ros::ok() && ros::WallTime::now() < look_at) {
      ros::getGlobalCallbackQueue()->callAvailable(ros::WallDuration(0.1));
    }
  } while (ros::ok() && !is_unknown_to_master());
}

}  // namespace
}  // namespace catan_ros

extern "C" void catan_ros1_run_status_node(int& argc, char** argv, catan_ros::ShownApp& app, bool allow_control) {
  ros::init(argc, argv, "catan");
  const ros::NodeHandle handle;  // waits for the master; ended by a signal meanwhile
  if (!ros::ok()) return;
  while (ros::ok()) {
    const catan_ros::StatusNode node(app, allow_control);
    catan_ros::spin();
  }
}
