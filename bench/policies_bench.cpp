// What the application feels under each policy: the synthetic case studies on one core, run for real, one policy after
// the other, in rounds so that a noisy machine treats all alike. docs/benchmarks.md says how to read it.
//
// Usage: policies_bench [--quick]. Needs the permission for real-time levels. Exit: 0, whatever comes out; 1 if a run
// fails.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

namespace {

using Json = nlohmann::json;

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

struct Measured {
  double objective = 0.0;
  double first_mean = 0.0;  // of the chain that weighs most
  double first_p99 = 0.0;
};

std::string output_of(const std::string& command) {
  std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(command.c_str(), "r"), pclose);
  if (!pipe) throw std::runtime_error("cannot run " + command);
  std::string text;
  std::array<char, 4096> buffer{};
  while (const std::size_t count = std::fread(buffer.data(), 1, buffer.size(), pipe.get())) {
    text.append(buffer.data(), count);
  }
  return text;
}

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
  const Json& response = run.at("chains").front().at("response_ms");
  measured.first_mean = response.at("mean").get<double>();
  measured.first_p99 = response.at("p99").get<double>();
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

void run_case(const Case& of, int seconds, int rounds) {
  std::map<std::string, std::vector<Measured>> results;
  for (int round = 0; round < rounds; ++round) {
    for (const Contender& who : kContenders) {
      fmt::print(stderr, "... {}, {}, round {} of {}\n", of.name, who.name, round + 1, rounds);
      results[who.name].push_back(measure(of, who, seconds, round + 1));
    }
  }
  const double ours = median_of(results["catan"], &Measured::objective);
  fmt::print("\n{}: medians of {} rounds of {} s, one core\n", of.name, rounds, seconds);
  fmt::print("{:<22} {:>14} {:>11} {:>20} {:>20}\n", "policy", "objective, ms", "to catan", "first chain mean, ms",
             "first chain p99, ms");
  for (const Contender& who : kContenders) {
    const std::vector<Measured>& all = results[who.name];
    const double objective = median_of(all, &Measured::objective);
    fmt::print("{:<22} {:>14.2f} {:>10.2f}x {:>20.2f} {:>20.2f}\n", who.name, objective, objective / ours,
               median_of(all, &Measured::first_mean), median_of(all, &Measured::first_p99));
  }
}

}  // namespace

int main(int argc, char** argv) {
  const bool quick = argc > 1 && std::string_view(argv[1]) == "--quick";
  const int seconds = quick ? 20 : 30;
  const int rounds = quick ? 1 : 3;
  try {
    run_case({"navigation", "navigation/navigation.yaml", "navigation/navigation.load.yaml"}, seconds, rounds);
    run_case({"VR", "vr/vr.yaml", "vr/vr.load.yaml"}, seconds, rounds);
  } catch (const std::exception& error) {
    fmt::print(stderr, "policies_bench: {}\n", error.what());
    return EXIT_FAILURE;
  }
  return EXIT_SUCCESS;
}
