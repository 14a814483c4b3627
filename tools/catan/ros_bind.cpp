#include "ros_bind.h"

#include <fmt/format.h>
#include <signal.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

#include "base/text.h"
#include "command.h"
#include "common/inferred_app.h"
#include "common/observation.h"
#include "config/app_file.h"
#include "config/cost_file.h"
#include "os/linux/child_process.h"
#include "os/linux/descendants.h"
#include "os/linux/linux_os.h"
#include "os/linux/signal_watch.h"
#include "port_libraries.h"
#include "ros_master.h"
#include "scheduling_options.h"
#include "temporary_folder.h"

namespace ctn::tool {
namespace {

constexpr Nanos kLookAgain = std::chrono::milliseconds{100};
// Until a callback should have been called; until a master should be there.
constexpr Nanos kFirstCallback = std::chrono::seconds{30};
constexpr Nanos kMasterIsThere = std::chrono::seconds{10};
constexpr std::chrono::seconds kAskForLanguages{3};
// For programs that are asked to end, before they are made to.
constexpr Nanos kEndInOrder = std::chrono::seconds{3};
constexpr Nanos kGone = std::chrono::seconds{2};

struct RosBindOptions {
  std::string output = "app.yaml";
  std::string costs = "costs.yaml";
  double seconds = 10.0;
  bool overwrite = false;
  std::vector<std::string> command;
};

Status check_outputs(const RosBindOptions& options) {
  if (options.output == options.costs) {
    return Error::caller("the app file and the cost file have the same name", "give --costs another one");
  }
  for (const std::string& path : {options.output, options.costs}) {
    std::error_code failed;
    if (options.overwrite || !std::filesystem::exists(path, failed)) continue;
    return Error::caller(fmt::format("{} is there already", quote(path)),
                         "name another file with --output and --costs, or let it be replaced: --overwrite");
  }
  return Done{};
}

Status write_file(const std::string& path, const std::string& text) {
  std::ofstream file(path);
  file << text << std::flush;
  if (file) return Done{};
  return Error::caller(fmt::format("{} cannot be written", quote(path)), "name a file in a folder that may be written");
}

// Programs that run while they are observed.
class ObservedPrograms {
 public:
  static Result<std::unique_ptr<ObservedPrograms>> start(const std::vector<std::string>& command);

  // Until callbacks have been observed for so long, or the command ends, or a signal comes. kEnvironment: none is
  // called.
  Status observe(double seconds);
  // Of what ran until now.
  const std::vector<catan_ros::ObservedCallback>& callbacks() const { return callbacks_; }
  const RosMaster& master() const { return master_; }
  // By the command: all that it has started.
  void end();

 private:
  ObservedPrograms(std::unique_ptr<TemporaryFolder> folder, os::SignalWatch signals, os::ChildProcess command)
      : folder_(std::move(folder)), signals_(std::move(signals)), command_(std::move(command)) {}
  bool has_runs() const;
  Error nothing_seen(const std::string& when) const;

  std::unique_ptr<TemporaryFolder> folder_;
  os::SignalWatch signals_;
  os::ChildProcess command_;
  std::unique_ptr<os::Os> os_ = os::make_linux_os();
  RosMaster master_ = RosMaster::from_environment();
  std::vector<catan_ros::ObservedCallback> callbacks_;
};

Result<std::unique_ptr<ObservedPrograms>> ObservedPrograms::start(const std::vector<std::string>& command) {
  auto preload = ros_preload_entry();
  if (!preload) return preload.error();
  auto folder = TemporaryFolder::make("catan-ros-bind");
  if (!folder) return folder.error();
  auto signals = os::SignalWatch::start({SIGINT, SIGTERM, SIGHUP});
  if (!signals) return signals.error();
  os::adopt_orphans();
  auto child = os::ChildProcess::start(
      command, {std::move(*preload), fmt::format("{}={}", catan_ros::kObserveVariable, (*folder)->path())});
  if (!child) return child.error();
  return std::unique_ptr<ObservedPrograms>(
      new ObservedPrograms(std::move(*folder), std::move(*signals), std::move(*child)));
}

bool ObservedPrograms::has_runs() const {
  return std::any_of(callbacks_.begin(), callbacks_.end(), [](const auto& callback) { return !callback.runs.empty(); });
}

// Those that the master knows and that are not observed. Which of them are Python is asked as long as that is quick.
std::vector<std::string> not_observed_of(const RosMaster& master, const catan_ros::Connections& connections,
                                         const std::vector<catan_ros::ObservedCallback>& observed) {
  std::set<std::string> nodes;
  for (const auto* const topics : {&connections.publishers, &connections.subscribers}) {
    for (const auto& [topic, names] : *topics) nodes.insert(names.begin(), names.end());
  }
  nodes.erase("/rosout");
  for (const catan_ros::ObservedCallback& callback : observed) nodes.erase(callback.ros_node);
  std::vector<std::string> shown;
  const auto until = std::chrono::steady_clock::now() + kAskForLanguages;
  for (const std::string& node : nodes) {
    const bool python = std::chrono::steady_clock::now() < until && master.node(node) == RosMaster::Node::kPython;
    shown.push_back(node + (python ? " (Python)" : ""));
  }
  return shown;
}

Error ObservedPrograms::nothing_seen(const std::string& when) const {
  const auto connections = master_.connections();
  if (!connections) return connections.error();
  const std::vector<std::string> nodes = not_observed_of(master_, *connections, callbacks_);
  return Error::environment(
      fmt::format("no callback of a roscpp program was called {}{}", when,
                  nodes.empty() ? "" : fmt::format("; the master knows {}", fmt::join(nodes, ", "))),
      "let COMMAND start the programs, and feed them (rosbag play); programs in Python, linked to roscpp statically, "
      "or "
      "with capabilities of their own cannot be observed");
}

Status ObservedPrograms::observe(double seconds) {
  const TimePoint started = os_->now();
  std::optional<TimePoint> until;
  bool master_seen = false;
  for (;;) {
    os_->sleep_until(os_->now() + kLookAgain);
    const TimePoint now = os_->now();
    const bool stopped = signals_.next().has_value();
    const bool ended = !stopped && command_.wait().has_value();
    if (!until || *until <= now || stopped || ended) callbacks_ = catan_ros::read_observations(folder_->path());
    if (has_runs()) {
      if (!until) until = now + to_nanos(Millis{1000.0 * seconds});
      if (*until <= now || stopped || ended) return Done{};
      continue;
    }
    if (stopped) return nothing_seen("before it was stopped");
    if (ended) return nothing_seen("before COMMAND ended");
    if (now - started >= kFirstCallback) return nothing_seen("in 30 s");
    if (!master_seen && now - started >= kMasterIsThere) {
      const auto connections = master_.connections();
      if (!connections) return connections.error();
      master_seen = true;
    }
  }
}

void ObservedPrograms::end() {
  const auto tell = [](int signal) {
    const std::vector<os::ProcessId> left = os::descendants();
    for (const os::ProcessId process : left) static_cast<void>(::kill(static_cast<int>(process), signal));
    return !left.empty();
  };
  const auto wait_for_all = [this](TimePoint deadline) {
    for (;;) {
      static_cast<void>(command_.wait());
      os::reap_orphans({command_.process()});
      if (os::descendants().empty()) return true;
      if (os_->now() >= deadline) return false;
      os_->sleep_until(os_->now() + std::chrono::milliseconds{10});
    }
  };
  tell(SIGTERM);
  if (wait_for_all(os_->now() + kEndInOrder)) return;
  tell(SIGKILL);
  wait_for_all(os_->now() + kGone);
}

// That of the file, of characters that names may have.
std::string app_name_of(const std::string& path) {
  std::string name = std::filesystem::path(path).stem().string().substr(0, 100);
  const auto may_not_be = [](unsigned char c) { return std::isalnum(c) == 0 && c != '_' && c != '-' && c != '.'; };
  std::replace_if(name.begin(), name.end(), may_not_be, '_');
  return name;
}

// What was written must be what Catan reads.
Status check_written(const catan_ros::InferredApp& inferred, const RosBindOptions& options) {
  const auto app = config::parse_app(inferred.app, options.output);
  if (!app) return app.error();
  const auto costs = config::parse_costs(inferred.costs, options.costs, *app);
  if (!costs) return costs.error();
  return Done{};
}

int bind_app(const RosBindOptions& options) {
  if (const Status fits = check_outputs(options); !fits) return report_error(fits.error());
  auto programs = ObservedPrograms::start(options.command);
  if (!programs) return report_error(programs.error());
  const Status observed = (*programs)->observe(options.seconds);
  // As long as they are there.
  catan_ros::Connections connections;
  std::vector<std::string> not_observed;
  if (observed) {
    if (auto known = (*programs)->master().connections()) {
      not_observed = not_observed_of((*programs)->master(), *known, (*programs)->callbacks());
      connections = std::move(*known);
    }
  }
  (*programs)->end();
  if (!observed) return report_error(observed.error());

  const catan_ros::InferredApp inferred =
      catan_ros::infer_app((*programs)->callbacks(), connections, app_name_of(options.output));
  if (inferred.nodes == 0) {
    return report_error(Error::environment(
        "only callbacks that Catan leaves alone were called: services, transforms, timers that do nothing",
        "let COMMAND start what publishes and takes data, and feed it (rosbag play)"));
  }
  for (const auto& [path, text] : {std::pair(options.output, inferred.app), std::pair(options.costs, inferred.costs)}) {
    if (const Status written = write_file(path, text); !written) return report_error(written.error());
  }
  for (const std::string& remark : inferred.remarks) note(remark);
  if (!not_observed.empty()) {
    note(fmt::format("not observed, so external where they take part: {}", fmt::join(not_observed, ", ")));
  }
  if (const Status fits = check_written(inferred, options); !fits) return report_error(fits.error());
  print(
      fmt::format("{0}: {2} nodes; set the weights of its objective, they are all 1\n"
                  "{1}: what their runs cost\n"
                  "next: catan plan {0} --costs {1} --cores N\n",
                  options.output, options.costs, inferred.nodes));
  return kSuccess;
}

}  // namespace

void add_ros_bind_command(CLI::App& ros, int& exit_code) {
  auto options = std::make_shared<RosBindOptions>();
  CLI::App* command = ros.add_subcommand("bind", "Write a first app file, from ROS 1 programs that run");
  command->footer(
      "Examples:\n"
      "  catan ros bind -- roslaunch my_robot all.launch    starts it, looks for 10 s, ends it; app.yaml, costs.yaml\n"
      "  catan ros bind --seconds 60 --output robot.yaml --costs robot.costs.yaml -- ./all.sh\n"
      "Programs run as without Catan meanwhile. A callback of a topic or timer that is called becomes a node, "
      "messages\n"
      "become edges, what Python nodes publish comes from external nodes. The weights are left to you: all are 1.\n"
      "Exit code: 0 it is written, 1 failure at run time, 2 a mistake.");
  command->add_option("--seconds", options->seconds, "How long to look, from the first callback on")
      ->check(within(0.1, 3600.0))
      ->capture_default_str();
  command->add_option("--output", options->output, "App file to write")->type_name("FILE")->capture_default_str();
  command->add_option("--costs", options->costs, "Cost file to write (docs/cost-file.md)")
      ->type_name("FILE")
      ->capture_default_str();
  command->add_flag("--overwrite", options->overwrite, "Replace files that are there");
  command->add_option("COMMAND", options->command, "Starts the programs: roslaunch, rosrun, a script")
      ->type_name("-- COMMAND...")
      ->required();
  command->callback([options, &exit_code] { exit_code = bind_app(*options); });
}

}  // namespace ctn::tool
