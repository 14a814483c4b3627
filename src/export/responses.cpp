#include "export/responses.h"

#include <vector>

namespace ctn::exports {

Status each_response(const record::Reader& record, const std::function<void(const record::Run&)>& take_run,
                     const std::function<void(std::size_t chain, const record::ChainSample&)>& take) {
  std::vector<record::ChainTracker> trackers;
  for (const graph::Term& term : record.app().objective) {
    if (term.metric == graph::Metric::kResponseTime) trackers.emplace_back(record.app().graph, term.path);
  }
  const auto clocks = record.clocks();
  if (!clocks) return clocks.error();
  auto reading = clocks->begin();
  return record.each_run([&](const record::Run& run) {
    for (; reading != clocks->end() && reading->at <= run.end; ++reading) {
      for (record::ChainTracker& tracker : trackers) tracker.set_clock(reading->node, reading->ticks);
    }
    take_run(run);
    for (std::size_t chain = 0; chain < trackers.size(); ++chain) {
      for (const record::ChainSample& sample : trackers[chain].add(run)) take(chain, sample);
    }
  });
}

}  // namespace ctn::exports
