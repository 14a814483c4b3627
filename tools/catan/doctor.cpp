// catan doctor: is this machine fit for real-time scheduling, and what should be changed?
#include <fmt/format.h>

#include <array>
#include <memory>
#include <string>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "command.h"
#include "doctor/checks.h"
#include "doctor/checkup.h"
#include "os/linux/linux_os.h"
#include "table.h"

namespace ctn::tool {
namespace {

using Json = nlohmann::ordered_json;

struct DoctorOptions {
  std::string cpus;
  bool json = false;
};

double micros(Nanos duration) { return static_cast<double>(duration.count()) / 1000.0; }

Json finding_json(const doctor::Finding& finding) {
  return {{"check", finding.check}, {"verdict", to_string(finding.verdict)},
          {"found", finding.found}, {"meaning", finding.meaning},
          {"mend", finding.hint},   {"lines", finding.lines}};
}

Json wake_ups_json(const std::vector<doctor::WakeUps>& each, os::Level level) {
  Json all = Json::array();
  for (const doctor::WakeUps& one : each) {
    all.push_back({{"cpu", one.cpu},
                   {"level", to_string(level)},
                   {"count", one.lateness.size()},
                   {"p50_us", micros(one.percentile(50.0))},
                   {"p99_us", micros(one.percentile(99.0))},
                   {"max_us", micros(one.percentile(100.0))}});
  }
  return all;
}

std::string as_json(const doctor::Observed& observed, const std::vector<doctor::Finding>& findings) {
  Json json{{"hinders", worst(findings) == doctor::Verdict::kProblem}, {"verdict", to_string(worst(findings))}};
  json["cpus"] = observed.cpus.cpus();
  json["checks"] = Json::array();
  for (const doctor::Finding& finding : findings) json["checks"].push_back(finding_json(finding));
  json["real_time"] = {{"permitted", observed.real_time.permitted},
                       {"why_not", observed.real_time.why_not},
                       {"reserved", observed.real_time.reserved},
                       {"reserved_by", observed.real_time.reserved_by}};
  json["wake_ups"] = wake_ups_json(observed.wake_ups, observed.level);
  for (Json& entry : wake_ups_json(observed.ordinary, os::Level::kOrdinary)) json["wake_ups"].push_back(entry);
  json["host"] = {{"utc", observed.host.utc},
                  {"kernel", observed.host.kernel},
                  {"cpu_model", observed.host.cpu_model},
                  {"online", observed.topology.online().cpus()}};
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string coloured(const std::string& text, doctor::Verdict verdict, bool colours) {
  if (!colours) return text;
  constexpr std::array<const char*, 4> kColours = {"32", "36", "33", "31"};
  return fmt::format("\x1b[{}m{}\x1b[0m", kColours[static_cast<std::size_t>(verdict)], text);
}

std::string advice(const doctor::Finding& finding, bool colours) {
  const std::string title =
      coloured(fmt::format("{} ({})", finding.check, to_string(finding.verdict)), finding.verdict, colours);
  std::string text =
      fmt::format("\n{}: {}\n  For Catan: {}.\n  To do: {}.\n", title, finding.found, finding.meaning, finding.hint);
  for (const std::string& line : finding.lines) text += fmt::format("    {}\n", line);
  return text;
}

std::string summary(const std::vector<doctor::Finding>& findings, bool colours) {
  std::array<int, 4> counts{};
  for (const doctor::Finding& finding : findings) ++counts[static_cast<std::size_t>(finding.verdict)];
  const std::string said =
      coloured(counts[3] > 0 ? "Something hinders real-time scheduling" : "Nothing hinders real-time scheduling",
               counts[3] > 0 ? doctor::Verdict::kProblem : doctor::Verdict::kOk, colours);
  return fmt::format("\n{}: {} ok, {} to note, {} to be warned of, {} to be fixed.\n", said, counts[0], counts[1],
                     counts[2], counts[3]);
}

std::string as_text(const std::vector<doctor::Finding>& findings, bool colours) {
  Table table({"check", "verdict", "found"});
  for (const doctor::Finding& finding : findings) table.add({finding.check, to_string(finding.verdict), finding.found});
  std::string text = table.text();
  for (const doctor::Finding& finding : findings) {
    if (finding.verdict != doctor::Verdict::kOk) text += advice(finding, colours);
  }
  return text + summary(findings, colours);
}

Result<os::CpuSet> asked_cpus(const std::string& text) {
  Result<os::CpuSet> cpus = os::parse_cpu_list(text);
  if (cpus.ok()) return cpus;
  Problem problem = cpus.error().problems().front();
  problem.key = "--cpus";
  return Error(ErrorKind::kCaller, {std::move(problem)});
}

int check_up(const DoctorOptions& options) {
  const auto cpus = asked_cpus(options.cpus);
  if (!cpus) return report_error(cpus.error());
  const auto os = os::make_linux_os();
  const auto observed = doctor::observe(*os, *cpus);
  if (!observed) return report_error(observed.error());
  const std::vector<doctor::Finding> findings = doctor::judge({}, *observed);
  print(options.json ? as_json(*observed, findings) : as_text(findings, stdout_has_colours()));
  return worst(findings) == doctor::Verdict::kProblem ? kFailure : kSuccess;
}

}  // namespace

void add_doctor_command(CLI::App& cli, int& exit_code) {
  auto options = std::make_shared<DoctorOptions>();
  CLI::App* command = cli.add_subcommand("doctor", "Check whether this machine is fit for real-time scheduling");
  command->footer(
      "Examples:\n"
      "  catan doctor                what hinders, what costs, and what to do about it\n"
      "  catan doctor --cpus 2-5     for an app that is to run there\n"
      "  catan doctor --json         one JSON document\n"
      "Takes about half a second and changes nothing. Exit code: 0 nothing hinders real-time scheduling, 1 something\n"
      "does, 2 a mistake on the command line. All checks: docs/doctor.md.");
  command->add_option("--cpus", options->cpus, "The CPUs in question, as in 0-3,5; else all that may be used")
      ->type_name("LIST");
  command->add_flag("--json", options->json, "Print one JSON document");
  command->callback([options, &exit_code] { exit_code = check_up(*options); });
}

}  // namespace ctn::tool
