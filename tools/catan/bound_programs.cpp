#include "bound_programs.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <utility>

#include "base/text.h"
#include "command.h"
#include "runtime/socket_path.h"
#include "serving_programs.h"
#include "temporary_folder.h"

namespace ctn::tool {
namespace {

// After which a node that is bound should have run.
constexpr double kAllShouldRun = 10.0;

// --- What programs are told ---

const ProgramCallback* find_bound(const std::vector<ProgramCallback>& callbacks, NodeId node) {
  const auto found =
      std::find_if(callbacks.begin(), callbacks.end(), [&](const ProgramCallback& one) { return one.node == node; });
  return found == callbacks.end() ? nullptr : &*found;
}

// What the successors of a node take from topics, if all of them do; else nothing: then whatever it publishes counts.
std::vector<std::string> output_topics(const graph::Graph& graph, NodeId node,
                                       const std::vector<ProgramCallback>& callbacks) {
  std::vector<std::string> topics;
  for (const NodeId successor : graph.node(node).successors) {
    const ProgramCallback* const bound = find_bound(callbacks, successor);
    if (bound == nullptr || bound->kind != catan_ros::Binding::Kind::kTopic) return {};
    if (std::find(topics.begin(), topics.end(), bound->name) == topics.end()) topics.push_back(bound->name);
  }
  return topics;
}

// Whether all that take its data are callbacks of the same program, and of the same nodelet as far as that is said:
// nodelets share no memory but that of messages.
bool feeds_own_program(const graph::Graph& graph, const ProgramCallback& callback,
                       const std::vector<ProgramCallback>& callbacks) {
  const std::vector<NodeId>& successors = graph.node(callback.node).successors;
  return !successors.empty() && std::all_of(successors.begin(), successors.end(), [&](NodeId successor) {
    const ProgramCallback* const bound = find_bound(callbacks, successor);
    if (bound == nullptr || bound->program != callback.program) return false;
    return bound->nodelet.empty() || callback.nodelet.empty() || bound->nodelet == callback.nodelet;
  });
}

std::vector<catan_ros::Binding> told_bindings(const graph::Graph& graph,
                                              const std::vector<ProgramCallback>& callbacks) {
  std::vector<catan_ros::Binding> told;
  for (const ProgramCallback& callback : callbacks) {
    const graph::Node& node = graph.node(callback.node);
    catan_ros::Binding one;
    one.node = node.name;
    one.ros_node = callback.program;
    one.nodelet = callback.nodelet;
    one.kind = callback.kind;
    one.name = callback.name;
    one.period = callback.period;
    one.takes_all = node.input == graph::InputKind::kQueue;
    one.runs_by_itself = node.unscheduled && !node.follows;
    one.always_gives_output = std::all_of(node.successors.begin(), node.successors.end(),
                                          [&](NodeId successor) { return graph.node(successor).external; });
    one.feeds_own_program = feeds_own_program(graph, callback, callbacks);
    one.is_behind = node.subchain && graph.subchain(*node.subchain).head() != callback.node;
    for (const NodeId predecessor : node.predecessors) {
      if (!graph.node(predecessor).external) one.predecessors.push_back(graph.node(predecessor).name);
    }
    for (const NodeId successor : node.successors) {
      if (find_bound(callbacks, successor) != nullptr) one.successors.push_back(graph.node(successor).name);
    }
    one.output_topics = callback.outputs.value_or(output_topics(graph, callback.node, callbacks));
    told.push_back(std::move(one));
  }
  return told;
}

Result<std::vector<std::string>> environment_of(const graph::Graph& graph, const BoundPrograms& programs,
                                                const std::string& socket) {
  auto environment = programs.environment(std::filesystem::absolute(socket).string());
  if (!environment) return environment;
  environment->push_back(
      fmt::format("{}={}", programs.bindings_variable, catan_ros::to_text(told_bindings(graph, programs.callbacks))));
  return environment;
}

// --- Running ---

// Tells, once, which bound nodes have not run when all should have.
class Missing {
 public:
  Missing(const graph::Graph& graph, const BoundPrograms& programs) : graph_(graph), programs_(programs) {}

  // Twice a second.
  void look(const Snapshot& snapshot) {
    if (++looks_ != static_cast<int>(2.0 * kAllShouldRun)) return;
    for (const ProgramCallback& callback : programs_.callbacks) {
      const std::string& name = graph_.node(callback.node).name;
      const auto node = std::find_if(snapshot.nodes.begin(), snapshot.nodes.end(),
                                     [&](const NodeSnapshot& one) { return one.name == name; });
      if (node == snapshot.nodes.end() || node->compute_ms.count > 0) continue;
      note(fmt::format("node {} has not run in {} s: {}, or a node of the same subchain is missing; the others go on",
                       name, kAllShouldRun, programs_.why_missing(callback.program)));
    }
  }

 private:
  const graph::Graph& graph_;
  const BoundPrograms& programs_;
  int looks_ = 0;
};

// A server is there: the command takes the place of this process, so signals and its exit code are its own.
int join(const BoundProgramsOptions& options, const std::vector<std::string>& environment) {
  for (const std::string& entry : environment) {
    const std::size_t equals = entry.find('=');
    ::setenv(entry.substr(0, equals).c_str(), entry.c_str() + equals + 1, 1);
  }
  ::setenv(runtime::kSocketVariable, std::filesystem::absolute(options.socket).c_str(), 1);
  std::vector<char*> words;
  for (const std::string& word : options.command) words.push_back(const_cast<char*>(word.c_str()));
  words.push_back(nullptr);
  ::execvp(words[0], words.data());
  return report_error(Error::caller(fmt::format("{} cannot be started", quote(options.command[0])),
                                    "name a program that is there, with its path or in PATH"));
}

}  // namespace

void BoundProgramsOptions::add_to(CLI::App& command_line, const std::string& starts) {
  command_line.add_option("APP", app, "App file (docs/app-file.md)")->required();
  command_line.add_option("--socket", socket, "Join the server that listens there, in place of a server of its own")
      ->type_name("PATH");
  command_line.add_option("--seconds", seconds, "How long to measure, after the warm-up; else as long as COMMAND runs")
      ->check(within(0.1, 864'000.0));
  scheduling.add_to(command_line);
  watched.add_to(command_line);
  command_line.add_option("COMMAND", command, starts)->type_name("-- COMMAND...")->required();
  command_line.add_flag("--json", json, "Print one JSON document");
}

int run_bound_programs(const config::AppFile& file, const BoundProgramsOptions& options,
                       const BoundPrograms& programs) {
  if (!options.socket.empty()) {
    const auto environment = environment_of(file.app.graph, programs, options.socket);
    return environment ? join(options, *environment) : report_error(environment.error());
  }
  if (Status fits = options.watched.check(file.app, options.scheduling.flight_recorder_mib); !fits) {
    return report_error(fits.error());
  }
  const auto folder = TemporaryFolder::make("catan-run");
  if (!folder) return report_error(folder.error());
  ServingOptions serving;
  serving.socket = (*folder)->path() + "/socket";
  auto environment = environment_of(file.app.graph, programs, serving.socket);
  if (!environment) return report_error(environment.error());
  const std::string record_path =
      options.scheduling.record.empty() ? (*folder)->path() + "/run.catan" : options.scheduling.record;
  serving.commands = {options.command};
  serving.environment = std::move(*environment);
  serving.seconds = options.seconds;
  serving.prints_data = options.json;
  Missing missing(file.app.graph, programs);
  const auto served = serve_programs(file, options.scheduling, options.watched, record_path, std::move(serving),
                                     fmt::format("{}", fmt::join(options.command, " ")),
                                     [&missing](const Snapshot& snapshot) { missing.look(snapshot); });
  if (!served) return report_error(served.error());
  return show_served(*served, record_path, options.json);
}

}  // namespace ctn::tool
