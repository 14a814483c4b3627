#include "report/text.h"

#include <fmt/format.h>

#include <map>

#include "base/text.h"

namespace ctn::report {
namespace {

// Four digits are what a run can say.
std::string number(double value) {
  const double size = value < 0.0 ? -value : value;
  const int decimals = size >= 1000.0 ? 0 : size >= 100.0 ? 1 : size >= 10.0 ? 2 : 3;
  return fmt::format("{:.{}f}", value, decimals);
}
std::string number(const std::optional<double>& value) { return value ? number(*value) : "-"; }

// mean, p50, p95, p99, max
void append(std::vector<std::string>& row, const Summary& summary) {
  for (const double value : {summary.mean, summary.p50, summary.p95, summary.p99, summary.max}) {
    row.push_back(summary.count > 0 ? number(value) : "-");
  }
}

void add_chain_row(Table& table, const std::string& path, const char* metric, const Summary& measured,
                   std::optional<double> predicted, std::optional<double> bound = {},
                   std::optional<double> promised = {}) {
  std::vector<std::string> row{path, metric, bound ? number(*bound) : "", promised ? number(*promised) : "",
                               number(predicted)};
  append(row, measured);
  row.push_back(std::to_string(measured.count));
  table.rows.push_back(std::move(row));
}

Table chain_table(const RunFigures& metrics) {
  Table table{
      .header = {"chain", "in ms", "bound", "promised", "predicted", "mean", "p50", "p95", "p99", "max", "samples"},
      .caption = "Chains: predicted beside measured"};
  for (const ChainMetrics& chain : metrics.chains) {
    const auto predicted = [&](double ChainPrediction::*value) {
      return chain.predicted ? std::optional((*chain.predicted).*value) : std::nullopt;
    };
    add_chain_row(table, chain.path, "response time", chain.response_ms, predicted(&ChainPrediction::response_ms),
                  chain.bound_ms, predicted(&ChainPrediction::promised_response_ms));
    add_chain_row(table, "", "latency", chain.latency_ms, predicted(&ChainPrediction::latency_ms));
    add_chain_row(table, "", "period", chain.period_ms, predicted(&ChainPrediction::period_ms));
  }
  return table;
}

// Of chains whose responses were taken apart.
Table late_table(const RunFigures& metrics) {
  Table table{.header = {"chain", "late over ms", "", "late", "of responses", "by cause"},
              .caption = "Late responses, and what made them late; --why CHAIN takes the worst ones apart"};
  for (const ChainMetrics& chain : metrics.chains) {
    if (!chain.late || chain.late->responses == 0) continue;
    table.rows.push_back({chain.path, number(to_millis(chain.late->late_over).count()),
                          chain.late->bound ? "bound" : "p99", std::to_string(chain.late->late),
                          std::to_string(chain.late->responses), causes_in_words(*chain.late)});
  }
  return table;
}

Table node_table(const RunFigures& metrics) {
  Table table{.header = {"node", "Hz predicted", "Hz", "runs", "compute ms mean", "p50", "p95", "p99", "max", "cores"},
              .caption = "Nodes: rate, CPU time of a run, share of a core"};
  for (const NodeMetrics& node : metrics.nodes) {
    std::vector<std::string> row{node.name, number(node.predicted_rate_hz), number(node.rate_hz),
                                 std::to_string(node.runs)};
    append(row, node.compute_ms);
    row.push_back(fmt::format("{:.3f}", node.cores));
    table.rows.push_back(std::move(row));
  }
  return table;
}

// Of nodes whose runs wait: where their time goes. What is neither computing nor waiting is the part of runs in which
// others had the core; where several threads work on a run it cannot be told.
Table wait_table(const RunFigures& metrics) {
  Table table{.header = {"node", "wall ms mean", "compute ms mean", "wait ms mean", "p50", "p95", "p99", "max"},
              .caption = "Runs that wait, without using a core"};
  for (const NodeMetrics& node : metrics.nodes) {
    if (!node.wait_ms) continue;
    std::vector<std::string> row{node.name, number(node.wall_ms.mean), number(node.compute_ms.mean)};
    append(row, *node.wait_ms);
    table.rows.push_back(std::move(row));
  }
  return table;
}

Table age_table(const RunFigures& metrics) {
  Table table{.header = {"edge", "max_age", "on_stale", "stale", "of runs", "age ms mean", "p50", "p95", "p99", "max"},
              .caption = "Age of inputs: since the begin of the oldest source run"};
  for (const AgeSnapshot& edge : metrics.ages) {
    std::vector<std::string> row{edge.from + " -> " + edge.to, number(edge.max_age_ms), edge.skips ? "skip" : "run",
                                 std::to_string(edge.stale), std::to_string(edge.runs)};
    append(row, edge.age_ms);
    table.rows.push_back(std::move(row));
  }
  return table;
}

Table trigger_table(const RunFigures& metrics) {
  Table table{.header = {"subchain", "triggers", "late ms mean", "p50", "p95", "p99", "max"},
              .caption = "Triggers: how late they were sent"};
  for (const TriggerMetrics& trigger : metrics.triggers) {
    std::vector<std::string> row{trigger.subchain, std::to_string(trigger.late_ms.count)};
    append(row, trigger.late_ms);
    table.rows.push_back(std::move(row));
  }
  return table;
}

}  // namespace

std::string causes_in_words(const why::Analysis& late) {
  std::string text;
  for (const auto& [cause, count] : why::causes_by_count(late)) {
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", why::to_string(cause), count);
  }
  return text.empty() ? "-" : text;
}

std::vector<Table> tables(const RunFigures& metrics) {
  std::vector<Table> result;
  for (Table& table : std::vector<Table>{chain_table(metrics), late_table(metrics), node_table(metrics),
                                         wait_table(metrics), age_table(metrics), trigger_table(metrics)}) {
    if (!table.rows.empty()) result.push_back(std::move(table));
  }
  return result;
}

std::string headline(const RunFigures& metrics) {
  const record::Header& header = metrics.header;
  std::string text = fmt::format("{}, scheduler {}, {}, CPUs {}: {:.1f} s measured", metrics.app, header.scheduler,
                                 header.real_time ? "real-time levels" : "ordinary levels",
                                 header.cpus.empty() ? "unknown" : os::to_string(header.cpus), metrics.measured_s);
  const double warm_up = in_seconds(header.warm_up);
  if (warm_up > 0.0) {
    text += metrics.whole ? fmt::format(", {:.1f} s of warm-up included", warm_up)
                          : fmt::format(" after {:.1f} s of warm-up", warm_up);
  }
  text += fmt::format("; {:.2f} of {} cores used", metrics.cores_used, header.cpus.size());
  if (metrics.objective.measured || metrics.objective.predicted) {
    text += fmt::format("; objective {} measured, {} predicted", number(metrics.objective.measured),
                        number(metrics.objective.predicted));
  }
  return text;
}

std::vector<std::string> warnings(const RunFigures& metrics) {
  std::vector<std::string> result;
  if (!metrics.ending.closed) {
    result.emplace_back(
        "the record was not closed: the run goes on, or its process was killed; what came last is missing");
  }
  if (metrics.measured_s <= 0.0 && !metrics.whole) {
    result.emplace_back("the run ended before its warm-up did, so nothing is measured; --all includes the warm-up");
  }
  if (metrics.relax_factor > 1.0) {
    result.push_back(fmt::format("the bounds could not all be met; they were relaxed by a factor of up to {:.3g}",
                                 metrics.relax_factor));
  }
  if (metrics.for_typical) {
    result.emplace_back(
        "at the planned percentile of compute times some core would have no time for all, and no bound asks for it: "
        "what is promised is for what runs typically take");
  }
  if (!metrics.changes.empty()) {
    const AppChangeMetrics& last = metrics.changes.back();
    result.push_back(fmt::format(
        "weights or bounds were changed while it ran ({} in all, the last after {:.1f} s: {}); figures are by those in "
        "force at the end, but what was predicted is a mean over the plans of each time",
        metrics.changes.size(), last.at_s, last.what));
  }
  const double stolen = in_seconds(metrics.ending.stolen);
  if (stolen > 0.01) {
    result.push_back(fmt::format("a hypervisor took {:.2f} s of CPU time from this machine during the run", stolen));
  }
  std::map<std::string, std::pair<std::size_t, std::string>> kinds;  // how often, and what it said last
  for (const record::Notice& notice : metrics.notices) {
    auto& [count, detail] = kinds[notice.kind];
    ++count;
    detail = notice.detail;
  }
  for (const auto& [kind, said] : kinds) {
    const std::string times = said.first > 1 ? fmt::format(" ({} times, the last:)", said.first) : ":";
    result.push_back(fmt::format("{}{} {}", kind, times, said.second));
  }
  return result;
}

std::string to_text(const RunFigures& metrics) {
  std::string text = printable(headline(metrics)) + "\n";
  if (!metrics.header.note.empty()) text += "note: " + printable(metrics.header.note) + "\n";
  for (const std::string& warning : warnings(metrics)) text += "! " + printable(warning) + "\n";
  for (const Table& table : tables(metrics)) text += fmt::format("\n{}\n{}", table.caption, to_text(table));
  return text;
}

}  // namespace ctn::report
