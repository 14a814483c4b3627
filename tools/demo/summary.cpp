#include "summary.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <tuple>

namespace ctn::demo {
namespace {

constexpr double kNearBest = 1.05;       // Catan's response time over the best of the sweep
constexpr double kClearlyBelow = 0.95;   // and over the default's
constexpr double kPredictionOff = 0.10;  // measured, compared with predicted

using Key = std::tuple<std::size_t, double, int, double, std::string>;  // in the order of Summary::rows

Key key_of(const Measured& run) {
  const std::string& scheduler = run.trial.scheduler;
  const int kind = scheduler == "default" ? 0 : scheduler == "catan" ? 1 : 2;
  return {run.trial.cpus.size(), run.trial.speed, kind, kind == 2 ? run.source_hz : 0.0, scheduler};
}

template <class Get>
Spread spread(const std::vector<const Measured*>& runs, Get get) {
  std::vector<double> values;
  for (const Measured* run : runs) values.push_back(get(*run));
  return spread_of(std::move(values));
}

Row row_of(const std::vector<const Measured*>& runs) {
  const Trial& trial = runs.front()->trial;
  Row row;
  row.cores = trial.cpus.size();
  row.scheduler = trial.scheduler;
  row.speed = trial.speed;
  row.rounds = runs.size();
  row.source_hz = spread(runs, [](const Measured& run) { return run.source_hz; });
  row.response_ms = spread(runs, [](const Measured& run) { return run.response_ms; });
  row.response_p95_ms = spread(runs, [](const Measured& run) { return run.response_p95_ms; });
  if (std::ranges::all_of(runs, [](const Measured* run) { return run->predicted_ms.has_value(); })) {
    row.predicted_ms = spread(runs, [](const Measured& run) { return *run.predicted_ms; });
  }
  row.angle_deg = spread(runs, [](const Measured& run) { return run.angle_deg; });
  row.lost_fraction = spread(runs, [](const Measured& run) { return run.lost_fraction; });
  return row;
}

// The least response time of the hand-set rates, the default's among them; null where none was run.
const Row* best_by_hand(const Summary& summary, std::size_t cores, double speed) {
  const Row* best = nullptr;
  for (const Row& row : summary.rows) {
    if (row.cores != cores || row.speed != speed || row.scheduler == "catan") continue;
    if (best == nullptr || row.response_ms.median < best->response_ms.median) best = &row;
  }
  return best;
}

void claim_response(Summary& summary, std::size_t cores, double speed) {
  const Row* catan = find_row(summary, cores, "catan", speed);
  const Row* standard = find_row(summary, cores, "default", speed);
  const Row* best = best_by_hand(summary, cores, speed);
  if (catan == nullptr) return;
  const double ours = catan->response_ms.median;
  if (best != nullptr) {
    const double min = best->response_ms.median;
    summary.claims.push_back({cores, "Response time within 5 % of the best hand-set rate, found by trying",
                              fmt::format("{:.1f} ms beside {:.1f} ms at {:.1f} Hz ({:+.1f} %)", ours, min,
                                          best->source_hz.median, 100.0 * (ours / min - 1.0)),
                              ours <= kNearBest * min});
  }
  if (standard != nullptr) {
    const double theirs = standard->response_ms.median;
    summary.claims.push_back(
        {cores, "Response time clearly below the default's",
         fmt::format("{:.1f} ms beside {:.1f} ms ({:+.1f} %)", ours, theirs, 100.0 * (ours / theirs - 1.0)),
         ours <= kClearlyBelow * theirs && catan->response_ms.max < standard->response_ms.min});
  }
  if (catan->predicted_ms) {
    const double predicted = catan->predicted_ms->median;
    summary.claims.push_back({cores, "Predicted and measured response time agree within 10 %",
                              fmt::format("predicted {:.1f} ms, measured {:.1f} ms ({:+.1f} %)", predicted, ours,
                                          100.0 * (ours / predicted - 1.0)),
                              std::abs(ours - predicted) <= kPredictionOff * predicted});
  }
}

void claim_angle(Summary& summary, std::size_t cores, double speed) {
  const Row* catan = find_row(summary, cores, "catan", speed);
  const Row* standard = find_row(summary, cores, "default", speed);
  if (catan == nullptr || standard == nullptr) return;
  summary.claims.push_back(
      {cores, fmt::format("Face at {:.1f} rad/s: mean angle smaller than the default's", speed),
       fmt::format("{:.2f} deg beside {:.2f} deg", catan->angle_deg.median, standard->angle_deg.median),
       catan->angle_deg.median < standard->angle_deg.median});
}

}  // namespace

Spread spread_of(std::vector<double> values) {
  std::ranges::sort(values);
  const std::size_t middle = values.size() / 2;
  const double median = values.size() % 2 == 1 ? values[middle] : 0.5 * (values[middle - 1] + values[middle]);
  return {median, values.front(), values.back()};
}

Summary summarise(const Results& results) {
  std::map<Key, std::vector<const Measured*>> groups;
  for (const Measured& run : results.runs) groups[key_of(run)].push_back(&run);
  Summary summary;
  std::set<std::size_t> core_counts;
  for (const auto& [key, runs] : groups) {
    summary.rows.push_back(row_of(runs));
    core_counts.insert(runs.front()->trial.cpus.size());
  }
  for (const std::size_t cores : core_counts) {
    claim_response(summary, cores, results.medium_speed);
    claim_angle(summary, cores, results.medium_speed);
    claim_angle(summary, cores, results.high_speed);
  }
  return summary;
}

const Row* find_row(const Summary& summary, std::size_t cores, const std::string& scheduler, double speed) {
  const auto found = std::ranges::find_if(summary.rows, [&](const Row& row) {
    return row.cores == cores && row.scheduler == scheduler && row.speed == speed;
  });
  return found == summary.rows.end() ? nullptr : &*found;
}

double median_others(const Results& results) {
  std::vector<double> shares;
  for (const Measured& run : results.runs) shares.push_back(run.others);
  return shares.empty() ? 0.0 : spread_of(std::move(shares)).median;
}

Compute median_compute(const Results& results) {
  std::vector<const Measured*> runs;
  for (const Measured& run : results.runs) {
    if (run.trial.scheduler == "catan") runs.push_back(&run);
  }
  if (runs.empty()) {
    for (const Measured& run : results.runs) runs.push_back(&run);
  }
  if (runs.empty()) return {};
  return {spread(runs, [](const Measured& run) { return run.compute.camera; }).median,
          spread(runs, [](const Measured& run) { return run.compute.detect; }).median,
          spread(runs, [](const Measured& run) { return run.compute.plan; }).median};
}

}  // namespace ctn::demo
