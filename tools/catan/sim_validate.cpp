#include "sim_validate.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "api/policies.h"
#include "plan/json.h"
#include "record/reader.h"
#include "report/metrics.h"
#include "sim/recorded_costs.h"
#include "sim/simulation.h"
#include "table.h"

namespace ctn::tool {
namespace {

using Json = nlohmann::ordered_json;

struct SummaryFigure {
  const char* name;
  double Summary::*value;
};
constexpr std::array kFigures{SummaryFigure{"mean", &Summary::mean}, SummaryFigure{"p50", &Summary::p50},
                              SummaryFigure{"p95", &Summary::p95}, SummaryFigure{"p99", &Summary::p99}};

// As a fraction of what was measured.
std::optional<double> error_of(const Summary& real, const Summary& simulated, const SummaryFigure& figure) {
  if (real.count == 0 || simulated.count == 0 || !(real.*figure.value > 0.0)) return std::nullopt;
  return simulated.*figure.value / (real.*figure.value) - 1.0;
}

std::string percent(std::optional<double> error) { return error ? fmt::format("{:+.1f} %", *error * 100.0) : "-"; }

Result<std::vector<sim::TimedPlan>> plans_of(const record::Reader& record) {
  const auto changes = record.plans();
  if (!changes) return changes.error();
  std::vector<sim::TimedPlan> plans;
  for (const record::PlanChange& change : *changes) {
    auto plan = plan::from_json(change.json, record.app(), fmt::format("plan {} of the record", plans.size() + 1));
    if (!plan) return plan.error();
    plans.push_back({std::max(change.at - record.header().started, Nanos{0}), std::move(*plan)});
  }
  return plans;
}

// When the timer of a node with a period was due first. A run never begins before its timer is due, so the first one
// may have been late; of the first kRuns, the one that begins earliest in its period tells by how much. A begin that is
// more than kLatest earlier is of another grid, and tells nothing.
class FirstDue {
 public:
  explicit FirstDue(Nanos period) : period_(period) {}

  // In the order of its runs.
  void add(Nanos begin) {
    if (count_++ == 0) first_ = begin;
    if (count_ > kRuns) return;
    const Nanos late = (begin - first_) % period_;
    const Nanos sooner = late > period_ / 2 ? period_ - late : Nanos{0};
    if (sooner < kLatest) sooner_ = std::max(sooner_, sooner);
  }
  // 0: it never ran.
  Nanos estimate(Nanos min_late) const { return std::max(first_ - sooner_ - min_late, Nanos{0}); }

 private:
  static constexpr int kRuns = 100;
  static constexpr Nanos kLatest = std::chrono::milliseconds{1};

  Nanos period_;
  Nanos first_{0};
  Nanos sooner_{0};
  int count_ = 0;
};

// When each unscheduled node and each subchain was to begin first. No timer is late by less than `min_late`.
Result<sim::Phases> phases_of(const record::Reader& record, Nanos min_late) {
  const graph::Graph& graph = record.app().graph;
  const TimePoint started = record.header().started;
  std::vector<std::optional<FirstDue>> nodes(graph.nodes().size());
  for (std::size_t index = 0; index < nodes.size(); ++index) {
    const graph::Node& node = graph.nodes()[index];
    if (node.unscheduled && node.period) nodes[index].emplace(*node.period);
  }
  const Nanos never = Nanos::max();
  sim::Phases phases{std::vector<Nanos>(graph.nodes().size()), std::vector<Nanos>(graph.subchains().size(), never)};
  Status read = record.each_run([&](const record::Run& run) {
    if (nodes[run.node.index()]) nodes[run.node.index()]->add(run.begin - started);
  });
  if (!read) return read.error();
  read = record.each_trigger([&](const record::Trigger& trigger) {
    Nanos& first = phases.subchains[trigger.subchain.index()];
    first = std::min(first, std::max(trigger.due - started, Nanos{0}));
  });
  if (!read) return read.error();
  for (std::size_t index = 0; index < nodes.size(); ++index) {
    if (nodes[index]) phases.nodes[index] = nodes[index]->estimate(min_late);
  }
  const auto clocks = record.clocks();
  if (!clocks) return clocks.error();
  phases.clocks.resize(nodes.size());
  for (const record::ClockReading& reading : *clocks) {
    phases.clocks[reading.node.index()] = {reading.ticks.tick - (started - TimePoint{}), reading.ticks.period};
  }
  std::replace(phases.subchains.begin(), phases.subchains.end(), never, Nanos{0});
  return phases;
}

// A load of ordinary threads that wants as much of each core as the kernel took from real-time threads in the record.
std::vector<sim::BackgroundLoad> background_of(const record::Reader& record) {
  constexpr Nanos kEach = std::chrono::seconds{1};
  const int cores = static_cast<int>(record.header().cpus.size());
  const Nanos duration = record.ending().ended - record.header().started;
  if (record.ending().starved == Nanos{0} || duration <= Nanos{0}) return {};
  const double part = std::min(Millis{record.ending().starved} / Millis{duration} / cores, 1.0);
  std::vector<sim::BackgroundLoad> loads;
  for (int core = 0; core < cores; ++core) {
    loads.push_back({core, Nanos{std::llround(part * static_cast<double>(kEach.count()))}, kEach});
  }
  return loads;
}

Result<sim::Outcome> simulate(const record::Reader& record, std::shared_ptr<const sim::RecordedRuns> runs,
                              double measured_s, const std::function<void(double)>& on_progress) {
  const record::Header& header = record.header();
  sim::Options options;
  auto plans = plans_of(record);
  if (!plans) return plans.error();
  // What was planned is in the record; the planner of that time need not be asked again.
  auto policy = api::simulated_policy(plans->empty() ? header.scheduler : "catan", record.app());
  if (!policy) return policy.error();
  options.policy = std::move(policy->policy);
  options.reserve = std::move(policy->reserve);
  options.plans = std::move(*plans);
  options.machine.cores = static_cast<int>(header.cpus.size());
  options.machine.real_time = header.real_time;
  options.machine.background = background_of(record);
  options.stealing = header.stealing;
  options.slack = header.slack;
  const sim::MachineCosts& costs_of = options.machine.costs;
  const bool ordinary = !header.real_time || !options.policy->raises();
  auto phases = phases_of(record, costs_of.timer_latency + (ordinary ? costs_of.ordinary_timer_min : Nanos{0}));
  if (!phases) return phases.error();
  options.phases = std::move(*phases);
  auto costs = std::make_unique<sim::RecordedCosts>(
      record.app(), std::move(runs), sim::RecordedCosts::Order::kAsRecorded, 1, options.machine.costs.mean_run());
  return sim::simulate(record.app(), std::move(costs), std::move(options), to_nanos(Millis{measured_s * 1000.0}),
                       on_progress);
}

void add_rows(Table& table, const std::string& path, const char* metric, const Summary& real,
              const Summary& simulated) {
  std::vector<std::string> cells{path, metric};
  for (const SummaryFigure& figure : kFigures) {
    const bool any = real.count > 0 && simulated.count > 0;
    cells.push_back(any ? fmt::format("{:.4g} / {:.4g}", real.*figure.value, simulated.*figure.value) : "-");
    cells.push_back(percent(error_of(real, simulated, figure)));
  }
  table.add(std::move(cells));
}

Json json_of(const Summary& real, const Summary& simulated) {
  Json json = Json::object();
  for (const SummaryFigure& figure : kFigures) {
    const auto error = error_of(real, simulated, figure);
    json[figure.name] = {{"measured", real.count > 0 ? Json(real.*figure.value) : Json(nullptr)},
                         {"simulated", simulated.count > 0 ? Json(simulated.*figure.value) : Json(nullptr)},
                         {"error", error ? Json(*error) : Json(nullptr)}};
  }
  return json;
}

}  // namespace

Result<Validation> validate_against(const std::string& path, const std::function<void(double)>& on_progress) {
  const auto record = record::Reader::open(path);
  if (!record) return record.error();
  const auto real = report::measure(*record);
  if (!real) return real.error();
  const auto runs = sim::RecordedRuns::read(*record, record->app());
  if (!runs) return runs.error();
  const auto simulated =
      simulate(*record, std::make_shared<const sim::RecordedRuns>(*runs), real->measured_s, on_progress);
  if (!simulated) return simulated.error();

  Table table({"chain", "in ms", "mean", "", "p50", "", "p95", "", "p99", ""});
  Json chains = Json::array();
  std::optional<double> worst;  // of p50 and p95 of response times; none: nothing was measured, or simulated
  for (std::size_t i = 0; i < real->chains.size(); ++i) {
    const report::ChainMetrics& there = real->chains[i];
    const sim::ChainOutcome& here = simulated->chains[i];
    add_rows(table, there.path, "response time", there.response_ms, here.response_ms);
    add_rows(table, "", "latency", there.latency_ms, here.latency_ms);
    add_rows(table, "", "period", there.period_ms, here.period_ms);
    chains.push_back({{"path", there.path},
                      {"response_ms", json_of(there.response_ms, here.response_ms)},
                      {"latency_ms", json_of(there.latency_ms, here.latency_ms)},
                      {"period_ms", json_of(there.period_ms, here.period_ms)}});
    for (const SummaryFigure& figure : {kFigures[1], kFigures[2]}) {
      const auto error = error_of(there.response_ms, here.response_ms, figure);
      if (error) worst = std::max(worst.value_or(0.0), std::abs(*error));
    }
  }
  Table nodes({"node", "Hz", "simulated", ""});
  Json node_list = Json::array();
  for (std::size_t i = 0; i < real->nodes.size(); ++i) {
    const report::NodeMetrics& there = real->nodes[i];
    const sim::NodeOutcome& here = simulated->nodes[i];
    const auto error = there.rate_hz > 0.0 ? std::optional(here.rate_hz / there.rate_hz - 1.0) : std::nullopt;
    nodes.add({there.name, fmt::format("{:.4g}", there.rate_hz), fmt::format("{:.4g}", here.rate_hz), percent(error)});
    node_list.push_back({{"node", there.name},
                         {"measured_hz", there.rate_hz},
                         {"simulated_hz", here.rate_hz},
                         {"error", error ? Json(*error) : Json(nullptr)}});
  }

  Validation result;
  result.text = fmt::format(
      "{} under {} on {} cores, {:.1f} s: measured / simulated, and the error\n\n{}\n{}\n"
      "Worst error of a p50 or p95 of response times: {}\n",
      real->app, real->header.scheduler, real->header.cpus.size(), real->measured_s, table.text(), nodes.text(),
      worst ? fmt::format("{:.1f} %", *worst * 100.0) : "none, as none was measured");
  const Json json{{"app", real->app},
                  {"scheduler", real->header.scheduler},
                  {"cores", real->header.cpus.size()},
                  {"measured_s", real->measured_s},
                  {"chains", chains},
                  {"nodes", node_list},
                  {"worst_response_error", worst ? Json(*worst) : Json(nullptr)}};
  result.json = json.dump(2) + "\n";
  return result;
}

}  // namespace ctn::tool
