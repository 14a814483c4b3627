// How far simulations are from real runs: each app runs for real under each scheduler with its synthetic load, and what
// its record says is simulated (`catan sim --validate`). docs/simulation.md says how to read it.
//
// Usage: simulation_error_bench [--seconds N] [--json]. Needs the permission for real-time levels, and CPUs that
// nothing else uses. Exit: 0, whatever comes out; 1 if a run fails.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "command_output.h"

namespace {

using Json = nlohmann::ordered_json;

struct Case {
  std::string app;
  std::string files;  // without .yaml
  std::string load;
};

// The record is made, read and deleted.
Json validation(const Case& of, const std::string& scheduler, int seconds) {
  const std::string record =
      (std::filesystem::temp_directory_path() / fmt::format("catan_simulation_error_{}", getpid())).string();
  std::filesystem::remove(record);
  const std::string apps = CATAN_SOURCE_DIR "/apps/";
  ctn::bench::output_of(fmt::format(
      "{} run {}{}.yaml --synthetic {}{} --cpus {} --seconds {} --scheduler {} --record {} 2>/dev/null", CATAN_COMMAND,
      apps, of.files, apps, of.load, sysconf(_SC_NPROCESSORS_ONLN) - 1, seconds, scheduler, record));
  const std::string text =
      ctn::bench::output_of(fmt::format("{} sim --validate {} --json 2>/dev/null", CATAN_COMMAND, record));
  std::filesystem::remove(record);
  return Json::parse(text);
}

// The largest among the chains, of one figure of their response times.
double worst(const Json& validated, const char* figure) {
  double max = 0.0;
  for (const Json& chain : validated["chains"]) {
    const Json& error = chain["response_ms"][figure]["error"];
    if (!error.is_null()) max = std::max(max, std::abs(error.get<double>()));
  }
  return max;
}

double heaviest(const Json& validated, const char* figure) {
  const Json& error = validated["chains"].front()["response_ms"][figure]["error"];
  return error.is_null() ? std::nan("") : error.get<double>();
}

}  // namespace

int main(int argc, char** argv) {
  int seconds = 30;
  bool json = false;
  for (int i = 1; i < argc; ++i) {
    const std::string_view option = argv[i];
    if (option == "--json") json = true;
    if (option == "--seconds" && i + 1 < argc) seconds = std::max(5, std::atoi(argv[++i]));
  }
  try {
    Json results = Json::array();
    if (!json) {
      fmt::print("Error of simulated response times, {} s a run, one core\n", seconds);
      fmt::print("{:<14} {:<10} {:>18} {:>8} {:>8} {:>18} {:>8} {:>8}\n", "app", "scheduler", "first chain mean", "p50",
                 "p95", "worst chain mean", "p50", "p95");
    }
    for (const Case& each :
         {Case{"face tracking", "face_tracking/face_tracking", "face_tracking/face_tracking.costs.yaml"},
          Case{"navigation", "navigation/navigation", "navigation/navigation.load.yaml"},
          Case{"VR", "vr/vr", "vr/vr.load.yaml"}}) {
      for (const char* scheduler : {"default", "fifo", "catan"}) {
        fmt::print(stderr, "... {}, {}\n", each.app, scheduler);
        Json validated = validation(each, scheduler, seconds);
        if (!json) {
          fmt::print("{:<14} {:<10} {:>+16.1f} % {:>+6.1f} % {:>+6.1f} % {:>16.1f} % {:>6.1f} % {:>6.1f} %\n", each.app,
                     scheduler, 100.0 * heaviest(validated, "mean"), 100.0 * heaviest(validated, "p50"),
                     100.0 * heaviest(validated, "p95"), 100.0 * worst(validated, "mean"),
                     100.0 * worst(validated, "p50"), 100.0 * worst(validated, "p95"));
        }
        results.push_back(std::move(validated));
      }
    }
    if (json) fmt::print("{}\n", results.dump(2));
  } catch (const std::exception& error) {
    fmt::print(stderr, "simulation_error_bench: {}\n", error.what());
    return EXIT_FAILURE;
  }
  return EXIT_SUCCESS;
}
