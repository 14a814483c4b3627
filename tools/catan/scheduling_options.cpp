#include "scheduling_options.h"

#include <fmt/format.h>

#include <utility>

#include <CLI/CLI.hpp>

#include "api/policies.h"
#include "base/text.h"
#include "config/quantity.h"

namespace ctn::tool {

CLI::Validator within(double min, double max) {
  const auto check = [=](const std::string& text) -> std::string {
    double value = 0.0;
    if (CLI::detail::lexical_cast(text, value) && value >= min && value <= max) return {};
    return fmt::format("{} is no number from {} to {}", quote(text), min, max);
  };
  return {check, fmt::format("from {} to {}", min, max)};
}

Error about_option(const Error& error, const char* option) {
  Problem problem = error.problems().front();
  problem.key = option;
  return {ErrorKind::kCaller, {std::move(problem)}};
}

Result<double> percentage_of(const std::string& text, const char* option) {
  auto parsed = config::parse_percentage(text);
  if (parsed) return *parsed;
  return about_option(parsed.error(), option);
}

std::optional<graph::FrameMode> frame_mode(const std::string& text) {
  if (text.empty()) return std::nullopt;
  return text == "fixed" ? graph::FrameMode::kFixed : graph::FrameMode::kElastic;
}

void SchedulingOptions::add_to(CLI::App& command) {
  command
      .add_option("--scheduler", scheduler,
                  "catan; auto (the same, whatever planner the app file names); paper (the paper's two stages, fixed "
                  "frames); static:PLAN.json (a plan that is never revised); rates-of:PLAN.json (its rates alone, "
                  "ordinary scheduling); default (nodes at their "
                  "fallback_rate, ordinary scheduling); rate:HZ (sources at it); fifo (as default, at fixed "
                  "real-time priorities); picas:COSTS (as default, at chain-aware priorities), davare:COSTS and "
                  "verucchi:COSTS (rates by published methods, for the compute times in a cost file or a "
                  "record)")
      ->capture_default_str();
  command.add_option("--cpus", cpus, "CPUs for the nodes, as in 0-3,6; else all that may be used")->type_name("LIST");
  command.add_option("--record", record, "Keep the record of the run in this new file (catan report)")
      ->type_name("FILE");
  command
      .add_option("--flight-recorder", flight_recorder_mib,
                  "Memory in which the last seconds are kept, for catan top and catan ctl dump; 0: they are not")
      ->type_name("MIB")
      ->check(CLI::Range(0, 4096))
      ->capture_default_str();
  command.add_flag("--no-stealing", no_stealing, "No unfinished subchain goes on in another's slot");
  command.add_flag("--no-replan", no_replan, "Keep the first plan that rests on measured times");
  command.add_option("--frames", frames, "Frames of shared cores; else as the app says")
      ->check(CLI::IsMember({"elastic", "fixed"}));
}

Result<os::CpuSet> SchedulingOptions::chosen_cpus() const {
  if (cpus.empty()) return os::CpuSet{};
  Result<os::CpuSet> chosen = os::parse_cpu_list(cpus);
  if (chosen) return chosen;
  return about_option(chosen.error(), "--cpus");
}

Result<SessionOptions> SchedulingOptions::for_session(const std::string& record_path) const {
  const Result<os::CpuSet> chosen = chosen_cpus();
  if (!chosen) return chosen.error();
  SessionOptions options;
  options.policy = scheduler;
  options.cpus = chosen->cpus();
  options.record = record_path;
  options.flight_recorder_mib = flight_recorder_mib;
  options.stealing = !no_stealing;
  options.replan = !no_replan;
  if (!frames.empty()) options.fixed_frames = frames == "fixed";
  return options;
}

Result<runtime::SchedulerOptions> SchedulingOptions::for_scheduler(const graph::App& app,
                                                                   const std::string& record_path) const {
  Result<os::CpuSet> chosen = chosen_cpus();
  if (!chosen) return chosen.error();
  const auto policy = api::live_policy(scheduler, app);
  if (!policy) return policy.error();
  runtime::SchedulerOptions options;
  options.policy = *policy;
  options.cpus = std::move(*chosen);
  options.record = record_path;
  options.flight_bytes = static_cast<std::size_t>(flight_recorder_mib) << 20U;
  options.stealing = !no_stealing;
  options.replan = !no_replan;
  options.frames = frame_mode(frames);
  return options;
}

}  // namespace ctn::tool
