#include "sim/json.h"

#include <nlohmann/json.hpp>

namespace ctn::sim {
namespace {

using Json = nlohmann::ordered_json;

template <class T>
Json or_null(const std::optional<T>& value) {
  return value ? Json(*value) : Json(nullptr);
}

Json json_of(const Summary& summary) {
  if (summary.count == 0) return nullptr;
  return {{"count", summary.count}, {"mean", summary.mean}, {"p50", summary.p50},
          {"p95", summary.p95},     {"p99", summary.p99},   {"max", summary.max}};
}

Json json_of(const ChainOutcome& chain) {
  return {{"path", chain.path},
          {"weight", chain.weight},
          {"bound_ms", or_null(chain.bound_ms)},
          {"over_bound", chain.over_bound},
          {"predicted_response_ms", or_null(chain.predicted_ms)},
          {"response_ms", json_of(chain.response_ms)},
          {"latency_ms", json_of(chain.latency_ms)},
          {"period_ms", json_of(chain.period_ms)}};
}

Json json_of(const NodeOutcome& node) {
  Json json{{"node", node.name},
            {"runs", node.runs},
            {"outputs", node.outputs},
            {"rate_hz", node.rate_hz},
            {"too_slow", node.too_slow},
            {"too_fast", node.too_fast},
            {"period_ms", json_of(node.period_ms)},
            {"compute_ms", json_of(node.compute_ms)}};
  if (node.wait_ms) json["wait_ms"] = json_of(*node.wait_ms);
  return json;
}

Json json_of(const AgeOutcome& edge) {
  return {{"from", edge.from},
          {"to", edge.to},
          {"max_age_ms", edge.max_age_ms},
          {"on_stale", edge.skips ? "skip" : "run"},
          {"runs", edge.runs},
          {"stale", edge.stale},
          {"age_ms", json_of(edge.age_ms)}};
}

Json json_of(const CoreOutcome& core) {
  return {{"used", core.real_time + core.ordinary}, {"real_time", core.real_time}, {"ordinary", core.ordinary}};
}

template <class T>
Json all_of(const std::vector<T>& list) {
  Json array = Json::array();
  for (const T& each : list) array.push_back(json_of(each));
  return array;
}

Json json_of(const Seeded& run) {
  const Outcome& outcome = run.outcome;
  Json json{
      {"seed", run.seed},
      {"objective", {{"measured", or_null(outcome.objective)}, {"predicted", or_null(outcome.objective_predicted)}}},
      {"relax_factor", outcome.relax_factor},
      {"chains", all_of(outcome.chains)},
      {"nodes", all_of(outcome.nodes)},
      {"ages", all_of(outcome.ages)},
      {"cores", all_of(outcome.cores)},
      {"triggers", outcome.triggers},
      {"steals", outcome.steals},
      {"hangs", outcome.hangs},
      {"dropped", outcome.dropped},
      {"throttled", outcome.throttled},
      {"plans", {{"made", outcome.plans_made}, {"adopted", outcome.plans_adopted}}},
      {"cost_changes", outcome.cost_changes}};
  if (outcome.budget_overruns > 0) json["budget_overruns"] = outcome.budget_overruns;
  if (!outcome.notices.empty()) json["notices"] = outcome.notices;
  return json;
}

}  // namespace

std::string to_json(const std::vector<Seeded>& runs, int cores) {
  const Outcome& first = runs.front().outcome;
  Json list = Json::array();
  for (const Seeded& run : runs) list.push_back(json_of(run));
  const Json document{{"app", first.app},
                      {"scheduler", first.scheduler},
                      {"cores", cores},
                      {"measured_s", first.measured_s},
                      {"runs", list}};
  return document.dump(1) + "\n";
}

}  // namespace ctn::sim
