// What tests see of the node /catan.
//   ros1_status_listener FILE          keeps FILE up to date: a JSON document of what was published last
//   ros1_status_listener --set NAME=VALUE...   asks it to change settings; exit code 1: it refused
#include <diagnostic_msgs/DiagnosticArray.h>
#include <dynamic_reconfigure/Config.h>
#include <dynamic_reconfigure/ConfigDescription.h>
#include <dynamic_reconfigure/Reconfigure.h>
#include <ros/ros.h>
#include <std_msgs/Float64.h>
#include <std_msgs/String.h>

#include <cstdio>
#include <fstream>
#include <map>
#include <string>

#include <nlohmann/json.hpp>

namespace {

using Json = nlohmann::json;

class Listener {
 public:
  explicit Listener(std::string file) : file_(std::move(file)) {
    subscribers_["diagnostics"] = handle_.subscribe<diagnostic_msgs::DiagnosticArray>(
        "/diagnostics", 10, [this](const diagnostic_msgs::DiagnosticArray::ConstPtr& array) {
          Json all;
          for (const auto& status : array->status) {
            all[status.name] = {{"level", static_cast<int>(status.level)}, {"message", status.message}};
            for (const auto& value : status.values) all[status.name]["values"][value.key] = value.value;
          }
          seen_["diagnostics"] = all;
        });
    for (const char* const document : {"plan", "live"}) {
      subscribers_[document] = handle_.subscribe<std_msgs::String>(
          std::string("/catan/") + document, 10,
          [this, document](const std_msgs::String::ConstPtr& text) { seen_[document] = Json::parse(text->data); });
    }
    subscribers_["updates"] = handle_.subscribe<dynamic_reconfigure::Config>(
        "/catan/parameter_updates", 10, [this](const dynamic_reconfigure::Config::ConstPtr& config) {
          for (const auto& parameter : config->doubles) seen_["settings"][parameter.name] = parameter.value;
        });
    subscribers_["descriptions"] = handle_.subscribe<dynamic_reconfigure::ConfigDescription>(
        "/catan/parameter_descriptions", 10,
        [this](const dynamic_reconfigure::ConfigDescription::ConstPtr& description) {
          for (const auto& parameter : description->groups.at(0).parameters) {
            seen_["described"][parameter.name] = parameter.description;
          }
        });
    timer_ = handle_.createWallTimer(ros::WallDuration(0.2), [this](const ros::WallTimerEvent&) { look(); });
  }

 private:
  void look() {
    ros::master::V_TopicInfo topics;
    ros::master::getTopics(topics);
    for (const ros::master::TopicInfo& topic : topics) {
      const std::string& name = topic.name;
      if (name.rfind("/catan/response_time/", 0) != 0 || subscribers_.count(name) > 0) continue;
      subscribers_[name] = handle_.subscribe<std_msgs::Float64>(
          name, 10,
          [this, name](const std_msgs::Float64::ConstPtr& value) { seen_["response_times"][name] = value->data; });
    }
    std::ofstream(file_ + ".new") << seen_;
    std::rename((file_ + ".new").c_str(), file_.c_str());
  }

  const std::string file_;
  ros::NodeHandle handle_;
  std::map<std::string, ros::Subscriber> subscribers_;
  ros::WallTimer timer_;
  Json seen_ = Json::object();
};

int set(int count, char** settings) {
  dynamic_reconfigure::Reconfigure call;
  for (int index = 0; index < count; ++index) {
    const std::string text = settings[index];
    dynamic_reconfigure::DoubleParameter parameter;
    parameter.name = text.substr(0, text.find('='));
    parameter.value = std::stod(text.substr(text.find('=') + 1));
    call.request.config.doubles.push_back(parameter);
  }
  return ros::service::waitForService("/catan/set_parameters", 1500) &&
                 ros::service::call("/catan/set_parameters", call)
             ? 0
             : 1;
}

}  // namespace

int main(int argc, char** argv) {
  ros::init(argc, argv, "listener", ros::init_options::AnonymousName);
  if (argc < 2) return 2;
  if (std::string(argv[1]) == "--set") {
    const ros::NodeHandle handle;
    return set(argc - 2, argv + 2);
  }
  const Listener listener(argv[1]);
  ros::spin();
  return 0;
}
