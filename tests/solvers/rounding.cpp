#include "solvers/rounding.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace ctn::solvers {
namespace {

using planner::Allocation;
using planner::Instance;
using planner::Member;
using planner::Timing;

double chosen_frame(const Instance& instance, const std::vector<std::size_t>& members,
                    const std::vector<Timing>& relaxed, Frame frame) {
  double longest = std::numeric_limits<double>::infinity();
  double shortest = 0.0;
  for (const std::size_t i : members) {
    if (!instance.members[i].queue) longest = std::min(longest, relaxed[i].period);
    shortest = std::max(shortest, relaxed[i].period / instance.members[i].on[0].most_every);
  }
  // Only queue nodes: nothing is rounded, so any frame will do.
  return frame == Frame::kLongest && std::isfinite(longest) ? longest : shortest;
}

void round_core(const Instance& instance, const std::vector<std::size_t>& members, Frame frame,
                std::vector<Timing>& timings) {
  const double chosen = chosen_frame(instance, members, timings, frame);
  std::vector<double> every;
  double busy = 0.0;
  double least = 0.0;
  for (const std::size_t i : members) {
    const Member& member = instance.members[i];
    const double n = timings[i].period / chosen;
    every.push_back(member.queue ? n : std::clamp(std::round(n), 1.0, member.on[0].most_every));
    busy += member.on[0].cost / every.back();
    least = std::max(least, member.min_period / every.back());
  }
  const double made = std::max(busy / instance.usable, least);
  for (std::size_t m = 0; m < members.size(); ++m) timings[members[m]] = {made * every[m], made * every[m]};
}

}  // namespace

std::vector<Timing> rounded(const Instance& instance, const Allocation& allocation, const std::vector<Timing>& relaxed,
                            Frame frame) {
  std::vector<Timing> timings = relaxed;
  for (int core = 0; core < allocation.shared_cores; ++core) {
    std::vector<std::size_t> members;
    for (std::size_t i = 0; i < allocation.core_of.size(); ++i) {
      if (allocation.core_of[i] == core) members.push_back(i);
    }
    round_core(instance, members, frame, timings);
  }
  return timings;
}

planner::Allocation dealt(const planner::Instance& instance) {
  planner::Allocation allocation;
  allocation.shared_cores = instance.cores();
  for (std::size_t i = 0; i < instance.members.size(); ++i) {
    allocation.core_of.push_back(static_cast<int>(i) % instance.cores());
    allocation.owned.push_back(0);
    allocation.kind.push_back(0);
  }
  return allocation;
}

}  // namespace ctn::solvers
