#include "sim/json.h"

#include <nlohmann/json.hpp>

#include "record/metrics_json.h"

namespace ctn::sim {
namespace {

using Json = nlohmann::ordered_json;
using record::or_null;
using record::to_json;

Json to_json(const ChainOutcome& chain) {
  return {{"path", chain.path},
          {"weight", chain.weight},
          {"bound_ms", or_null(chain.bound_ms)},
          {"over_bound", chain.over_bound},
          {"predicted_response_ms", or_null(chain.predicted_ms)},
          {"response_ms", to_json(chain.response_ms)},
          {"latency_ms", to_json(chain.latency_ms)},
          {"period_ms", to_json(chain.period_ms)}};
}

Json to_json(const NodeOutcome& node) {
  Json json{{"node", node.name},
            {"runs", node.runs},
            {"outputs", node.outputs},
            {"rate_hz", node.rate_hz},
            {"too_slow", node.too_slow},
            {"too_fast", node.too_fast},
            {"period_ms", to_json(node.period_ms)},
            {"compute_ms", to_json(node.compute_ms)}};
  if (node.wait_ms) json["wait_ms"] = to_json(*node.wait_ms);
  return json;
}

Json to_json(const CoreOutcome& core) {
  return {{"used", core.real_time + core.ordinary}, {"real_time", core.real_time}, {"ordinary", core.ordinary}};
}

template <class T>
Json all_of(const std::vector<T>& list) {
  Json array = Json::array();
  for (const T& each : list) array.push_back(to_json(each));
  return array;
}

Json to_json(const Seeded& run) {
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
  for (const Seeded& run : runs) list.push_back(to_json(run));
  const Json document{{"app", first.app},
                      {"scheduler", first.scheduler},
                      {"cores", cores},
                      {"measured_s", first.measured_s},
                      {"runs", list}};
  return document.dump(1) + "\n";
}

}  // namespace ctn::sim
