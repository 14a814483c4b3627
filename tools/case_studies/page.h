// The page of all studies, and what a terminal shows of them. Pure, save that figures are drawn by gnuplot.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/result.h"
#include "experiments/host.h"
#include "study.h"

namespace ctn::case_studies {

struct StudyResults {
  Study study;
  Runs runs;
};

struct Map {
  std::string name;
  std::string svg;
};

struct Results {
  experiments::Facts host;
  bool quick = false;
  std::uint64_t seed = 1;  // of each batch's first run
  std::vector<Map> maps;
  std::vector<std::string> failed;    // names of jobs
  std::vector<std::string> left_out;  // runs that are there and do not belong to the others
  std::vector<StudyResults> studies;
};

// Errors: gnuplot is missing or fails.
Result<std::string> render_page(const Results& results);

// The claims, what was left out, and where another scheduler does better.
std::string to_text(const Results& results);

}  // namespace ctn::case_studies
