// The case studies' list.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "study.h"

namespace ctn::case_studies {

// What of the studies can be chosen.
struct Setting {
  bool quick = false;                              // few and short runs, so that all of it takes ten minutes
  int max_runs = std::numeric_limits<int>::max();  // of a batch
  double max_seconds = std::numeric_limits<double>::infinity();  // of a run
  std::string map1 = "1";                                        // with a goal, and things that move
  std::string map2 = "2";                                        // to be explored
  std::vector<std::string> detector{"--detector", "hog"};        // options that say which
  int cpu = 0;                                                   // of the nodes of runs in life
  std::string no_life{};                                         // why there can be none; empty: there can
};

std::vector<Study> make_studies(const Setting& setting);

// The studies of an app that cannot be run here are missing, if they are not already; `why` in whole sentences.
void leave_out(std::vector<Study>& studies, const std::string& program, const std::string& why);

}  // namespace ctn::case_studies
