// What the trials measured, as a value and as the file results.json.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "experiment.h"
#include "experiments/host.h"

namespace ctn::demo {

// One trial and what face_tracking printed about it.
struct Measured {
  Trial trial;
  double response_ms = 0.0;  // mean
  double response_p95_ms = 0.0;
  std::optional<double> predicted_ms;
  double source_hz = 0.0;
  double angle_deg = 0.0;
  double lost_fraction = 0.0;
  Compute compute;
  bool real_time = false;
  double others = 0.0;  // fraction of all CPU time that other programs used meanwhile
};

struct Results {
  experiments::Facts host;  // as printed
  double medium_speed = 0.0;
  double high_speed = 0.0;
  double slowdown = 1.0;
  bool quick = false;
  bool complete = false;         // all trials were run
  std::string no_real_time;      // why Catan could not use real-time levels, and how to let it; empty where it could
  std::vector<Measured> runs{};  // in the order they were run
};

// `json`: what face_tracking --json printed. The response time is 0 where no picture reached the motor. Errors:
// kEnvironment, naming what is missing.
Result<Measured> parse_measured(const Trial& trial, const std::string& json);

std::string to_json(const Results& results);
Result<Results> parse_results(const std::string& json);

}  // namespace ctn::demo
