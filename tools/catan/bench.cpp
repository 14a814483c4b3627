// catan bench: what the runtime costs on this machine, each figure next to the minimum that the machine allows.
#include <fmt/format.h>

#include <functional>
#include <memory>
#include <string>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "bench/figure.h"
#include "bench/hand_over.h"
#include "bench/overhead.h"
#include "bench/trigger.h"
#include "command.h"
#include "os/linux/linux_os.h"
#include "record/metrics_json.h"
#include "runtime/scheduler.h"

namespace ctn::tool {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kSeconds = 20.0;
constexpr double kQuickSeconds = 4.0;

struct BenchOptions {
  std::string cpus;
  double seconds = kSeconds;
  bool quick = false;
  bool json = false;
};

struct Measurement {
  const char* name;
  bool needs_levels;
  std::function<Result<std::vector<Figure>>(const BenchContext&)> measure;
};

const std::vector<Measurement>& measurements() {
  static const std::vector<Measurement> kAll{
      {"hand-over", true, measure_hand_over},
      {"trigger to first instruction", true, measure_trigger},
      {"report of a run", false, measure_reporting},
      {"CPU of scheduling, in process", true, measure_overhead_in_process},
      {"CPU of scheduling, served", true, measure_overhead_served},
  };
  return kAll;
}

Json summary_json(const Summary& summary) {
  return {{"count", summary.count},
          {"mean", summary.mean},
          {"p50", summary.p50},
          {"p99", summary.p99},
          {"max", summary.max}};
}

Json figure_json(const Figure& figure) {
  Json json{{"figure", figure.name.substr(figure.name.find_first_not_of(' '))},
            {"where", figure.where},
            {"unit", figure.unit},
            {"measured", summary_json(figure.measured)}};
  json["baseline"] = figure.baseline.count > 0 ? summary_json(figure.baseline) : Json();
  json["baseline_is"] = figure.baseline_is;
  json["ratio"] = record::or_null(figure.ratio());
  json["goal"] = {{"ratio", record::or_null(figure.goal.ratio)},
                  {"p50", record::or_null(figure.goal.p50)},
                  {"p99", record::or_null(figure.goal.p99)}};
  json["met"] = record::or_null(figure.met());
  return json;
}

std::string as_json(const BenchContext& context, const os::HostFacts& host, const Figures& figures) {
  Json json{{"core", context.core}, {"other_core", record::or_null(context.other_core)}, {"seconds", context.seconds}};
  json["figures"] = Json::array();
  for (const Figure& figure : figures.measured) json["figures"].push_back(figure_json(figure));
  json["skipped"] = Json::array();
  for (const Skipped& skipped : figures.skipped) {
    json["skipped"].push_back({{"figure", skipped.name}, {"why", skipped.why}});
  }
  json["host"] = {{"utc", host.utc}, {"kernel", host.kernel}, {"cpu_model", host.cpu_model}, {"cpus", host.cpu_count}};
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string as_text(const BenchContext& context, const Figures& figures) {
  const std::string other = context.other_core ? fmt::format(", other core: CPU {}", *context.other_core) : "";
  return fmt::format("On CPU {}{}; {:.6g} s of measuring.\n\n{}", context.core, other, context.seconds,
                     figures_text(figures.measured));
}

Result<BenchContext> context_for(os::Os& os, const BenchOptions& options) {
  Result<os::CpuSet> asked = os::parse_cpu_list(options.cpus);
  if (!asked) {
    Problem problem = asked.error().problems().front();
    problem.key = "--cpus";
    return Error(ErrorKind::kCaller, {std::move(problem)});
  }
  const Result<os::CpuSet> cpus = runtime::choose_cpus(os, *asked);
  if (!cpus) return cpus.error();
  BenchContext context{os, cpus->cpus().back(), {}, options.quick ? kQuickSeconds : options.seconds};
  if (cpus->size() > 1) context.other_core = cpus->cpus().front();
  return context;
}

int bench(const BenchOptions& options) {
  const std::unique_ptr<os::Os> os = os::make_linux_os();
  const Result<BenchContext> context = context_for(*os, options);
  if (!context) return report_error(context.error());
  const os::RealTimeFacts facts = os->real_time_facts();
  // As a session does: the figures are those of a machine on which one runs.
  std::unique_ptr<os::ReadyCpus> ready;
  if (facts.permitted) {
    if (Result<std::unique_ptr<os::ReadyCpus>> kept = os->keep_cpus_ready()) {
      ready = std::move(*kept);
    } else {
      note(kept.error().message());
    }
  }
  Figures figures;
  std::vector<std::string> left_out;
  for (const auto& [name, needs_levels, measure] : measurements()) {
    if (needs_levels && !facts.permitted) {
      figures.skipped.push_back({name, facts.why_not});
      left_out.emplace_back(name);
      continue;
    }
    Result<std::vector<Figure>> found = measure(*context);
    if (!found) return report_error(found.error());
    figures.measured.insert(figures.measured.end(), found->begin(), found->end());
  }
  if (!left_out.empty()) note(fmt::format("skipped: {}: {}", fmt::join(left_out, "; "), facts.why_not));
  print(options.json ? as_json(*context, os->host_facts(), figures) : as_text(*context, figures));
  return kSuccess;
}

}  // namespace

void add_bench_command(CLI::App& cli, int& exit_code) {
  auto options = std::make_shared<BenchOptions>();
  CLI::App* command = cli.add_subcommand("bench", "Measure what scheduling costs on this machine");
  command->footer(
      "Examples:\n"
      "  catan bench                 about half a minute\n"
      "  catan bench --quick         a quarter of one, less exact\n"
      "  catan bench --cpus 2,3      on these: what needs one core is on the last, the other core is the first\n"
      "  catan bench --json          one JSON document\n"
      "Each figure stands beside the lowest that it could be, measured in turn with it. Real-time threads keep one "
      "core\n"
      "busy for up to a quarter of a second at a time. What needs a permission that is missing is skipped, and said.\n"
      "Exit code: 0 whatever the figures, 1 something could not be measured, 2 a mistake on the command line.\n"
      "What is measured and how: docs/benchmarks.md.");
  command->add_option("--seconds", options->seconds, "How long to measure, all figures together, without warm-ups")
      ->check(CLI::Range(1.0, 3600.0))
      ->capture_default_str();
  command->add_option("--cpus", options->cpus, "The CPUs to measure on, as in 0-3,5; else all that may be used")
      ->type_name("LIST");
  command->add_flag("--json", options->json, "Print one JSON document");
  command->add_flag("--quick", options->quick, fmt::format("As --seconds {}", kQuickSeconds))->excludes("--seconds");
  command->callback([options, &exit_code] { exit_code = bench(*options); });
}

}  // namespace ctn::tool
