#include "report/json.h"

#include <nlohmann/json.hpp>

#include "plan/plan.h"
#include "record/metrics_json.h"

namespace ctn::report {
namespace {

using Json = nlohmann::ordered_json;

using record::or_null;
using record::to_json;

Json json(const why::Analysis& late) {
  Json causes = Json::object();
  for (const auto& [cause, count] : why::causes_by_count(late)) causes[why::to_string(cause)] = count;
  return {{"over_ms", to_millis(late.late_over).count()},
          {"over", late.bound ? "bound" : "p99"},
          {"count", late.late},
          {"of", late.responses},
          {"causes", causes},
          {"explained", late.explained}};
}

Json json(const ChainMetrics& chain) {
  Json predicted = nullptr;
  if (chain.predicted) {
    predicted = {{"response_ms", chain.predicted->response_ms},
                 {"latency_ms", chain.predicted->latency_ms},
                 {"period_ms", chain.predicted->period_ms},
                 {"promised_response_ms", chain.predicted->promised_response_ms}};
  }
  return {{"path", chain.path},
          {"weight", chain.weight},
          {"bound_ms", or_null(chain.bound_ms)},
          {"predicted", predicted},
          {"response_ms", to_json(chain.response_ms)},
          {"latency_ms", to_json(chain.latency_ms)},
          {"period_ms", to_json(chain.period_ms)},
          {"late", chain.late && chain.late->responses > 0 ? json(*chain.late) : Json(nullptr)}};
}

Json json(const NodeMetrics& node) {
  Json figures{{"node", node.name},
               {"runs", node.runs},
               {"outputs", node.outputs},
               {"rate_hz", node.rate_hz},
               {"predicted_rate_hz", or_null(node.predicted_rate_hz)},
               {"weight", or_null(node.weight)},
               {"period_ms", to_json(node.period_ms)},
               {"compute_ms", to_json(node.compute_ms)},
               {"wall_ms", to_json(node.wall_ms)},
               {"cores", node.cores}};
  if (node.wait_ms) figures["wait_ms"] = to_json(*node.wait_ms);
  return figures;
}

Json json(const TriggerMetrics& trigger) {
  return {{"subchain", trigger.subchain}, {"late_ms", to_json(trigger.late_ms)}};
}

Json json(const record::Notice& notice, TimePoint started) {
  return {{"at_ms", to_millis(notice.at - started).count()}, {"kind", notice.kind}, {"detail", notice.detail}};
}

template <class Values>
Json list(const Values& values) {
  Json result = Json::array();
  for (const auto& value : values) result.push_back(json(value));
  return result;
}

}  // namespace

std::string to_json(const RunFigures& metrics) {
  const record::Header& header = metrics.header;
  Json notices = Json::array();
  for (const record::Notice& notice : metrics.notices) notices.push_back(json(notice, header.started));
  Json ages = Json::array();
  for (const AgeSnapshot& edge : metrics.ages) ages.push_back(to_json(edge));
  Json changes = Json::array();
  for (const AppChangeMetrics& change : metrics.changes) {
    changes.push_back({{"at_ms", 1000.0 * change.at_s}, {"what", change.what}});
  }
  const Json document = {
      {"app", metrics.app},
      {"scheduler", header.scheduler},
      {"note", header.note},
      {"started_utc", header.host.utc},
      {"complete", metrics.ending.closed},
      {"real_time", header.real_time},
      {"slack", or_null(header.slack)},
      {"cpus", header.cpus.cpus()},
      {"host",
       {{"kernel", header.host.kernel},
        {"cpu_model", header.host.cpu_model},
        {"governor", header.host.governor},
        {"clock_source", header.host.clock_source},
        {"cpu_count", header.host.cpu_count},
        {"stolen_ms", to_millis(metrics.ending.stolen).count()}}},
      {"warm_up_s", in_seconds(header.warm_up)},
      {"warm_up_included", metrics.whole},
      {"measured_s", metrics.measured_s},
      {"cores_used", metrics.cores_used},
      {"plans", metrics.plans},
      {"relax_factor", metrics.relax_factor},
      {"promises_for", plan::promises_for(metrics.for_typical)},
      {"objective",
       {{"measured", or_null(metrics.objective.measured)}, {"predicted", or_null(metrics.objective.predicted)}}},
      {"chains", list(metrics.chains)},
      {"nodes", list(metrics.nodes)},
      {"ages", ages},
      {"triggers", list(metrics.triggers)},
      {"changes", changes},
      {"notices", notices}};
  return document.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace ctn::report
