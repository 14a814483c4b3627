#include "planner/run_spread.h"

#include <cstdint>
#include <utility>

#include "base/time.h"

namespace ctn::planner {

RunSpread::RunSpread(std::vector<double> runs) {
  std::sort(runs.begin(), runs.end());
  const std::size_t each = runs.size() / kParts;
  double sum = 0.0;
  for (std::size_t part = 0; part < kParts; ++part) {
    for (std::size_t at = part * each; at < (part + 1) * each; ++at)
      parts_[part] += runs[at] / static_cast<double>(each);
    sum += parts_[part];
  }
  for (double& part : parts_) part -= sum / static_cast<double>(kParts);
}

RunSpread RunSpread::of(const graph::Subchain& subchain, const trial::Samples& samples, std::size_t kind) {
  constexpr std::uint32_t kRuns = 512;
  constexpr std::uint32_t kApart = trial::Samples::kDraws / kRuns;
  static_assert(kRuns % kParts == 0);
  std::vector<double> runs(kRuns, 0.0);
  for (const NodeId node : subchain.nodes) {
    for (std::uint32_t run = 0; run < kRuns; ++run)
      runs[run] += to_millis(samples.draw(node, kind, run * kApart)).count();
  }
  return RunSpread(std::move(runs));
}

double RunSpread::lost_triggers(const Lengths& lengths, double apart) const {
  constexpr double kMadeUpFor = 1.5;  // the run began with one, and at any time between two of them
  double lost = 0.0;
  for (auto more = parts_.rbegin(); more != parts_.rend(); ++more) {
    const double length = (lengths.mean + *more) * lengths.stretch + lengths.waits;
    if (length <= kMadeUpFor * apart) break;
    lost += length / apart - kMadeUpFor;
  }
  return lost / static_cast<double>(kParts);
}

}  // namespace ctn::planner
