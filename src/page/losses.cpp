#include "page/losses.h"

#include <algorithm>
#include <optional>

namespace ctn::page {
namespace {

constexpr std::size_t kMaxClaims = 4096;  // that are looked at for one run
constexpr Micros kUnexplained = 20;       // so little time of a run that is not accounted for is no loss

// The core of a lane that has one; none: it has no core, or several.
std::optional<Placement> only_place(const Story& story, std::size_t lane, Micros at) {
  const PlanSpan* const plan = plan_at(story, at);
  std::optional<Placement> found;
  if (plan == nullptr) return found;
  for (const Placement& placement : plan->placements) {
    if (placement.lane != lane) continue;
    if (found) return std::nullopt;
    found = placement;
  }
  return found;
}

}  // namespace

Losses::Losses(const Story& story) : story_(story), claims_(story.cores) {
  std::vector<std::vector<SlotSpan>> slots(story.lanes.size());
  for (const SlotSpan& slot : story.slots) slots[slot.lane].push_back(slot);
  for (const StealSpan& steal : story.steals) slots[steal.slot.lane].push_back(steal.slot);
  for (auto& of_lane : slots) {
    std::sort(of_lane.begin(), of_lane.end(), [](const auto& a, const auto& b) { return a.begin < b.begin; });
  }
  for (const RunSpan& run : story.runs) {
    const std::size_t lane = story.lane_of[run.node];
    const auto place = only_place(story, lane, run.begin);
    if (!place) continue;
    if (place->priority > 0) {
      claims_[place->core].push_back({run.begin, run.end, lane, place->priority});
      continue;
    }
    auto slot = std::upper_bound(slots[lane].begin(), slots[lane].end(), run.begin,
                                 [](Micros time, const SlotSpan& one) { return time < one.begin; });
    if (slot != slots[lane].begin()) --slot;
    for (std::size_t looked = 0; looked < kMaxClaims && slot != slots[lane].end() && slot->begin < run.end; ++looked) {
      const Micros begin = std::max(run.begin, slot->begin);
      const Micros end = std::min(run.end, slot->end);
      if (slot->core == place->core && begin < end) claims_[place->core].push_back({begin, end, lane});
      ++slot;
    }
  }
  for (auto& claims : claims_) {
    std::sort(claims.begin(), claims.end(), [](const Claim& a, const Claim& b) { return a.begin < b.begin; });
  }
}

std::vector<Loss> Losses::of(const RunSpan& run) const {
  std::vector<Loss> losses;
  const std::size_t lane = story_.lane_of[run.node];
  Micros lost = run.end - run.begin - static_cast<Micros>(1e3F * (run.cpu_ms + run.wait_ms));
  if (lost < kUnexplained) return losses;
  const auto place = only_place(story_, lane, run.begin);
  if (!place) return losses;
  const std::vector<Claim>& claims = claims_[place->core];
  auto claim = std::upper_bound(claims.begin(), claims.end(), run.begin,
                                [](Micros time, const Claim& one) { return time < one.begin; });
  Micros from = run.begin;
  for (std::size_t looked = 0; looked < kMaxClaims && losses.size() < kMax && lost > 0; ++looked, ++claim) {
    if (claim == claims.end() || claim->begin >= run.end) break;
    const bool pre_empts = place->priority > 0 ? claim->priority > place->priority : claim->priority == 0;
    if (claim->lane == lane || !pre_empts) continue;
    const Micros begin = std::max(from, claim->begin);
    const Micros end = std::min({run.end, claim->end, begin + lost});
    if (end <= begin) continue;
    if (!losses.empty() && losses.back().end == begin && losses.back().lane == claim->lane) {
      losses.back().end = end;
    } else {
      losses.push_back({begin, end, claim->lane});
    }
    lost -= end - begin;
    from = end;
  }
  return losses;
}

}  // namespace ctn::page
