// Every fault that a served app must survive, injected many times into real processes: how many were survived, and how
// long it took until all was as it should be. docs/benchmarks.md says how to read it.
//
// Usage: faults_bench [--times N] [--fault NAME]... [--json]. Needs the permission for real-time levels to say much.
// Exit: 1 if a fault was not survived, 0 otherwise, however long it took.
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <stdexcept>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "base/statistics.h"
#include "faults/faults.h"
#include "os/linux/linux_os.h"

namespace {

using ctn::faults::Fault;
using ctn::faults::FaultReport;
using ctn::faults::Recovery;
using Json = nlohmann::ordered_json;

volatile std::sig_atomic_t g_signal = 0;
void remember(int number) { g_signal = number; }

struct Options {
  int times = 100;
  std::vector<std::string> faults;  // empty: all
  bool json = false;
};

int mistaken(const std::string& what) {
  fmt::print(stderr, "faults_bench: {}\nUsage: faults_bench [--times N] [--fault NAME]... [--json]\nFaults:\n", what);
  for (const Fault& fault : ctn::faults::all_faults()) fmt::print(stderr, "  {}\n", fault.name);
  return 2;
}

// Nothing: a mistake, which is told.
bool read(int argc, char** argv, Options& options) {
  for (int at = 1; at < argc; ++at) {
    const std::string word = argv[at];
    const std::string value = at + 1 < argc ? argv[at + 1] : "";
    if (word == "--json") {
      options.json = true;
      continue;
    }
    if (word == "--times") {
      const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), options.times);
      if (error != std::errc{} || end != value.data() + value.size() || options.times < 1) return false;
    } else if (word == "--fault") {
      options.faults.push_back(value);
    } else {
      return false;
    }
    ++at;
  }
  const auto& all = ctn::faults::all_faults();
  return std::all_of(options.faults.begin(), options.faults.end(), [&](const std::string& name) {
    return std::any_of(all.begin(), all.end(), [&](const Fault& fault) { return fault.name == name; });
  });
}

bool passed(const FaultReport& report) {
  return report.injected > 0 && report.survived == report.injected && report.records_whole == report.records &&
         report.raised_left == 0 && report.files_left <= 0 && report.failures.empty();
}

void print_head() {
  fmt::print("{:<28} {:>8} {:>8}  {:<36} {:>7} {:>7} {:>7} {:>7} {:>8} {:>7} {:>6}\n", "fault", "injected", "survived",
             "until (ms)", "median", "p99", "max", "others", "records", "raised", "files");
}

void print_row(const FaultReport& report) {
  bool first = true;
  for (const Recovery& recovery : report.recoveries) {
    const ctn::Summary summary = ctn::summarize(recovery.ms);
    const std::string until =
        recovery.all ? recovery.until : fmt::format("{} ({} times)", recovery.until, summary.count);
    fmt::print("{:<28} {:>8} {:>8}  {:<36} {:>7.1f} {:>7.1f} {:>7.1f}", first ? report.fault : "",
               first ? std::to_string(report.injected) : "", first ? std::to_string(report.survived) : "", until,
               summary.p50, summary.p99, summary.max);
    if (first) {
      fmt::print(" {:>7} {:>8} {:>7} {:>6}", report.others ? fmt::format("{:.0f} %", 100.0 * *report.others) : "-",
                 fmt::format("{}/{}", report.records_whole, report.records), report.raised_left, report.files_left);
    }
    fmt::print("\n");
    first = false;
  }
  for (const std::string& failure : report.failures) fmt::print("    {}\n", failure);
  std::fflush(stdout);
}

Json to_json(const FaultReport& report) {
  Json recoveries = Json::array();
  for (const Recovery& recovery : report.recoveries) {
    const ctn::Summary summary = ctn::summarize(recovery.ms);
    recoveries.push_back({{"until", recovery.until},
                          {"count", summary.count},
                          {"p50_ms", summary.p50},
                          {"p99_ms", summary.p99},
                          {"max_ms", summary.max}});
  }
  return {{"fault", report.fault},
          {"injected", report.injected},
          {"survived", report.survived},
          {"recoveries", recoveries},
          {"others_rate", report.others ? Json(*report.others) : Json(nullptr)},
          {"records", report.records},
          {"records_whole", report.records_whole},
          {"unwritten_ms", report.unwritten_ms},
          {"raised_left", report.raised_left},
          {"descriptors_left", report.files_left},
          {"observer_late_ms", report.observer_late_ms},
          {"failures", report.failures}};
}

int run(const Options& options) {
  const ctn::os::RealTimeFacts facts = ctn::os::make_linux_os()->real_time_facts();
  if (!facts.permitted)
    fmt::print(stderr, "Real-time levels are not permitted, so none can be left: {}\n", facts.why_not);
  for (const int number : {SIGINT, SIGTERM}) std::signal(number, remember);
  const ctn::faults::Place place{CATAN_COMMAND, FAULT_PLAYER, [] { return g_signal == 0; }};
  Json document{{"times", options.times}, {"real_time", facts.permitted}, {"faults", Json::array()}};
  bool all_passed = true;
  double unwritten_ms = 0.0;
  double late_ms = 0.0;
  if (!options.json) print_head();
  for (const Fault& fault : ctn::faults::all_faults()) {
    const auto& wanted = options.faults;
    if (!wanted.empty() && std::find(wanted.begin(), wanted.end(), fault.name) == wanted.end()) continue;
    if (g_signal != 0) break;
    fmt::print(stderr, "... {}\n", fault.name);
    const FaultReport report = ctn::faults::inject(fault, options.times, place);
    all_passed = all_passed && passed(report);
    unwritten_ms = std::max(unwritten_ms, report.unwritten_ms);
    late_ms = std::max(late_ms, report.observer_late_ms);
    if (options.json) {
      document["faults"].push_back(to_json(report));
    } else {
      print_row(report);
    }
  }
  if (options.json) {
    fmt::print("{}\n", document.dump(2));
  } else {
    fmt::print("Records of killed servers end {:.0f} ms before the kill at most.\n", unwritten_ms);
    fmt::print("Who measures this, at a real-time level, was late by {:.1f} ms at most.\n", late_ms);
  }
  if (g_signal != 0) return 128 + g_signal;
  return all_passed ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  if (!read(argc, argv, options)) return mistaken("what is asked for is not understood");
  try {
    return run(options);
  } catch (const std::exception& error) {
    fmt::print(stderr, "faults_bench: {}\n", error.what());
    return 1;
  }
}
