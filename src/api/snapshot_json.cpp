#include "api/snapshot_json.h"

#include <nlohmann/json.hpp>

#include "record/metrics_json.h"

namespace ctn::api {
namespace {

using Json = nlohmann::ordered_json;

using record::or_null;

Json to_json(const Summary& summary) {
  return {{"count", summary.count}, {"mean", summary.mean}, {"p50", summary.p50},
          {"p95", summary.p95},     {"p99", summary.p99},   {"max", summary.max}};
}

Json to_json(const ChainSnapshot& chain) {
  return {{"path", chain.path},
          {"response_ms", to_json(chain.response_ms)},
          {"latency_ms", to_json(chain.latency_ms)},
          {"period_ms", to_json(chain.period_ms)},
          {"predicted_response_ms", or_null(chain.predicted_response_ms)}};
}

}  // namespace

std::string to_json(const Snapshot& snapshot) {
  Json json{{"policy", snapshot.policy},
            {"real_time", snapshot.real_time},
            {"warmed_up", snapshot.warmed_up},
            {"cpus", snapshot.cpus},
            {"changes", snapshot.changes},
            {"source_hz", snapshot.source_hz},
            {"plans", snapshot.plans},
            {"cost_changes", snapshot.cost_changes},
            {"planning_ms", snapshot.planning_ms},
            {"budget_overruns", snapshot.budget_overruns},
            {"starved", snapshot.starved},
            {"starved_ms", snapshot.starved_ms},
            {"relax_factor", snapshot.relax_factor},
            {"relaxed", Json::array()},
            {"assumed", Json::array()},
            {"objective", Json::array()},
            {"chains", Json::array()},
            {"nodes", Json::array()},
            {"ages", Json::array()},
            {"notices", snapshot.notices}};
  for (const RelaxedBoundSnapshot& bound : snapshot.relaxed) {
    json["relaxed"].push_back({{"bound", bound.bound}, {"asked_ms", bound.asked_ms}, {"planned_ms", bound.planned_ms}});
  }
  for (const AssumedCostSnapshot& assumed : snapshot.assumed) {
    json["assumed"].push_back({{"node", assumed.node}, {"cost_ms", assumed.cost_ms}});
  }
  for (const TermSnapshot& term : snapshot.objective) {
    json["objective"].push_back({{"term", term.term}, {"weight", term.weight}, {"max_ms", or_null(term.max_ms)}});
  }
  for (const ChainSnapshot& chain : snapshot.chains) json["chains"].push_back(to_json(chain));
  for (const NodeSnapshot& node : snapshot.nodes) {
    json["nodes"].push_back({{"name", node.name},
                             {"compute_ms", to_json(node.compute_ms)},
                             {"rate_hz", node.rate_hz},
                             {"min_rate_hz", or_null(node.min_rate_hz)}});
  }
  for (const AgeSnapshot& edge : snapshot.ages) {
    json["ages"].push_back({{"from", edge.from},
                            {"to", edge.to},
                            {"max_age_ms", edge.max_age_ms},
                            {"skips", edge.skips},
                            {"runs", edge.runs},
                            {"stale", edge.stale},
                            {"age_ms", to_json(edge.age_ms)}});
  }
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace ctn::api
