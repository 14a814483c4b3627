// What the application feels under each policy: the frozen case studies with their synthetic loads, run for real, one
// policy after the other, in rounds so that a noisy machine treats all alike. docs/benchmarks.md says how to read it.
//
// The loads have spikes, and what takes long grows with time.
//
//   policies_bench                                                       all of it, on one core
//   policies_bench --cases vr --policies catan,verucchi --rounds 9       one case between two, more surely
//
// Needs the permission for real-time levels. Exit: 0, whatever comes out; 1 if a run fails; 2 for options that make no
// sense.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <iterator>
#include <limits>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "cases.h"
#include "command_output.h"

namespace {

using Json = nlohmann::json;
using ctn::bench::output_of;

// In options, {costs} stands for the case's cost file.
struct Contender {
  std::string name;
  std::string options;
};
const std::vector<Contender> kContenders{
    {"catan", "--scheduler catan"},
    {"catan-fixed-frames", "--scheduler catan --frames fixed"},
    {"catan-no-stealing", "--scheduler catan --no-stealing"},
    {"verucchi", "--scheduler verucchi:{costs}"},
    {"davare", "--scheduler davare:{costs}"},
    {"picas", "--scheduler picas:{costs}"},
    {"fifo", "--scheduler fifo"},
    {"default", "--scheduler default"},
};

std::vector<std::string> names_of_contenders() {
  std::vector<std::string> names;
  std::transform(kContenders.begin(), kContenders.end(), std::back_inserter(names),
                 [](const Contender& who) { return who.name; });
  return names;
}
const Contender& contender(const std::string& name) {
  return *std::find_if(kContenders.begin(), kContenders.end(), [&](const Contender& who) { return who.name == name; });
}

struct Setting {
  std::vector<std::string> cases{"navigation", "navigation_with_detector", "vr"};
  std::vector<std::string> policies = names_of_contenders();
  int seconds = 30;
  int rounds = 3;
  int cores = 1;

  // The last of the machine's.
  std::string cpus() const {
    const long count = sysconf(_SC_NPROCESSORS_ONLN);
    return fmt::format("{}-{}", count - cores, count - 1);
  }
};

// Of the chain that weighs most, and the weighted sum of all.
struct Measured {
  double objective = 0.0;
  double mean = 0.0;
  double p99 = 0.0;
  double mean_to_expected = 0.0;  // NaN where no plan promises anything
  double p99_to_promised = 0.0;   // the worst of all chains; NaN as well
};

Measured measure(const std::string& name, const Contender& who, const Setting& setting, int seed) {
  const std::string files = ctn::bench::frozen_files(name);
  const std::string text = output_of(
      fmt::format("{} run {}.yaml --synthetic {}.load.yaml --cpus {} --seconds {} --seed {} {} --json 2>/dev/null",
                  CATAN_COMMAND, files, files, setting.cpus(), setting.seconds, seed,
                  fmt::format(fmt::runtime(who.options), fmt::arg("costs", files + ".costs.yaml"))));
  const Json run = Json::parse(text);
  Measured measured;
  const Json& objective = run.at("objective").at("measured");
  // A chain of which no sample reached its end counts as never responding.
  measured.objective = objective.is_null() ? std::numeric_limits<double>::infinity() : objective.get<double>();
  const Json& first = run.at("chains").front();
  measured.mean = first.at("response_ms").at("mean").get<double>();
  measured.p99 = first.at("response_ms").at("p99").get<double>();
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  measured.mean_to_expected = measured.p99_to_promised = kNone;
  if (first.at("predicted").is_null()) return measured;
  measured.mean_to_expected = measured.mean / first.at("predicted").at("response_ms").get<double>();
  measured.p99_to_promised = 0.0;
  for (const Json& chain : run.at("chains")) {
    const double promised = chain.at("predicted").at("promised_response_ms").get<double>();
    measured.p99_to_promised =
        std::max(measured.p99_to_promised, chain.at("response_ms").at("p99").get<double>() / promised);
  }
  return measured;
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double median_of(const std::vector<Measured>& all, double Measured::*figure) {
  std::vector<double> values;
  for (const Measured& each : all) values.push_back(each.*figure);
  return median(std::move(values));
}

Json run_case(const std::string& name, const Setting& setting) {
  std::map<std::string, std::vector<Measured>> results;
  for (int round = 0; round < setting.rounds; ++round) {
    for (const std::string& who : setting.policies) {
      fmt::print(stderr, "... {}, {}, round {} of {}\n", name, who, round + 1, setting.rounds);
      results[who].push_back(measure(name, contender(who), setting, round + 1));
    }
  }
  Json rows = Json::array();
  const double first = median_of(results[setting.policies.front()], &Measured::objective);
  for (const std::string& who : setting.policies) {
    const auto figure = [&](double Measured::*value) {
      const double median = median_of(results[who], value);
      return std::isfinite(median) ? Json(median) : Json(nullptr);
    };
    rows.push_back({{"policy", who},
                    {"objective_ms", figure(&Measured::objective)},
                    {"to_first", median_of(results[who], &Measured::objective) / first},
                    {"first_chain_mean_ms", figure(&Measured::mean)},
                    {"first_chain_p99_ms", figure(&Measured::p99)},
                    {"first_chain_mean_to_expected", figure(&Measured::mean_to_expected)},
                    {"worst_p99_to_promised", figure(&Measured::p99_to_promised)}});
  }
  return {{"case", name},
          {"rounds", setting.rounds},
          {"seconds", setting.seconds},
          {"cores", setting.cores},
          {"policies", rows}};
}

std::string cell(const Json& value) { return value.is_null() ? "-" : fmt::format("{:.2f}", value.get<double>()); }

void print_case(const Json& result) {
  fmt::print("\n{}: medians of {} rounds of {} s, cores: {}\n", result["case"].get<std::string>(),
             result["rounds"].get<int>(), result["seconds"].get<int>(), result["cores"].get<int>());
  fmt::print("{:<22} {:>13} {:>9} {:>16} {:>15} {:>17} {:>17}\n", "policy", "objective, ms", "to first",
             "first chain mean", "first chain p99", "mean to expected", "p99 to promised");
  for (const Json& row : result["policies"]) {
    fmt::print("{:<22} {:>13} {:>8}x {:>16} {:>15} {:>17} {:>17}\n", row["policy"].get<std::string>(),
               cell(row["objective_ms"]), cell(row["to_first"]), cell(row["first_chain_mean_ms"]),
               cell(row["first_chain_p99_ms"]), cell(row["first_chain_mean_to_expected"]),
               cell(row["worst_p99_to_promised"]));
  }
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  bool json = false;
  bool quick = false;
  Setting setting;
  CLI::App cli("What the application feels under each policy, for real");
  cli.option_defaults()->always_capture_default();
  cli.add_option("--cases", setting.cases, "Frozen case studies")->delimiter(',')->check(CLI::IsMember(setting.cases));
  cli.add_option("--policies", setting.policies, "Who plays; objectives are compared with the first")
      ->delimiter(',')
      ->check(CLI::IsMember(setting.policies));
  cli.add_option("--cores", setting.cores, "The last of the machine's CPUs, so many")
      ->check(CLI::Range(1L, sysconf(_SC_NPROCESSORS_ONLN)));
  cli.add_option("--rounds", setting.rounds, "How often each policy plays each case, by turns")
      ->check(CLI::Range(1, 1000));
  cli.add_option("--seconds", setting.seconds, "Of each run")->check(CLI::Range(1, 86'400));
  cli.add_flag("--quick", quick, "One round of 20 s");
  cli.add_flag("--json", json, "Print one JSON document");
  try {
    cli.parse(argc, argv);
    if (quick) setting.seconds = 20, setting.rounds = 1;
    Json results = Json::array();
    for (const std::string& name : setting.cases) {
      results.push_back(run_case(name, setting));
      if (!json) print_case(results.back());
    }
    if (json) fmt::print("{}\n", results.dump(2));
  } catch (const CLI::CallForHelp& help) {
    return cli.exit(help);
  } catch (const CLI::ParseError& error) {
    cli.exit(error);
    return 2;
  } catch (const std::exception& error) {
    fmt::print(stderr, "policies_bench: {}\n", error.what());
    return EXIT_FAILURE;
  }
  return EXIT_SUCCESS;
}
