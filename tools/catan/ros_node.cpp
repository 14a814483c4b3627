#include "ros_node.h"

#include <dlfcn.h>
#include <fmt/format.h>

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "attach.h"
#include "command.h"
#include "common/app_status.h"
#include "live_source.h"
#include "os/linux/background.h"
#include "os/linux/linux_os.h"
#include "port_libraries.h"
#include "ros1/status_node.h"

namespace ctn::tool {
namespace {

struct RosNodeOptions {
  std::vector<std::string> words;
  bool allow_control = false;
};

class RosShownApp final : public catan_ros::ShownApp {
 public:
  explicit RosShownApp(LiveSource& source) : source_(source) {}

  catan_ros::AppStatus read() override {
    catan_ros::AppStatus status;
    const Result<std::string> live = source_.live();
    if (!live) {
      status.diagnostics.push_back(catan_ros::diagnostic_of_no_app(live.error().message()));
      return status;
    }
    status.live = *live;
    const auto document = nlohmann::json::parse(*live);
    status.diagnostics = catan_ros::diagnostics_of(document);
    status.response_times = catan_ros::response_times_of(document);
    if (const Result<std::string> plan = source_.plan()) status.plan = *plan;
    if (auto settings = settings_now()) status.settings = std::move(*settings);
    return status;
  }

  std::string change(const std::vector<std::pair<std::string, double>>& values) override {
    const auto settings = settings_now();
    if (!settings) return settings.error().message();
    std::vector<std::string> unknown;
    const Changes changes = catan_ros::changes_to(*settings, values, unknown);
    if (!unknown.empty()) return fmt::format("there is no setting {}", fmt::join(unknown, ", "));
    if (changes == Changes{}) return "";
    const Status done = source_.change(changes);
    return done ? "" : done.error().message();
  }

 private:
  Result<std::vector<catan_ros::Setting>> settings_now() {
    const Result<std::string> text = source_.snapshot();
    if (!text) return text.error();
    const auto status = nlohmann::json::parse(*text, nullptr, false);
    if (status.is_discarded()) return Error::environment("the server's answer was not understood", "ask again");
    return catan_ros::settings_of(status);
  }

  LiveSource& source_;
};

// The function kRunStatusNode of the library.
Result<void*> load_node() {
  const auto library = find_ros_library(catan_ros::kStatusNodeLibrary);
  if (!library) return library.error();
  void* const loaded = ::dlopen(library->c_str(), RTLD_NOW | RTLD_LOCAL);
  void* const function = loaded == nullptr ? nullptr : ::dlsym(loaded, catan_ros::kRunStatusNode);
  if (function == nullptr) {
    return Error::environment(fmt::format("{} cannot be loaded: {}", *library, ::dlerror()),
                              "install roscpp (scripts/setup.sh --ros1), and build and install Catan again");
  }
  return function;
}

Status run_node(const RosNodeOptions& options) {
  std::string target;
  std::vector<std::string> for_ros{"catan"};
  for (const std::string& word : options.words) {
    if (word.find(":=") != std::string::npos) {
      for_ros.push_back(word);
    } else if (target.empty()) {
      target = word;
    } else {
      return Error::caller(fmt::format("there are two targets, '{}' and '{}'", target, word), "name one app");
    }
  }
  const auto run = load_node();
  if (!run) return run.error();
  os::yield_to_others();
  const std::unique_ptr<os::Os> os = os::make_linux_os();
  LiveSource source(*os, target);
  // The app may come later, as a launch file starts all at once.
  if (const Status found = source.look(); !found) note(found.error().message());
  if (const auto scheduled = source.cpus()) keep_off_scheduled_cpus(*os, *scheduled);
  RosShownApp app(source);
  std::vector<char*> words;
  for (std::string& word : for_ros) words.push_back(word.data());
  words.push_back(nullptr);
  int count = static_cast<int>(for_ros.size());
  const auto run_node_of_ros = reinterpret_cast<catan_ros::RunStatusNode>(*run);
  run_node_of_ros(count, words.data(), app, options.allow_control);
  return Done{};
}

}  // namespace

void add_ros_node_command(CLI::App& ros, int& exit_code) {
  auto options = std::make_shared<RosNodeOptions>();
  CLI::App* command = ros.add_subcommand("node", "Show the app to ROS's own tools, as the node /catan");
  command->footer(
      "Examples:\n"
      "  catan ros node                     the only app that Catan schedules here\n"
      "  catan ros node /run/robot.sock     a server by its socket; or by the name of its app, or its app file\n"
      "  catan ros node --allow-control     weights and bounds can be changed: rqt_reconfigure, dynparam\n"
      "  catan ros node __name:=other       remappings, as roslaunch gives them\n"
      "It publishes /diagnostics, response times and the plan; docs/ros1.md lists topics and settings. It waits for "
      "the\n"
      "app and for the ROS master, runs at the ordinary level, on CPUs that no node may use where there are any. With\n"
      "--allow-control whoever reaches the master can change the app: ROS 1 knows no users.\n"
      "Exit code: 0 it was told to end, 1 ROS 1 is not there, 2 a mistake.");
  command->add_option("TARGET", options->words,
                      "A server's socket, an app file, the name of an app, or the number of a process");
  command->add_flag("--allow-control", options->allow_control, "Offer the service that changes weights and bounds");
  command->callback([options, &exit_code] {
    const Status done = run_node(*options);
    exit_code = done ? kSuccess : report_error(done.error());
  });
}

}  // namespace ctn::tool
