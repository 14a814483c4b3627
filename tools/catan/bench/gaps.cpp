#include "bench/gaps.h"

#include <algorithm>

namespace ctn::tool {

void GapLog::spin(os::Clock& clock, TimePoint until) {
  TimePoint before = clock.now();
  while (before < until) {
    const TimePoint now = clock.now();
    if (now - before >= kShortest && gaps_.size() < kMax) gaps_.push_back({before, now});
    before = now;
  }
}

std::vector<Nanos> hand_overs(std::span<const TimePoint> slice_ends, std::span<const Gap> gaps) {
  std::vector<Nanos> found;
  for (std::size_t index = 0; index < slice_ends.size(); ++index) {
    const TimePoint end = slice_ends[index];
    const auto over =
        std::upper_bound(gaps.begin(), gaps.end(), end, [](TimePoint time, const Gap& gap) { return time < gap.end; });
    if (over == gaps.end() || over->begin > end) continue;
    if (index + 1 < slice_ends.size() && over->end >= slice_ends[index + 1]) continue;
    found.push_back(over->end - end);
  }
  return found;
}

}  // namespace ctn::tool
