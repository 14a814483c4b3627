#include "report/metrics.h"

#include <algorithm>
#include <chrono>
#include <optional>
#include <utility>

#include "record/ages.h"
#include "record/app_changes.h"
#include "record/run_metrics.h"
#include "report/predictions.h"
#include "why/why.h"

namespace ctn::report {
namespace {

double ms(Nanos duration) { return to_millis(duration).count(); }

double seconds(const record::Interval& interval) { return in_seconds(interval.end - interval.begin); }

ChainMetrics metrics_of(const record::MeasuredChain<record::AllSamples>& chain, const graph::Graph& graph) {
  ChainMetrics metrics;
  metrics.path = graph.path_name(chain.term->path);
  metrics.weight = chain.term->weight;
  if (chain.term->max) metrics.bound_ms = ms(*chain.term->max);
  metrics.response_ms = chain.response.summary_ms();
  metrics.latency_ms = chain.latency.summary_ms();
  metrics.period_ms = chain.period.summary_ms();
  return metrics;
}

NodeMetrics metrics_of(const record::MeasuredNode<record::AllSamples>& node, const std::string& name, double seconds) {
  NodeMetrics metrics;
  metrics.name = name;
  metrics.runs = node.runs;
  metrics.outputs = node.outputs;
  metrics.rate_hz = seconds > 0.0 ? static_cast<double>(node.runs) / seconds : 0.0;
  metrics.cores = seconds > 0.0 ? in_seconds(node.cpu) / seconds : 0.0;
  metrics.period_ms = node.period.summary_ms();
  metrics.compute_ms = node.compute.summary_ms();
  if (node.waits) metrics.wait_ms = node.wait.summary_ms();
  return metrics;
}

NodeMetrics* find_node(RunFigures& metrics, const std::string& name) {
  const auto found = std::find_if(metrics.nodes.begin(), metrics.nodes.end(),
                                  [&](const NodeMetrics& node) { return node.name == name; });
  return found == metrics.nodes.end() ? nullptr : &*found;
}

// What must be known of the run to find out why responses were late, if that is asked.
Result<std::optional<why::Survey>> measure_runs(const record::Reader& record, const graph::App& app,
                                                const record::Interval& interval, const Asked& asked,
                                                RunFigures& metrics) {
  record::RunMetrics<record::AllSamples> measured(app, interval);
  std::vector<record::AllSamples> wall(app.graph.nodes().size());
  std::optional<record::AgeTracker> ages;
  if (!measured.edges().empty()) ages.emplace(app.graph);
  record::Run aged;
  std::optional<why::Survey> survey;
  if (asked.worst) survey.emplace(app, why::chains_of(app), interval);
  const auto clocks = record.clocks();
  if (!clocks) return clocks.error();
  auto reading = clocks->begin();
  const Status done = record.each_run([&](const record::Run& run) {
    if (asked.see) asked.see(run);
    for (; reading != clocks->end() && reading->at <= run.end; ++reading) {
      measured.set_clock(reading->node, reading->ticks);
      if (survey) survey->add(*reading);
    }
    if (survey) survey->add(run);
    if (ages) {
      aged = run;
      ages->add(aged);
    }
    measured.add(ages ? aged : run);
    if (interval.holds(run.begin, run.end)) wall[run.node.index()].add(run.end - run.begin);
  });
  if (!done) return done.error();
  if (survey) survey->finish();
  for (const auto& chain : measured.chains()) metrics.chains.push_back(metrics_of(chain, app.graph));
  for (std::size_t i = 0; i < wall.size(); ++i) {
    const graph::Node& node = app.graph.nodes()[i];
    if (node.external) continue;
    metrics.nodes.push_back(metrics_of(measured.node(NodeId(i)), node.name, metrics.measured_s));
    metrics.nodes.back().wall_ms = wall[i].summary_ms();
    metrics.cores_used += metrics.nodes.back().cores;
  }
  for (const graph::Term& term : app.objective) {
    if (term.metric == graph::Metric::kResponseTime) continue;
    NodeMetrics* const node = find_node(metrics, app.graph.node(term.path.front()).name);
    if (node != nullptr) node->weight = node->weight.value_or(0.0) + term.weight;
  }
  metrics.objective.measured = measured.objective(app);
  metrics.ages = measured.ages(app.graph);
  return survey;
}

Status measure_triggers(const record::Reader& record, const record::Interval& interval, RunFigures& metrics) {
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

void put_predictions(const plan::Predictions& predicted, const graph::App& app, RunFigures& metrics) {
  metrics.plans = predicted.plans;
  metrics.relax_factor = predicted.relax_factor;
  metrics.for_typical = predicted.for_typical;
  metrics.objective.predicted = predicted.objective;
  for (std::size_t i = 0; i < metrics.chains.size(); ++i) metrics.chains[i].predicted = predicted.chains[i];
  for (std::size_t i = 0; i < predicted.rate_hz.size(); ++i) {
    if (NodeMetrics* node = find_node(metrics, app.graph.nodes()[i].name))
      node->predicted_rate_hz = predicted.rate_hz[i];
  }
}

}  // namespace

Result<RunFigures> measure(const record::Reader& record, const Asked& asked) {
  RunFigures metrics;
  metrics.app = record.app().name;
  metrics.header = record.header();
  metrics.ending = record.ending();
  metrics.whole = asked.whole;
  const Nanos warm_up = asked.whole ? Nanos{0} : metrics.header.warm_up;
  const TimePoint begin = std::min(metrics.header.started + warm_up, metrics.ending.ended);
  const record::Interval interval{begin, metrics.ending.ended};
  metrics.measured_s = seconds(interval);

  const auto changes = record.app_changes();
  if (!changes) return changes.error();
  for (const record::AppChange& change : *changes) {
    const double at_s = in_seconds(change.at - metrics.header.started);
    metrics.changes.push_back({at_s, record::describe(record.app(), change)});
  }
  const Result<graph::App> app = record::app_after(record.app(), *changes);
  if (!app) return app.error();
  const auto survey = measure_runs(record, *app, interval, asked, metrics);
  if (!survey) return survey.error();
  if (*survey) {
    auto analyses = why::analyse(record, *app, why::chains_of(*app), interval, **survey, *asked.worst);
    if (!analyses) return analyses.error();
    for (std::size_t i = 0; i < analyses->size(); ++i) metrics.chains[i].late = std::move((*analyses)[i]);
  }
  if (auto done = measure_triggers(record, interval, metrics); !done) return done.error();
  const auto predicted = predictions(record, interval.begin, interval.end);
  if (!predicted) return predicted.error();
  put_predictions(*predicted, *app, metrics);
  auto notices = record.notices();
  if (!notices) return notices.error();
  metrics.notices = std::move(*notices);
  return metrics;
}

}  // namespace ctn::report
