// Which parts of a recorded run a page has in full detail, run by run: a long record has more runs than a page can
// hold.
//
// The record's time is cut into equal cells. Cells that a reader will most likely look at come first: those around the
// worst responses of each chain, the beginning, changes of plan and other events; then the rest, from the beginning on,
// as far as the budget goes.
//
// Thread safety: pure functions.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "page/story.h"

namespace ctn::page {

// Takes cells in the order of `wanted`, then all others in their own order, skipping those that do not fit in what is
// left of the budget.
std::vector<bool> choose(std::span<const std::size_t> cost, std::span<const std::size_t> wanted, std::size_t budget);

struct Detail {
  Micros duration = 0;
  std::vector<bool> cells;

  bool has(Micros at) const;
  bool whole() const;
  Micros covered() const;
  // The chosen parts, neighbours joined: begins and ends in turn.
  std::vector<Micros> windows() const;
};

// `budget`: about how many bytes of the page it may take.
Detail choose_detail(const Story& story, std::size_t budget);

// The `count` longest responses, the longest first.
std::vector<ResponsePoint> worst_responses(std::span<const ResponsePoint> responses, std::size_t count);

}  // namespace ctn::page
