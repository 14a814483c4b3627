#include "runtime/measurements.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "base/statistics.h"

namespace ctn::runtime {
namespace {

double milliseconds(Nanos duration) { return to_millis(duration).count(); }

double seconds(Nanos duration) { return std::chrono::duration<double>(duration).count(); }

}  // namespace

void SampleWindow::add(double sample) {
  ++count_;
  if (samples_.size() < kSamples) {
    samples_.push_back(sample);
  } else {
    samples_[next_] = sample;
    next_ = (next_ + 1) % kSamples;
  }
}

Summary SampleWindow::summary() const {
  const SampleSummary summary = summarize(samples_);
  return {.count = count_,
          .mean = summary.mean,
          .p50 = summary.p50,
          .p95 = summary.p95,
          .p99 = summary.p99,
          .max = summary.max};
}

Measurements::Measurements(const graph::App& app, TimePoint warm_from, policy::CpuKinds kinds)
    : app_(app), warm_from_(warm_from), kinds_(std::move(kinds)), costs_(app), nodes_(app.graph.nodes().size()) {
  for (const graph::Term& term : app.objective) {
    if (term.metric != graph::Metric::kResponseTime) continue;
    chains_.push_back({record::ChainTracker(app.graph, term.path), term.path, {}, {}, {}, {}});
  }
}

std::optional<record::CostChange> Measurements::add(const record::Run& run, bool tells_costs) {
  NodeMeasure& node = nodes_[run.node.index()];
  std::optional<record::CostChange> change;
  if (tells_costs) change = costs_.add(run, kinds_.of(run.on_cpu));
  if (run.begin >= warm_from_) {
    ++node.runs;
    node.compute.add(milliseconds(run.cpu));
  }
  for (ChainMeasure& chain : chains_) {
    for (const record::ChainSample& sample : chain.tracker.add(run)) {
      // A response time reaches back to the source run before.
      const bool warm = sample.response && chain.last_begin >= warm_from_;
      chain.last_begin = sample.begin;
      if (!warm) continue;
      chain.response.add(milliseconds(*sample.response));
      chain.latency.add(milliseconds(sample.latency));
      chain.period.add(milliseconds(*sample.period));
    }
  }
  return change;
}

void Measurements::Prediction::accumulate(const Prediction& other, double for_seconds) {
  seconds += for_seconds;
  source_hz += other.source_hz * for_seconds;
  responses.resize(other.responses.size());
  for (std::size_t index = 0; index < responses.size(); ++index)
    responses[index] += other.responses[index] * for_seconds;
}

double Measurements::seconds_in_force(TimePoint until) const {
  return std::max(0.0, seconds(until - std::max(current_since_, warm_from_)));
}

void Measurements::plan_in_force(TimePoint since, const plan::Plan& plan, Rate source_rate) {
  if (current_) past_.accumulate(*current_, seconds_in_force(since));
  Prediction prediction;
  prediction.source_hz = source_rate.hertz();
  for (std::size_t index = 0; index < plan.chains.size(); ++index) {
    const Millis response = plan.expected ? plan.expected->chains[index].response : plan.chains[index].response;
    prediction.responses.push_back(response.count());
  }
  current_ = std::move(prediction);
  current_since_ = since;
}

std::optional<Measurements::Prediction> Measurements::mean_prediction(TimePoint now) const {
  if (!current_) return std::nullopt;
  Prediction mean = past_;
  mean.accumulate(*current_, seconds_in_force(now));
  if (mean.seconds <= 0.0) return current_;
  mean.source_hz /= mean.seconds;
  for (double& response : mean.responses) response /= mean.seconds;
  return mean;
}

void Measurements::fill(Snapshot& snapshot, TimePoint now, std::optional<double> hand_set_hz) const {
  snapshot.warmed_up = now >= warm_from_;
  const std::optional<Prediction> predicted = mean_prediction(now);
  snapshot.source_hz = hand_set_hz.value_or(predicted ? predicted->source_hz : 0.0);
  for (std::size_t index = 0; index < chains_.size(); ++index) {
    const ChainMeasure& chain = chains_[index];
    ChainSnapshot& shown = snapshot.chains.emplace_back();
    for (const NodeId node : chain.path) shown.path.push_back(app_.graph.node(node).name);
    shown.response_ms = chain.response.summary();
    shown.latency_ms = chain.latency.summary();
    shown.period_ms = chain.period.summary();
    if (predicted) shown.predicted_response_ms = predicted->responses[index];
  }
  const double measured_for = seconds(std::max(now - warm_from_, Nanos{0}));
  for (std::size_t index = 0; index < nodes_.size(); ++index) {
    const graph::Node& node = app_.graph.nodes()[index];
    if (node.external) continue;
    const double rate = measured_for > 0.0 ? static_cast<double>(nodes_[index].runs) / measured_for : 0.0;
    snapshot.nodes.push_back({node.name, nodes_[index].compute.summary(), rate});
  }
}

}  // namespace ctn::runtime
