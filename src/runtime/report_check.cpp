#include "runtime/report_check.h"

#include <algorithm>

#include "runtime/region.h"

namespace ctn::runtime {
namespace {

// Two clocks are compared, each read at its own time.
constexpr Nanos kTolerance = std::chrono::milliseconds{1};
constexpr Nanos kLongest = std::chrono::hours{24};
// Numbers go into columns of 64 bits with a sign.
constexpr std::uint64_t kHighestNumber = std::uint64_t{1} << 62U;

}  // namespace

ReportCheck::ReportCheck(const graph::Graph& graph) : graph_(graph), known_(graph.nodes().size()) {}

bool ReportCheck::accept(record::Run& run, TimePoint now) {
  Known& known = known_[run.node.index()];
  if (!is_plausible(run, now) || !has_credit(known, now)) {
    ++rejected_;
    return false;
  }
  known.number = run.number;
  known.end = run.end;
  std::erase_if(run.consumed,
                [](const record::Consumed& range) { return range.first > range.last || range.last > kHighestNumber; });
  return true;
}

bool ReportCheck::is_plausible(const record::Run& run, TimePoint now) const {
  const Known& known = known_[run.node.index()];
  const std::size_t modes = std::max<std::size_t>(graph_.node(run.node).modes.size(), 1);
  if (run.number <= known.number || run.number > kHighestNumber || run.mode >= modes) return false;
  if (run.begin < known.end || run.end < run.begin || run.end > now + kTolerance) return false;
  const Nanos wall = run.end - run.begin;
  if (run.begin < TimePoint{} || wall > kLongest) return false;
  if (run.wait < Nanos{0} || run.wait > wall || run.elapsed < Nanos{0} || run.elapsed > wall) return false;
  if (run.threads < 1 || run.threads > std::max(graph_.node(run.node).max_threads, 1)) return false;
  return run.cpu >= Nanos{0} && run.cpu <= wall * static_cast<std::int64_t>(NodeCell::kMaxThreads) + kTolerance;
}

bool ReportCheck::has_credit(Known& known, TimePoint now) const {
  constexpr Nanos kEach = Nanos{std::chrono::seconds{1}} / kMaxRuns;
  const std::int64_t earned = std::clamp<std::int64_t>((now - known.credited) / kEach, 0, kMaxRuns);
  known.credit = std::min(known.credit + earned, kMaxRuns);
  if (earned > 0) known.credited = now;
  return known.credit > 0 && known.credit-- > 0;
}

void ReportCheck::restart(NodeId node) { known_[node.index()].end = {}; }

}  // namespace ctn::runtime
