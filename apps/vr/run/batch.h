// Many runs that differ in their seed alone (program/batch.h), and what they come to.
//
// Thread safety: one thread.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "catan/result.h"
#include "program/figures.h"
#include "run/options.h"
#include "run/outcome.h"

namespace ctn::vr::run {

struct StoredRun {
  std::uint64_t seed = 0;
  std::vector<program::Figure> figures;
};

struct Batch {
  Options options;  // those of the first run
  std::vector<StoredRun> runs;
  int signal = 0;  // that ended it early; 0: none
};

// `run_one` runs with these options, of which the seed changes; `tell` is told about each run. Errors: its; those of
// program::run_batch().
Result<Batch> run_batch(const Options& options, const std::function<Result<Outcome>(const Options&)>& run_one,
                        const std::function<void(const std::string&)>& tell);

std::string to_json(const Batch& batch);
std::string to_text(const Batch& batch);

}  // namespace ctn::vr::run
