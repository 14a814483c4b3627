// What has to be there before a run under some schedulers can begin: compute times, and plans of them.
//
//   static-full-run   the plan that Catan would make of a whole run's compute times, on one core; then it stays. On
//                     more cores its rates are set by hand, under ordinary scheduling, as in the paper
//   static-20s        the same, of the first 20 s
//   davare, verucchi, picas, deadline: decide once, by the compute times of a whole run
//
// Compute times are from a file (`--costs`), or else measured: the same world, seed and board under Catan on one core,
// a run of its own before the one that counts, which ends when that would.
//
// Thread safety: one thread.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "catan/result.h"
#include "run/options.h"
#include "run/outcome.h"

namespace ctn::navigation::run {

// Whether the scheduler decides by compute times that have to be known before.
bool needs_costs(const std::string& scheduler);

class Scheme {
 public:
  // In real time the options name CPUs (options.cpp). `run` lets the robot drive with other options than these, with a
  // record. Errors: its; those of planning; a folder for files that are in use while this lives cannot be made
  // (kEnvironment).
  static Result<Scheme> prepare(const Options& options, const std::function<Result<Outcome>(const Options&)>& run);

  // The options to run with: the policy that is meant.
  const Options& options() const { return options_; }
  // The run that was to measure, where a signal has ended it; then there is nothing to run with.
  const std::optional<Outcome>& interrupted() const { return interrupted_; }

 private:
  class Folder;
  Options options_;
  std::shared_ptr<Folder> folder_;  // its files go with it
  std::optional<Outcome> interrupted_;
};

}  // namespace ctn::navigation::run
