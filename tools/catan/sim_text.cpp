#include "sim_text.h"

#include <fmt/format.h>

#include <algorithm>

#include "report/table.h"

namespace ctn::tool {
namespace {

using sim::Outcome;
using sim::Seeded;

// The mean over runs of what `get` finds in each; runs in which there is nothing to find are left out.
template <class Get>
std::optional<double> mean(const std::vector<Seeded>& runs, Get&& get) {
  double sum = 0.0;
  int count = 0;
  for (const Seeded& run : runs) {
    const std::optional<double> value = get(run.outcome);
    if (!value) continue;
    sum += *value;
    ++count;
  }
  return count > 0 ? std::optional(sum / count) : std::nullopt;
}

std::string shown(const std::optional<double>& value) { return value ? fmt::format("{:.4g}", *value) : "-"; }

// mean, p50, p95, p99, max of a summary, which `get` finds.
template <class Get>
std::vector<std::string> cells(const std::vector<Seeded>& runs, Get&& get) {
  const auto of = [&](double Summary::*figure) {
    return shown(mean(runs, [&](const Outcome& outcome) -> std::optional<double> {
      const Summary& summary = get(outcome);
      return summary.count > 0 ? std::optional(summary.*figure) : std::nullopt;
    }));
  };
  double greatest = 0.0;
  for (const Seeded& run : runs) greatest = std::max(greatest, get(run.outcome).max);
  return {of(&Summary::mean), of(&Summary::p50), of(&Summary::p95), of(&Summary::p99), fmt::format("{:.4g}", greatest)};
}

void append(std::vector<std::string>& row, std::vector<std::string> more) {
  row.insert(row.end(), more.begin(), more.end());
}

template <class Get>
double sum(const std::vector<Seeded>& runs, Get&& get) {
  double total = 0.0;
  for (const Seeded& run : runs) total += static_cast<double>(get(run.outcome));
  return total;
}

std::string chains_text(const std::vector<Seeded>& runs) {
  report::Table table{.header = {"chain", "of", "predicted", "mean", "p50", "p95", "p99", "max", "bound", "over it"}};
  const std::vector<sim::ChainOutcome>& chains = runs.front().outcome.chains;
  for (std::size_t i = 0; i < chains.size(); ++i) {
    std::vector<std::string> row{chains[i].path, "response",
                                 shown(mean(runs, [&](const Outcome& run) { return run.chains[i].predicted_ms; }))};
    append(row, cells(runs, [&](const Outcome& run) -> const Summary& { return run.chains[i].response_ms; }));
    if (chains[i].bound_ms) {
      row.push_back(fmt::format("{:.4g}", *chains[i].bound_ms));
      const double over = sum(runs, [&](const Outcome& run) { return run.chains[i].over_bound; });
      const double all = sum(runs, [&](const Outcome& run) { return run.chains[i].response_ms.count; });
      row.push_back(all > 0.0 ? fmt::format("{:.3g} %", 100.0 * over / all) : "-");
    }
    table.rows.push_back(std::move(row));
    std::vector<std::string> latency{"", "latency", ""};
    append(latency, cells(runs, [&](const Outcome& run) -> const Summary& { return run.chains[i].latency_ms; }));
    table.rows.push_back(std::move(latency));
    std::vector<std::string> period{"", "period", ""};
    append(period, cells(runs, [&](const Outcome& run) -> const Summary& { return run.chains[i].period_ms; }));
    table.rows.push_back(std::move(period));
  }
  return to_text(table);
}

bool waits_in(const std::vector<Seeded>& runs, std::size_t node) {
  return std::any_of(runs.begin(), runs.end(), [&](const Seeded& run) { return run.outcome.nodes[node].wait_ms; });
}

// Empty where no node waits.
std::string waits_text(const std::vector<Seeded>& runs) {
  static const Summary kNone;
  report::Table table{.header = {"node", "wait mean", "p50", "p95", "p99", "max"}};
  const std::vector<sim::NodeOutcome>& nodes = runs.front().outcome.nodes;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (!waits_in(runs, i)) continue;
    std::vector<std::string> row{nodes[i].name};
    append(row, cells(runs, [&](const Outcome& run) -> const Summary& {
             return run.nodes[i].wait_ms ? *run.nodes[i].wait_ms : kNone;
           }));
    table.rows.push_back(std::move(row));
  }
  return table.rows.empty() ? "" : "Runs that wait, without using a core (ms)\n" + to_text(table) + "\n";
}

std::string nodes_text(const std::vector<Seeded>& runs) {
  report::Table table{.header = {"node", "rate", "compute mean", "compute p95", "period mean", "period p95", ""}};
  const std::vector<sim::NodeOutcome>& nodes = runs.front().outcome.nodes;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const auto figure = [&](Summary sim::NodeOutcome::*summary, double Summary::*which) {
      return shown(mean(runs, [&](const Outcome& run) -> std::optional<double> {
        const Summary& of = run.nodes[i].*summary;
        return of.count > 0 ? std::optional(of.*which) : std::nullopt;
      }));
    };
    const bool slow =
        std::any_of(runs.begin(), runs.end(), [&](const auto& run) { return run.outcome.nodes[i].too_slow; });
    const bool fast =
        std::any_of(runs.begin(), runs.end(), [&](const auto& run) { return run.outcome.nodes[i].too_fast; });
    const auto rate = mean(runs, [&](const Outcome& run) { return std::optional(run.nodes[i].rate_hz); });
    table.rows.push_back(
        {nodes[i].name, fmt::format("{:.4g} Hz", rate.value_or(0.0)),
         figure(&sim::NodeOutcome::compute_ms, &Summary::mean), figure(&sim::NodeOutcome::compute_ms, &Summary::p95),
         figure(&sim::NodeOutcome::period_ms, &Summary::mean), figure(&sim::NodeOutcome::period_ms, &Summary::p95),
         slow   ? "below its min_rate"
         : fast ? "above its max_rate"
                : ""});
  }
  return to_text(table);
}

std::string ages_text(const std::vector<Seeded>& runs) {
  const std::vector<AgeSnapshot>& edges = runs.front().outcome.ages;
  if (edges.empty()) return "";
  report::Table table{
      .header = {"edge", "max_age", "on_stale", "stale", "of runs", "age mean", "p50", "p95", "p99", "max"}};
  for (std::size_t i = 0; i < edges.size(); ++i) {
    std::vector<std::string> row{
        edges[i].from + " -> " + edges[i].to, fmt::format("{:.6g}", edges[i].max_age_ms),
        edges[i].skips ? "skip" : "run",
        fmt::format("{:.0f}", sum(runs, [&](const Outcome& run) { return run.ages[i].stale; })),
        fmt::format("{:.0f}", sum(runs, [&](const Outcome& run) { return run.ages[i].runs; }))};
    append(row, cells(runs, [&](const Outcome& run) -> const Summary& { return run.ages[i].age_ms; }));
    table.rows.push_back(std::move(row));
  }
  return "Age of inputs (ms)\n" + to_text(table) + "\n";
}

std::string cores_text(const std::vector<Seeded>& runs) {
  std::string text;
  for (std::size_t core = 0; core < runs.front().outcome.cores.size(); ++core) {
    const double used =
        sum(runs, [&](const Outcome& run) { return run.cores[core].real_time + run.cores[core].ordinary; });
    text += fmt::format("{}{}: {:.1f} %", core == 0 ? "" : ", ", core, 100.0 * used / static_cast<double>(runs.size()));
  }
  return text;
}

}  // namespace

std::string sim_text(const std::vector<Seeded>& runs, int cores) {
  const Outcome& first = runs.front().outcome;
  std::string text = fmt::format("{} under {} on {} core{}: {:.6g} s of simulated time", first.app, first.scheduler,
                                 cores, cores == 1 ? "" : "s", first.measured_s);
  text += runs.size() == 1 ? fmt::format(", seed {}\n\n", runs.front().seed)
                           : fmt::format(", seeds {} to {}: means over {} runs\n\n", runs.front().seed,
                                         runs.back().seed, runs.size());
  text += "Chains (ms)\n" + chains_text(runs) + "\nNodes (ms)\n" + nodes_text(runs) + "\n" + waits_text(runs) +
          ages_text(runs);
  const auto objective = mean(runs, [](const Outcome& run) { return run.objective; });
  const auto predicted = mean(runs, [](const Outcome& run) { return run.objective_predicted; });
  text += fmt::format("objective  {}{}\n", shown(objective),
                      predicted ? fmt::format(" (predicted {})", shown(predicted)) : "");
  text += fmt::format("cores      {}\n", cores_text(runs));
  if (first.plans_adopted > 0) {
    text += fmt::format("plans      {:.0f} made, {:.0f} in force\n",
                        sum(runs, [](const Outcome& run) { return run.plans_made; }),
                        sum(runs, [](const Outcome& run) { return run.plans_adopted; }));
  }
  const auto count = [&](const char* name, auto get) {
    const double total = sum(runs, get);
    if (total > 0.0) text += fmt::format("{:<10} {:.0f}\n", name, total);
  };
  count("steals", [](const Outcome& run) { return run.steals; });
  count("hangs", [](const Outcome& run) { return run.hangs; });
  count("overruns", [](const Outcome& run) { return run.budget_overruns; });
  count("dropped", [](const Outcome& run) { return run.dropped; });
  count("throttled", [](const Outcome& run) { return run.throttled; });
  for (const Seeded& run : runs) {
    for (const std::string& notice : run.outcome.notices) {
      text += runs.size() == 1 ? notice + "\n" : fmt::format("seed {}: {}\n", run.seed, notice);
    }
  }
  return text;
}

}  // namespace ctn::tool
