// What has to be there before runs can begin: the app file, and under schedulers that decide by compute times these, or
// a plan of them (program/known_costs.h).
//
// Compute times are from a file (`--costs`), or else measured before each run: the same headset, seed and board under
// Catan on one core.
//
// Thread safety: one thread.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <variant>

#include "catan/result.h"
#include "program/temporary_folder.h"
#include "run/options.h"
#include "run/outcome.h"

namespace ctn::vr::run {

class Prepared {
 public:
  // Errors: an app file that cannot be made; a calibration or a data set that cannot be read.
  static Result<Prepared> make(const Options& options);

  // With the app file, fingerprints of what runs depend on, and the clocks of a data set's pictures and samples.
  const Options& options() const { return options_; }

  // The options to run with; or the run that was to measure, where a signal has ended it. `options` are options() with
  // another seed; `measure` runs with other ones, with a record. Errors: its; those of planning.
  using Ready = std::variant<Options, Outcome>;
  Result<Ready> for_run(const Options& options, const std::function<Result<Outcome>(const Options&)>& measure);

 private:
  Options options_;
  std::shared_ptr<program::TemporaryFolder> folder_;  // its files go with it
  std::string policy_;                                // once it is known for all runs
};

}  // namespace ctn::vr::run
