// catan ctl: controls a server while it schedules an app.
#include <fmt/format.h>

#include <charconv>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "attach.h"
#include "base/text.h"
#include "catan/changes.h"
#include "command.h"
#include "config/app_file.h"
#include "config/quantity.h"
#include "os/cpu_set.h"
#include "os/linux/linux_os.h"
#include "runtime/control.h"
#include "table.h"

namespace ctn::tool {
namespace {

constexpr const char* kWhyDumped = "catan ctl dump";

struct CtlOptions {
  std::string server;
  std::string action;
  std::vector<std::string> arguments;
  bool json = false;
};

Result<double> number_of(const std::string& text) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error == std::errc() && end == text.data() + text.size()) return value;
  return Error::caller(fmt::format("{} is no number", quote(text)), "write one from 0 up, as in 0.5");
}

Result<std::optional<double>> milliseconds_of(const std::string& text) {
  if (text == "none") return std::optional<double>();
  const Result<Nanos> duration = config::parse_duration(text);
  if (!duration) return duration.error();
  return std::optional(to_millis(*duration).count());
}

Result<std::optional<double>> hertz_of(const std::string& text) {
  if (text == "none") return std::optional<double>();
  const Result<Rate> rate = config::parse_rate(text);
  if (!rate) return rate.error();
  return std::optional(rate->hertz());
}

// Reads pairs of what is changed and its new value; all that cannot be read is told at once.
template <class Value, class Add>
Status read_pairs(const CtlOptions& options, Result<Value> (*read)(const std::string&), const Add& add) {
  const std::vector<std::string>& arguments = options.arguments;
  if (arguments.empty() || arguments.size() % 2 != 0) {
    return Error::caller(fmt::format("'{}' takes pairs of a name and a value", options.action),
                         "see the examples of catan ctl --help");
  }
  std::vector<Problem> problems;
  for (std::size_t index = 0; index < arguments.size(); index += 2) {
    const Result<Value> value = read(arguments[index + 1]);
    if (value) {
      add(arguments[index], *value);
      continue;
    }
    for (Problem problem : value.error().problems()) {
      problem.key = printable(arguments[index]);
      problems.push_back(std::move(problem));
    }
  }
  if (!problems.empty()) return Error(ErrorKind::kCaller, std::move(problems));
  return Done{};
}

Status read_cpus(const CtlOptions& options, Changes& changes) {
  if (options.arguments.size() != 1) return Error::caller("'cpus' takes one list of CPUs", "write it as in 0-1,3");
  const Result<os::CpuSet> cpus = os::parse_cpu_list(options.arguments.front());
  if (!cpus) return cpus.error();
  changes.cpus = cpus->cpus();
  return Done{};
}

Result<Changes> changes_of(const CtlOptions& options) {
  Changes changes;
  Status done = Done{};
  if (options.action == "cpus") {
    done = read_cpus(options, changes);
  } else if (options.action == "weight") {
    done = read_pairs<double>(options, number_of, [&](const std::string& term, double weight) {
      changes.weights.push_back({term, weight});
    });
  } else if (options.action == "max") {
    done = read_pairs<std::optional<double>>(options, milliseconds_of,
                                             [&](const std::string& term, std::optional<double> max) {
                                               changes.maxes.push_back({term, max});
                                             });
  } else {
    done =
        read_pairs<std::optional<double>>(options, hertz_of, [&](const std::string& node, std::optional<double> rate) {
          changes.min_rates.push_back({node, rate});
        });
  }
  if (!done) return done.error();
  return changes;
}

// --- The status, for people ---

using Json = nlohmann::ordered_json;

std::string figure_text(const Json& value) {
  return value.is_number() ? fmt::format("{:.4g}", value.get<double>()) : "-";
}

std::string list_text(const Json& values) {
  std::vector<int> numbers;
  for (const Json& value : values) numbers.push_back(value.get<int>());
  return os::to_string(os::CpuSet(std::move(numbers)));
}

std::string status_page(const Json& status) {
  std::string text =
      fmt::format("scheduler {}, {}, CPUs {}{}; {} plans, {} changes\n", status.at("policy").get<std::string>(),
                  status.at("real_time").get<bool>() ? "real-time levels" : "ordinary levels",
                  list_text(status.at("cpus")), status.at("warmed_up").get<bool>() ? "" : ", warming up",
                  status.at("plans").get<std::uint64_t>(), status.at("changes").get<std::uint64_t>());
  Table terms({"term", "weight", "bound ms", "response ms", "p95", "predicted"});
  std::size_t chain = 0;
  std::size_t index = 0;
  for (const Json& term : status.at("objective")) {
    const std::string name = fmt::format("{}: {}", index++, printable(term.at("term").get<std::string>()));
    std::vector<std::string> row{name, figure_text(term.at("weight")), figure_text(term.at("max_ms"))};
    if (term.at("term").get<std::string>().starts_with("period of ")) {
      row.insert(row.end(), {"", "", ""});
    } else {
      const Json& measured = status.at("chains").at(chain++);
      const Json& response = measured.at("response_ms");
      const bool any = response.at("count").get<std::uint64_t>() > 0;
      row.push_back(any ? figure_text(response.at("mean")) : "-");
      row.push_back(any ? figure_text(response.at("p95")) : "-");
      row.push_back(figure_text(measured.at("predicted_response_ms")));
    }
    terms.add(std::move(row));
  }
  Table nodes({"node", "Hz", "min Hz", "compute ms", "p95"});
  for (const Json& node : status.at("nodes")) {
    const Json& compute = node.at("compute_ms");
    nodes.add({printable(node.at("name").get<std::string>()), figure_text(node.at("rate_hz")),
               figure_text(node.at("min_rate_hz")), figure_text(compute.at("mean")), figure_text(compute.at("p95"))});
  }
  text += "\n" + terms.text() + "\n" + nodes.text();
  for (const Json& notice : status.at("notices")) text += "! " + printable(notice.get<std::string>()) + "\n";
  return text;
}

Status show_status(os::Os& os, const runtime::ServerAddress& server, const CtlOptions& options) {
  if (!options.arguments.empty()) return Error::caller("'status' takes no arguments", "leave them out");
  const Result<std::string> status = runtime::ask_for_status(os, server);
  if (!status) return status.error();
  if (options.json) {
    print(*status + "\n");
    return Done{};
  }
  try {
    print(status_page(Json::parse(*status)));
  } catch (const Json::exception&) {
    return Error::environment("the server's status was not understood", "let `catan` and the server be of one version");
  }
  return Done{};
}

// In this process: it costs the server nothing.
Status dump(os::Os& os, const CtlOptions& options) {
  if (options.arguments.size() != 1) return Error::caller("'dump' takes one file, which is not there yet", "name it");
  const Result<flight::Recording> recording = attach(os, options.server);
  if (!recording) return recording.error();
  return recording->save(options.arguments.front(), kWhyDumped, os.host_facts());
}

Status control(const CtlOptions& options) {
  const bool asks = options.action == "status";
  if (options.json && !asks) return Error::caller("--json is for 'status'", "leave it out");
  const std::unique_ptr<os::Os> os = os::make_linux_os();
  if (options.action == "dump") return dump(*os, options);
  Changes changes;
  if (!asks) {
    Result<Changes> read = changes_of(options);
    if (!read) return read.error();
    changes = std::move(*read);
  }
  const Result<runtime::ServerAddress> server = address_of(options.server);
  if (!server) return server.error();
  return asks ? show_status(*os, *server, options) : runtime::ask_to_change(*os, *server, changes);
}

}  // namespace

void add_ctl_command(CLI::App& cli, int& exit_code) {
  auto options = std::make_shared<CtlOptions>();
  CLI::App* command = cli.add_subcommand("ctl", "Change CPUs, weights and bounds of an app while it is served");
  command->footer(
      "Examples:\n"
      "  catan ctl app.yaml status                        what it does at present; --json for programs\n"
      "  catan ctl robot cpus 0-1                         of the CPUs that the server was started with\n"
      "  catan ctl robot weight 'scan -> LM -> LP' 0.5    a chain of the objective, or its number: weight 0 0.5\n"
      "  catan ctl robot max 0 100ms 1 none               bounds of response times\n"
      "  catan ctl robot min-rate GM 2Hz                  the lowest rate of a node\n"
      "  catan ctl /run/catan/robot.sock status\n"
      "  catan ctl robot dump last.catan                  the last seconds, as a record (catan report last.catan)\n"
      "Only root and the user that the server runs as may do this. A new plan follows at once; the record of the run\n"
      "and its status say what was changed, and the app file stays as it is. What is wrong changes nothing.\n"
      "Exit code: 0 it is done, 1 no server answers, 2 a mistake, or the server refuses it; of dump, no such app "
      "runs.");
  command
      ->add_option("SERVER", options->server,
                   "Its socket, its app file, or the name of its app; to dump, a process, too")
      ->required();
  command->add_option("ACTION", options->action, "What to do")
      ->required()
      ->check(CLI::IsMember({"status", "cpus", "weight", "max", "min-rate", "dump"}));
  command->add_option("ARGUMENT", options->arguments, "As in the examples");
  command->add_flag("--json", options->json, "The status as JSON: the fields of ctn::Snapshot");
  command->callback([options, &exit_code] {
    const Status done = control(*options);
    exit_code = done ? kSuccess : report_error(done.error());
  });
}

}  // namespace ctn::tool
