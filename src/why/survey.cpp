#include "why/survey.h"

#include <algorithm>
#include <utility>

namespace ctn::why {
namespace {

constexpr double kLatePercentile = 99.0;

}  // namespace

Lengths lengths_of(std::vector<double> responses_ms, std::optional<Nanos> bound) {
  if (responses_ms.empty()) return {};
  Lengths lengths;
  std::sort(responses_ms.begin(), responses_ms.end());
  lengths.late_over = bound.value_or(to_nanos(Millis{percentile_of_sorted(responses_ms, kLatePercentile)}));
  lengths.response_ms = summarize(std::move(responses_ms));
  lengths.usually_late = to_nanos(Millis{lengths.response_ms.p50}) > lengths.late_over;
  return lengths;
}

Survey::Survey(const graph::App& app, const std::vector<std::size_t>& terms, const record::Interval& measured)
    : app_(app),
      measured_(measured),
      cpu_(app.graph.nodes().size()),
      usual_cpu_(app.graph.nodes().size()),
      read_(app.graph.nodes().size()) {
  for (const std::size_t term : terms) {
    chains_.push_back({term, record::ChainTracker(app.graph, app.objective[term].path)});
  }
}

void Survey::add(const record::Run& run) {
  cpu_[run.node.index()].add(run.cpu);
  longest_run_ = std::max(longest_run_, run.end - run.begin);
  knows_cpus_ = knows_cpus_ || run.on_cpu >= 0;
  for (Chain& chain : chains_) {
    for (const record::ChainSample& sample : chain.tracker.add(run)) {
      const std::optional<TimePoint> begin = std::exchange(chain.before, sample.begin);
      if (!begin || !sample.response || !measured_.holds(*begin, sample.end) || *begin >= sample.end) continue;
      chain.responses_ms.push_back(to_millis(sample.end - *begin).count());
    }
  }
}

void Survey::add(const record::ClockReading& reading) {
  read_[reading.node.index()] = true;
  for (Chain& chain : chains_) chain.tracker.set_clock(reading.node, reading.ticks);
}

void Survey::finish() {
  for (Chain& chain : chains_) {
    lengths_.push_back(lengths_of(std::move(chain.responses_ms), app_.objective[chain.term].max));
  }
  for (std::size_t node = 0; node < cpu_.size(); ++node) {
    if (cpu_[node].size() > 0) usual_cpu_[node] = cpu_[node].of_rank((cpu_[node].size() - 1) / 2);
  }
  chains_.clear();
  cpu_.clear();
}

}  // namespace ctn::why
