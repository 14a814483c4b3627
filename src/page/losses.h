// Which lanes had the core while a run did not: the parts of the run that why/run_parts.h finds, as its bar in the
// timeline shows them.
//
// Nothing is lost if computing and waiting account for all of the run's time. What other nodes of its own lane ran
// meanwhile is no loss.
//
// Units: Micros. Thread safety: a pure function.
#pragma once

#include <cstddef>
#include <vector>

#include "page/story.h"

namespace ctn::page {

struct Loss {
  Micros begin = 0;
  Micros end = 0;
  std::size_t lane = 0;  // the one that had the core
  friend bool operator==(const Loss&, const Loss&) = default;
};

constexpr std::size_t kMaxLosses = 64;  // of one run; later ones are left out

// In the order of time, without overlap.
std::vector<Loss> losses_of(const Story& story, const RunSpan& run);

}  // namespace ctn::page
