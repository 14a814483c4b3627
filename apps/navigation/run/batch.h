// Many drives that differ in their seed alone (program/batch.h), and what they come to: medians and spread.
//
// Thread safety: one thread.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "catan/result.h"
#include "run/options.h"
#include "run/outcome.h"
#include "run/stored_run.h"

namespace ctn::navigation::run {

struct Batch {
  Options options;  // those of the first run
  std::vector<StoredRun> runs;
  int signal = 0;  // that ended it early; 0: none
};

// Of a figure by time (StoredRun::staleness, detector_periods), for each stretch the median of the runs; of those that
// lasted so long and had something to measure then.
ByTime medians_by_time(const std::vector<StoredRun>& runs, ByTime StoredRun::*figure);

// `run_one` runs with these options (of which the seed changes); `tell` is told about each run. Errors: its; a folder
// or a file that cannot be written; a file that is of other options (kCaller).
Result<Batch> run_batch(const Options& options, const std::function<Result<Outcome>(const Options&)>& run_one,
                        const std::function<void(const std::string&)>& tell);

std::string to_json(const Batch& batch);
std::string to_text(const Batch& batch);

}  // namespace ctn::navigation::run
