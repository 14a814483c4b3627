// Free shares beside fixed whole numbers: frames and the periods of queue nodes, when every n is decided. A convex
// problem in a few variables (the sum of C / p over a core is convex in p, maxima of linear forms are convex), solved
// by an interior-point method: Newton steps on a logarithmic barrier (Boyd and Vandenberghe, Convex Optimization,
// section 11.3).
//
// Limits that cannot all be met are missed as little as their penalty allows; the caller checks.
//
// Units: milliseconds. Thread safety: pure.
#pragma once

#include <vector>

#include "planner/instance.h"

namespace ctn::planner {

struct Target;

struct FrameFit {
  const Instance& instance;
  const Target& target;
  const std::vector<std::vector<int>>& members;  // by shared core
  const std::vector<double>& cost;               // by subchain: on the core that it has
  const std::vector<double>& most_every;         // by subchain: n at most
  const std::vector<double>& usable;             // of each, less what exact queue nodes take
  const std::vector<double>& min_frame;
  const std::vector<double>& max_frame;

  // `every`: n of all that are not queue nodes. `timings`: in, of the subchains that own their cores; out, of all.
  // False where there is no frame with room for everything.
  bool solve(const std::vector<double>& every, std::vector<Timing>& timings, std::vector<double>& frames) const;
};

}  // namespace ctn::planner
