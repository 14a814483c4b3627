// Which parts of a run a page has run by run: a long record has more runs than a page can hold.
//
// The run's time is cut into equal cells. Those come first around which a reader will look: the worst responses of each
// chain, the beginning, changes of plan and what else happened; then the rest, from the beginning on, as far as the
// budget goes.
//
// Thread safety: pure functions.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "page/story.h"

namespace ctn::page {

// Takes cells in the order of `wanted`, then all others in their own order, each that still fits in the budget.
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

// `budget`: bytes of the page, about.
Detail choose_detail(const Story& story, std::size_t budget);

// The longest of a chain, the worst first.
std::vector<ResponsePoint> worst_responses(std::span<const ResponsePoint> responses, std::size_t count);

}  // namespace ctn::page
