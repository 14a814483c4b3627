// Made-up results for tests: two cores' worth of trials, all as one would hope.
#pragma once

#include <string>
#include <vector>

#include "results.h"

namespace ctn::demo {

inline Measured made_up(int round, std::size_t cores, const std::string& scheduler, double speed, double hertz,
                        double response, double angle) {
  Measured run;
  run.trial.round = round;
  run.trial.cpus = cores == 1 ? std::vector<int>{1} : std::vector<int>{0, 1};
  run.trial.scheduler = scheduler;
  run.trial.speed = speed;
  run.trial.seconds = 3.0;
  run.source_hz = hertz;
  run.response_ms = response + round;
  run.response_p95_ms = 1.2 * response;
  run.angle_deg = angle + 0.1 * round;
  run.lost_fraction = 0.01;
  run.compute = {25.0, 57.5, 1.0};
  if (scheduler == "catan") run.predicted_ms = response;
  run.real_time = scheduler == "catan";
  return run;
}

inline Results sample_results() {
  Results results;
  results.host = {{"Processor", "made up"}, {"CPUs", "2"}};
  results.medium_speed = 1.0;
  results.high_speed = 1.5;
  results.complete = true;
  for (int round = 1; round <= 3; ++round) {
    for (const std::size_t cores : {std::size_t{1}, std::size_t{2}}) {
      const double gain = cores == 1 ? 0.0 : 25.0;
      results.runs.push_back(made_up(round, cores, "default", 1.0, 30.0, 250.0 - gain, 6.0));
      results.runs.push_back(made_up(round, cores, "catan", 1.0, 11.3, 175.0 - gain, 4.0));
      results.runs.push_back(made_up(round, cores, "rate:11.4Hz", 1.0, 11.4, 173.0 - gain, 4.0));
      results.runs.push_back(made_up(round, cores, "rate:6.0Hz", 1.0, 6.0, 260.0 - gain, 6.5));
      results.runs.push_back(made_up(round, cores, "default", 1.5, 30.0, 250.0 - gain, 14.0));
      results.runs.push_back(made_up(round, cores, "catan", 1.5, 11.3, 175.0 - gain, 8.0));
    }
  }
  return results;
}

}  // namespace ctn::demo
