// What `run` and `serve` have in common on the command line: how an app is scheduled.
#pragma once

#include <optional>
#include <string>

#include "base/result.h"
#include "catan/session.h"
#include "runtime/scheduler.h"

namespace CLI {
class App;
class Validator;
}  // namespace CLI

namespace ctn::tool {

struct SchedulingOptions {
  std::string scheduler = "catan";
  std::string cpus;
  std::string record;
  bool no_stealing = false;
  bool no_replan = false;
  std::string frames;
  int flight_recorder_mib = 8;

  void add_to(CLI::App& command);

  // With the record at `record_path`, which may be empty. kCaller.
  Result<SessionOptions> for_session(const std::string& record_path) const;
  Result<runtime::SchedulerOptions> for_scheduler(const graph::App& app, const std::string& record_path) const;

 private:
  Result<os::CpuSet> chosen_cpus() const;
};

// The first problem of `error`, said of the option that it is about. kCaller.
Error about_option(const Error& error, const char* option);

// "6%", as the option has it: a fraction. kCaller.
Result<double> percentage_of(const std::string& text, const char* option);

// "elastic" or "fixed"; none where it is empty.
std::optional<graph::FrameMode> frame_mode(const std::string& text);

// As CLI::Range, which lets NaN through.
CLI::Validator within(double min, double max);

}  // namespace ctn::tool
