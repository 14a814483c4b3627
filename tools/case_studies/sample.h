// For tests: a study of two schedulers with made-up runs; and the studies that there are.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <string>
#include <vector>

#include "studies.h"

namespace ctn::case_studies {

// Of all programs, or of one.
inline std::vector<std::string> ids_of_studies(const std::string& program = "") {
  std::vector<std::string> ids;
  for (const Study& study : make_studies(Setting())) {
    if (program.empty() || study.program == program) ids.push_back(study.id);
  }
  return ids;
}

inline Study study_with(const std::string& id, const Setting& setting = {}) {
  const std::vector<Study> studies = make_studies(setting);
  return *std::ranges::find(studies, id, &Study::id);
}

// As a part of a test's name.
inline std::string as_name(const ::testing::TestParamInfo<std::string>& id) {
  std::string name = id.param;
  std::ranges::replace(name, '-', '_');
  return name;
}

inline Metric made_up(std::string name, const std::string& figure, Better better, Method method) {
  return {.name = std::move(name),
          .value = [figure](const StoredRun& run) { return run.figure(figure); },
          .better = better,
          .method = method};
}

inline Study sample_study() {
  Study study;
  study.id = "sample";
  study.program = "navigation";
  study.title = "A study <made up>";
  study.text = "Nothing is done.";
  study.measurements = {{"whole-run", {"--scheduler", "catan"}, 60.0}};
  study.batches = {{.name = "catan",
                    .label = "Catan",
                    .group = {},
                    .reference = true,
                    .arguments = {"--virtual"},
                    .runs = 8,
                    .costs = {},
                    .seconds = 100.0},
                   {.name = "other",
                    .label = "another",
                    .group = {},
                    .arguments = {"--virtual"},
                    .runs = 8,
                    .costs = "whole-run",
                    .seconds = 100.0}};
  study.metrics = {made_up("Collisions", "collided", Better::kLower, Method::kShares),
                   made_up("Score", "score", Better::kHigher, Method::kPairs),
                   made_up("Time", "time", Better::kLower, Method::kRanks)};
  study.metrics[2].missing = std::numeric_limits<double>::infinity();
  study.claim = [](const Study&, const Runs&) {
    return std::vector<Claim>{{"It is so", "7 beside 8", 0.0004, Verdict::kHeld},
                              {"It is not so", "8 beside 7", 0.7, Verdict::kNotShown},
                              {"It is otherwise", "9 beside 7", {}, Verdict::kFailed}};
  };
  return study;
}

// The other never collides, which Catan always does; it has the worse score by 1; and its time is that of Catan, but
// for `slower`. One of Catan's runs never came to its time.
inline Runs sample_runs(double slower) {
  Runs runs;
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    const auto number = static_cast<double>(seed);
    StoredRun ours{seed, {{"collided", 1.0}, {"score", number}, {"time", number}}, {{"x_by_1s", {1.0, number, 3.0}}}};
    if (seed == 8) ours.figures.erase("time");
    const StoredRun other{seed,
                          {{"collided", 0.0}, {"score", number - 1.0}, {"time", number + slower}},
                          {{"x_by_1s", {2.0, number, 2.0}}}};
    runs["catan"].push_back(ours);
    runs["other"].push_back(other);
  }
  return runs;
}

}  // namespace ctn::case_studies
