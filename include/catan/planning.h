// Planning ahead of a run: what `catan plan --json` prints, for programs. A plan that is kept in a file is followed by
// the policies "static:FILE" and "rates-of:FILE" (session.h), in life and in virtual time.
//
//   auto plan = ctn::make_plan("app.yaml", {.costs = "run.catan", .cores = 1});     // by a run that was recorded
//   std::ofstream("plan.json") << plan.value();
//   auto session = ctn::Session::open("app.yaml", {.policy = "static:plan.json"});
//
// Thread safety: pure functions, but for the files that they read.
#pragma once

#include <string>

#include "catan/result.h"

namespace ctn {

struct PlanningOptions {
  std::string costs;    // path of a cost file (docs/cost-file.md), or of the record of a run: then all its runs count
  int cores = 0;        // that the app is to have; 0: those that the app file lists, else 1
  double effort = 1.0;  // how long to search, as a multiple of a few seconds; from 0.001 to 1000
};

// The plan that the planner of the app file makes, as JSON (docs/plan-schema.md). The same files give the same plan on
// every machine. Errors (kCaller): all that is wrong with the files; cores or an effort out of range; rates that no
// plan keeps.
Result<std::string> make_plan(const std::string& app_file, const PlanningOptions& options);

}  // namespace ctn
