#include "report/metrics.h"

#include <algorithm>
#include <utility>

#include "record/lineage.h"
#include "report/predictions.h"

namespace ctn::report {
namespace {

double ms(Nanos duration) { return to_millis(duration).count(); }

struct Interval {
  TimePoint begin;
  TimePoint end;

  bool holds(TimePoint from, TimePoint to) const { return from >= begin && to <= end; }
  double seconds() const { return std::chrono::duration<double>(end - begin).count(); }
};

class ChainMeter {
 public:
  ChainMeter(const graph::Graph& graph, const graph::Term& term) : term_(&term), tracker_(graph, term.path) {}

  void add(const record::Run& run, const Interval& interval) {
    for (const record::ChainSample& sample : tracker_.add(run)) {
      if (interval.holds(sample.begin, sample.end)) latencies_.push_back(ms(sample.latency));
      if (sample.response && interval.holds(sample.end - *sample.response, sample.end)) {
        responses_.push_back(ms(*sample.response));
      }
      if (sample.period && interval.holds(sample.end - *sample.period, sample.end)) {
        periods_.push_back(ms(*sample.period));
      }
    }
  }

  ChainMetrics finish(const graph::Graph& graph) {
    ChainMetrics metrics;
    metrics.path = graph.path_name(term_->path);
    metrics.weight = term_->weight;
    if (term_->max) metrics.bound_ms = ms(*term_->max);
    metrics.response_ms = summarize(std::move(responses_));
    metrics.latency_ms = summarize(std::move(latencies_));
    metrics.period_ms = summarize(std::move(periods_));
    return metrics;
  }

 private:
  const graph::Term* term_;
  record::ChainTracker tracker_;
  std::vector<double> responses_;
  std::vector<double> latencies_;
  std::vector<double> periods_;
};

class NodeMeter {
 public:
  void add(const record::Run& run, const Interval& interval) {
    if (last_end_ && interval.holds(*last_end_, run.end)) periods_.push_back(ms(run.end - *last_end_));
    last_end_ = run.end;
    if (!interval.holds(run.begin, run.end)) return;
    compute_.push_back(ms(run.cpu));
    wall_.push_back(ms(run.end - run.begin));
    outputs_ += run.emitted ? 1 : 0;
    cpu_s_ += ms(run.cpu) / 1000.0;
  }

  NodeMetrics finish(const std::string& name, double seconds) {
    NodeMetrics metrics;
    metrics.name = name;
    metrics.runs = compute_.size();
    metrics.outputs = outputs_;
    metrics.rate_hz = seconds > 0.0 ? static_cast<double>(compute_.size()) / seconds : 0.0;
    metrics.cores = seconds > 0.0 ? cpu_s_ / seconds : 0.0;
    metrics.period_ms = summarize(std::move(periods_));
    metrics.compute_ms = summarize(std::move(compute_));
    metrics.wall_ms = summarize(std::move(wall_));
    return metrics;
  }

 private:
  std::optional<TimePoint> last_end_;
  std::vector<double> periods_;
  std::vector<double> compute_;
  std::vector<double> wall_;
  std::uint64_t outputs_ = 0;
  double cpu_s_ = 0.0;
};

Status measure_runs(const record::Reader& record, const Interval& interval, RunMetrics& metrics) {
  const graph::App& app = record.app();
  std::vector<ChainMeter> chains;
  for (const graph::Term& term : app.objective) {
    if (term.metric == graph::Metric::kResponseTime) chains.emplace_back(app.graph, term);
  }
  std::vector<NodeMeter> nodes(app.graph.nodes().size());
  const Status done = record.each_run([&](const record::Run& run) {
    nodes[run.node.index()].add(run, interval);
    for (ChainMeter& chain : chains) chain.add(run, interval);
  });
  if (!done) return done;
  for (ChainMeter& chain : chains) metrics.chains.push_back(chain.finish(app.graph));
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (app.graph.nodes()[i].external) continue;
    metrics.nodes.push_back(nodes[i].finish(app.graph.nodes()[i].name, metrics.measured_s));
    metrics.cores_used += metrics.nodes.back().cores;
  }
  return Done{};
}

Status measure_triggers(const record::Reader& record, const Interval& interval, RunMetrics& metrics) {
  const auto subchains = record.app().graph.subchains();
  std::vector<std::vector<double>> late(subchains.size());
  const Status done = record.each_trigger([&](const record::Trigger& trigger) {
    if (interval.holds(trigger.sent, trigger.sent))
      late[trigger.subchain.index()].push_back(ms(trigger.sent - trigger.due));
  });
  if (!done) return done;
  for (std::size_t i = 0; i < subchains.size(); ++i) {
    if (!late[i].empty()) metrics.triggers.push_back({subchains[i].name, summarize(std::move(late[i]))});
  }
  return Done{};
}

NodeMetrics* find_node(RunMetrics& metrics, const std::string& name) {
  const auto found = std::find_if(metrics.nodes.begin(), metrics.nodes.end(),
                                  [&](const NodeMetrics& node) { return node.name == name; });
  return found == metrics.nodes.end() ? nullptr : &*found;
}

void put_predictions(const Predictions& predicted, const graph::App& app, RunMetrics& metrics) {
  metrics.plans = predicted.plans;
  metrics.relax_factor = predicted.relax_factor;
  metrics.objective.predicted = predicted.objective;
  for (std::size_t i = 0; i < metrics.chains.size(); ++i) metrics.chains[i].predicted = predicted.chains[i];
  for (std::size_t i = 0; i < predicted.rate_hz.size(); ++i) {
    if (NodeMetrics* node = find_node(metrics, app.graph.nodes()[i].name))
      node->predicted_rate_hz = predicted.rate_hz[i];
  }
}

void measure_objective(const graph::App& app, RunMetrics& metrics) {
  double sum = 0.0;
  bool all = true;
  std::size_t chain = 0;
  for (const graph::Term& term : app.objective) {
    const SampleSummary* measured = nullptr;
    if (term.metric == graph::Metric::kResponseTime) {
      measured = &metrics.chains[chain++].response_ms;
    } else if (NodeMetrics* node = find_node(metrics, app.graph.node(term.path.front()).name)) {
      node->weight = node->weight.value_or(0.0) + term.weight;
      measured = &node->period_ms;
    }
    if (term.weight == 0.0) continue;
    all = all && measured != nullptr && measured->count > 0;
    if (all) sum += term.weight * measured->mean;
  }
  if (all) metrics.objective.measured = sum;
}

}  // namespace

Result<RunMetrics> measure(const record::Reader& record, bool whole) {
  RunMetrics metrics;
  metrics.app = record.app().name;
  metrics.header = record.header();
  metrics.ending = record.ending();
  metrics.whole = whole;
  const Nanos warm_up = whole ? Nanos{0} : metrics.header.warm_up;
  const TimePoint begin = std::min(metrics.header.started + warm_up, metrics.ending.ended);
  const Interval interval{begin, metrics.ending.ended};
  metrics.measured_s = interval.seconds();

  if (auto done = measure_runs(record, interval, metrics); !done) return done.error();
  if (auto done = measure_triggers(record, interval, metrics); !done) return done.error();
  const auto predicted = predictions(record, interval.begin, interval.end);
  if (!predicted) return predicted.error();
  put_predictions(*predicted, record.app(), metrics);
  measure_objective(record.app(), metrics);
  auto notices = record.notices();
  if (!notices) return notices.error();
  metrics.notices = std::move(*notices);
  return metrics;
}

}  // namespace ctn::report
