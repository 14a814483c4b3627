// What the application feels under each policy: the synthetic case studies on one core, run for real, one policy after
// the other, in rounds so that a noisy machine treats all alike. docs/benchmarks.md says how to read it.
//
// Both loads have spikes and grow with time.
//
// Usage: policies_bench [--quick] [--json]. Needs the permission for real-time levels. Exit: 0, whatever comes out; 1
// if a run fails.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <map>
#include <set>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "command_output.h"

namespace {

using Json = nlohmann::json;
using ctn::bench::output_of;

struct Contender {
  std::string name;
  std::string options;
};
const std::vector<Contender> kContenders{
    {"catan", "--scheduler catan"},
    {"catan, fixed frames", "--scheduler catan --frames fixed"},
    {"catan, no stealing", "--scheduler catan --no-stealing"},
    {"default", "--scheduler default"},
    {"fifo", "--scheduler fifo"},
};

struct Case {
  std::string name;
  std::string app;
  std::string load;
};

// Of the chain that weighs most, and the weighted sum of all.
struct Measured {
  double objective = 0.0;
  double mean = 0.0;
  double p99 = 0.0;
  double mean_to_expected = 0.0;  // NaN where no plan promises anything
  double p99_to_promised = 0.0;   // the worst of all chains; NaN as well
};

Measured measure(const Case& of, const Contender& who, int seconds, int seed) {
  const std::string apps = CATAN_SOURCE_DIR "/apps/";
  const std::string text = output_of(
      fmt::format("{} run {}{} --synthetic {}{} --cpus {} --seconds {} --seed {} {} --json 2>/dev/null", CATAN_COMMAND,
                  apps, of.app, apps, of.load, sysconf(_SC_NPROCESSORS_ONLN) - 1, seconds, seed, who.options));
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

Json run_case(const Case& of, int seconds, int rounds) {
  std::map<std::string, std::vector<Measured>> results;
  for (int round = 0; round < rounds; ++round) {
    for (const Contender& who : kContenders) {
      fmt::print(stderr, "... {}, {}, round {} of {}\n", of.name, who.name, round + 1, rounds);
      results[who.name].push_back(measure(of, who, seconds, round + 1));
    }
  }
  Json rows = Json::array();
  const double ours = median_of(results["catan"], &Measured::objective);
  for (const Contender& who : kContenders) {
    const auto figure = [&](double Measured::*value) {
      const double median = median_of(results[who.name], value);
      return std::isfinite(median) ? Json(median) : Json(nullptr);
    };
    rows.push_back({{"policy", who.name},
                    {"objective_ms", figure(&Measured::objective)},
                    {"to_catan", median_of(results[who.name], &Measured::objective) / ours},
                    {"first_chain_mean_ms", figure(&Measured::mean)},
                    {"first_chain_p99_ms", figure(&Measured::p99)},
                    {"first_chain_mean_to_expected", figure(&Measured::mean_to_expected)},
                    {"worst_p99_to_promised", figure(&Measured::p99_to_promised)}});
  }
  return {{"case", of.name}, {"rounds", rounds}, {"seconds", seconds}, {"policies", rows}};
}

std::string cell(const Json& value) { return value.is_null() ? "-" : fmt::format("{:.2f}", value.get<double>()); }

void print_case(const Json& result) {
  fmt::print("\n{}: medians of {} rounds of {} s, one core\n", result["case"].get<std::string>(),
             result["rounds"].get<int>(), result["seconds"].get<int>());
  fmt::print("{:<22} {:>13} {:>9} {:>16} {:>15} {:>17} {:>17}\n", "policy", "objective, ms", "to catan",
             "first chain mean", "first chain p99", "mean to expected", "p99 to promised");
  for (const Json& row : result["policies"]) {
    fmt::print("{:<22} {:>13} {:>8}x {:>16} {:>15} {:>17} {:>17}\n", row["policy"].get<std::string>(),
               cell(row["objective_ms"]), cell(row["to_catan"]), cell(row["first_chain_mean_ms"]),
               cell(row["first_chain_p99_ms"]), cell(row["first_chain_mean_to_expected"]),
               cell(row["worst_p99_to_promised"]));
  }
}

}  // namespace

int main(int argc, char** argv) {
  const std::set<std::string_view> options(argv + 1, argv + argc);
  const bool quick = options.contains("--quick");
  const bool json = options.contains("--json");
  const int seconds = quick ? 20 : 30;
  const int rounds = quick ? 1 : 3;
  try {
    Json results = Json::array();
    for (const Case& each : {Case{"navigation", "navigation/navigation.yaml", "navigation/navigation.load.yaml"},
                             Case{"VR", "vr/vr.yaml", "vr/vr.load.yaml"}}) {
      results.push_back(run_case(each, seconds, rounds));
      if (!json) print_case(results.back());
    }
    if (json) fmt::print("{}\n", results.dump(2));
  } catch (const std::exception& error) {
    fmt::print(stderr, "policies_bench: {}\n", error.what());
    return EXIT_FAILURE;
  }
  return EXIT_SUCCESS;
}
