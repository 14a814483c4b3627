#include "page/losses.h"

#include <optional>

#include "why/run_parts.h"

namespace ctn::page {
namespace {

constexpr Micros kUnexplained = 20;  // so little time of a run that is not accounted for is no loss

}  // namespace

std::vector<Loss> losses_of(const Story& story, const RunSpan& run) {
  std::vector<Loss> losses;
  const Micros lost = run.end - run.begin - static_cast<Micros>(1e3F * (run.cpu_ms + run.wait_ms));
  if (lost < kUnexplained || !story.history) return losses;
  const std::optional<why::RunRef> ref = story.history->find(NodeId(run.node), run.number);
  if (!ref) return losses;
  for (const why::Part& part : why::parts_of_run(*story.history, *ref)) {
    if (!part.by || story.lane_of[part.by->index()] == story.lane_of[run.node]) continue;
    const Loss loss{when(story, part.begin), when(story, part.end), story.lane_of[part.by->index()]};
    if (loss.begin >= loss.end) continue;
    if (!losses.empty() && losses.back().end == loss.begin && losses.back().lane == loss.lane) {
      losses.back().end = loss.end;
    } else if (losses.size() < kMaxLosses) {
      losses.push_back(loss);
    }
  }
  return losses;
}

}  // namespace ctn::page
