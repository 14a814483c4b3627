// The case studies as they were when Catan was first compared with other policies, frozen in bench/cases, so that
// figures of then and now are of the same apps, whatever becomes of apps/.
//
// Units: in the types. Thread safety: pure functions, but for the files.
#pragma once

#include <string>

#include "graph/app.h"
#include "model/workload.h"

namespace ctn::bench {

struct Case {
  std::string name;
  graph::App app;
  model::Workload work;
};

// Where the frozen files of a case begin: add ".yaml", ".costs.yaml" or ".load.yaml".
std::string frozen_files(const std::string& name);

// "navigation", "navigation_with_detector" or "vr", with its load. Throws std::runtime_error, with what is wrong.
Case frozen_case(const std::string& name);

}  // namespace ctn::bench
