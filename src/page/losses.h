// Which lanes had the core while a run did not. This is inferred from what others on the core did meanwhile, since
// records say only when a run began and ended, how much CPU time it took and how long it waited.
//
// Where fixed priorities share a core, a run loses it to runs of higher priority that begin while it is under way; in
// frames, to what others run in their slots, or in slots that they steal. Nothing is lost if computing and waiting
// account for all of the run's time, or if its subchain owns its cores.
//
// Units: Micros. Thread safety: immutable once built.
#pragma once

#include <vector>

#include "page/story.h"

namespace ctn::page {

struct Loss {
  Micros begin = 0;
  Micros end = 0;
  std::size_t lane = 0;  // the one that had the core
  friend bool operator==(const Loss&, const Loss&) = default;
};

class Losses {
 public:
  static constexpr std::size_t kMax = 64;  // losses of one run; later ones are left out

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
