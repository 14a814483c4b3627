// Who had the core while a run did not: found from what the others on the core did meanwhile, since records say only
// when a run began and ended, and how much CPU time it took.
//
// On a core of fixed priorities a run loses it to runs of higher priority that begin while it is under way; on one in
// frames, to what others run in their slots, or in those that they steal. Nothing is lost where the run's time is all
// accounted for by what it computed and waited, or where its subchain owns its cores.
//
// Units: Micros. Thread safety: immutable once built.
#pragma once

#include <vector>

#include "page/story.h"

namespace ctn::page {

struct Loss {
  Micros begin = 0;
  Micros end = 0;
  std::size_t lane = 0;  // that had the core
  friend bool operator==(const Loss&, const Loss&) = default;
};

class Losses {
 public:
  static constexpr std::size_t kMost = 64;  // of a run: what comes later is left out

  // `story` outlives it.
  explicit Losses(const Story& story);

  // In the order of time, without overlap.
  std::vector<Loss> of(const RunSpan& run) const;

 private:
  struct Claim {
    Micros begin = 0;
    Micros end = 0;
    std::size_t lane = 0;
    int priority = 0;  // 0: in a slot
  };
  const Story& story_;
  std::vector<std::vector<Claim>> claims_;  // by core, by begin
};

}  // namespace ctn::page
