// Whether runs that are there may be looked at together. A folder may hold runs that were made with other options, or
// of a map that has changed since; medians and tests over both would tell of neither.
//
// Thread safety: pure functions.
#pragma once

#include <string>
#include <vector>

#include "run.h"

namespace ctn::case_studies {

struct Alike {
  std::vector<StoredRun> runs;
  std::string left_out;  // which others there are, and why they are not taken; empty: there are none
};

// Those of the runs that have the options which are `asked` for, in as far as runs tell of these. Where the runs that
// remain differ among themselves all the same, none: which of them are meant cannot be told.
Alike alike(std::vector<StoredRun> runs, const RunOptions& asked);

}  // namespace ctn::case_studies
