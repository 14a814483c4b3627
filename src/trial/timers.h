// When what happens next: one time for each of a fixed number of sources. Of several at one time the lowest number
// comes first.
//
// How: a tournament. The sources are the leaves of a tree, each inner node has the earlier of the two below it, the
// root the earliest of all; what changes is decided again on one way up.
//
// Thread safety: none; one owner.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/time.h"

namespace ctn::trial {

class Timers {
 public:
  using Source = std::uint32_t;

  // No source is due.
  explicit Timers(std::size_t sources) : leaves_(std::bit_ceil(std::max<std::size_t>(sources, 2))), tree_(2 * leaves_) {
    for (std::size_t leaf = 0; leaf < leaves_; ++leaf) tree_[leaves_ + leaf].source = static_cast<Source>(leaf);
    for (std::size_t inner = leaves_ - 1; inner > 0; --inner) tree_[inner] = tree_[2 * inner];
  }

  TimePoint next() const { return tree_[1].time; }
  Source next_source() const { return tree_[1].source; }

  // kNever: not at all.
  void set(Source source, TimePoint time) {
    std::size_t at = leaves_ + source;
    if (tree_[at].time == time) return;
    tree_[at].time = time;
    while (at > 1) {
      at /= 2;
      const Entry& left = tree_[2 * at];
      const Entry& right = tree_[2 * at + 1];
      const Entry earlier = right.time < left.time ? right : left;
      if (tree_[at].time == earlier.time && tree_[at].source == earlier.source) return;
      tree_[at] = earlier;
    }
  }

 private:
  struct Entry {
    TimePoint time = kNever;
    Source source = 0;
  };

  std::size_t leaves_;
  std::vector<Entry> tree_;  // from 1: the two below node k are 2k and 2k + 1
};

}  // namespace ctn::trial
