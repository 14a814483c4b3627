// What has to be there before a run under some schedulers can begin: compute times, and plans of them
// (program/known_costs.h).
//
// Compute times are from a file (`--costs`), or else measured: the same world, seed and board under Catan on one core,
// a run of its own before the one that counts, which ends when that would.
//
// Thread safety: one thread.
#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "catan/result.h"
#include "program/temporary_folder.h"
#include "run/options.h"
#include "run/outcome.h"

namespace ctn::navigation::run {

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
  Options options_;
  std::shared_ptr<program::TemporaryFolder> folder_;  // its files go with it
  std::optional<Outcome> interrupted_;
};

}  // namespace ctn::navigation::run
