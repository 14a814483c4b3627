// Whether runs that are there may be looked at together. A folder may hold runs that were made with other options, or
// of a map that has changed since; medians and tests over both would tell of neither.
//
// Thread safety: pure functions, but for reading the map that a batch names.
#pragma once

#include <string>
#include <vector>

#include "run.h"

namespace ctn::case_studies {

struct Alike {
  std::vector<StoredRun> runs;
  std::string left_out;  // which others there are, and why they are not taken; empty: there are none
};

// Those of the runs that have the options which `arguments`, a batch's, ask for, in as far as runs tell of these (an
// option and the stored number or word of the same name; the contents of a map that is a file). Where the runs that
// remain differ among themselves all the same, none: which of them are meant cannot be told.
Alike alike(std::vector<StoredRun> runs, const std::vector<std::string>& arguments);

}  // namespace ctn::case_studies
