// What a batch needs of a run: its figures, read back from the JSON that was printed of it. So a run that was stored
// and one that has just ended are treated alike.
//
// Thread safety: values, pure functions.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "catan/result.h"
#include "run/options.h"
#include "run/outcome.h"

namespace ctn::navigation::run {

struct StoredRun {
  std::uint64_t seed = 0;
  std::string ended_by;
  std::vector<Figure> figures;
  ByTime staleness;         // p95 in ms, for each 5 s
  ByTime detector_periods;  // in ms, for each 10 s; empty where there is no detector

  std::optional<double> figure(const std::string& name) const;
};

// `text`: what to_json() gave; `file` names it in errors. Errors (kCaller): it is none; it is of a run with other
// options than these, the seed included.
Result<StoredRun> read_run(const std::string& text, const std::string& file, const Options& options);

}  // namespace ctn::navigation::run
