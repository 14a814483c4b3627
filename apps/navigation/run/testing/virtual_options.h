// Options of a run in virtual time, for tests: map 1, without a detector.
#pragma once

#include <string>

#include "run/options.h"

namespace ctn::navigation::run {

inline Options virtual_options(const std::string& scheduler, double seconds) {
  Options options;
  options.app_file = NAVIGATION_FOLDER "/robot.yaml";
  options.world_file = NAVIGATION_FOLDER "/worlds/map1.yaml";
  options.virtual_time = true;
  options.scheduler = options.policy = scheduler;
  options.seconds = seconds;
  return options;
}

}  // namespace ctn::navigation::run
