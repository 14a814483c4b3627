#include "view/json.h"

#include <nlohmann/json.hpp>

#include "plan/plan.h"
#include "record/metrics_json.h"

namespace ctn::view {
namespace {

using Json = nlohmann::ordered_json;
using record::or_null;
using record::to_json;

class Writer {
 public:
  explicit Writer(const Picture& picture) : picture_(picture) {}

  template <class Values>
  Json list(const Values& values) const {
    Json result = Json::array();
    for (const auto& value : values) result.push_back((*this)(value));
    return result;
  }

  Json operator()(const Distribution& distribution) const {
    if (distribution.counts.empty()) return nullptr;
    return {{"from_ms", distribution.from_ms}, {"width_ms", distribution.width_ms}, {"counts", distribution.counts}};
  }

  static Json by_cause(const std::vector<LateBy>& late) {
    Json causes = Json::object();
    for (const LateBy& by : late) causes[by.cause] = by.count;
    return causes;
  }

  Json operator()(const Chain& chain) const {
    Json worst = Json::array();
    for (const std::optional<double>& second : chain.worst_ms) worst.push_back(or_null(second));
    return {{"path", chain.path},
            {"weight", chain.weight},
            {"bound_ms", or_null(chain.bound_ms)},
            {"expected_ms", or_null(chain.expected_ms)},
            {"promised_ms", or_null(chain.promised_ms)},
            {"newest_ms", or_null(chain.newest_ms)},
            {"response_ms", to_json(chain.response_ms)},
            {"latency_ms", to_json(chain.latency_ms)},
            {"period_ms", to_json(chain.period_ms)},
            {"over_bound", chain.over_bound},
            {"over_promise", chain.over_promise},
            {"late_by", by_cause(chain.late_by)},
            {"late_by_in_all", by_cause(chain.late_by_in_all)},
            {"worst_ms", worst},
            {"distribution", (*this)(chain.distribution)}};
  }

  Json operator()(const Subchain& subchain) const {
    return {{"subchain", subchain.name},
            {"nodes", subchain.nodes},
            {"weight", subchain.weight},
            {"cores", subchain.cores},
            {"sharing", to_string(subchain.sharing)},
            {"priority", or_null(subchain.priority)},
            {"share", or_null(subchain.share)},
            {"expected_period_ms", or_null(subchain.expected_period_ms)},
            {"promised_period_ms", or_null(subchain.promised_period_ms)},
            {"promised_execution_ms", or_null(subchain.promised_execution_ms)},
            {"budget_ms", or_null(subchain.budget_ms)},
            {"runs", subchain.runs},
            {"period_ms", to_json(subchain.period_ms)},
            {"used_ms", to_json(subchain.used_ms)},
            {"execution_ms", to_json(subchain.execution_ms)},
            {"late", subchain.late},
            {"overruns", subchain.overruns},
            {"trigger_late_ms", to_json(subchain.trigger_late_ms)},
            {"stole", subchain.stole},
            {"stole_ms", subchain.stole_ms},
            {"stolen", subchain.stolen},
            {"stolen_ms", subchain.stolen_ms},
            {"silent_ms", or_null(subchain.silent_ms)},
            {"absent", subchain.absent}};
  }

  Json operator()(const CoreUse& use) const {
    return {{"name", use.name}, {"planned", use.planned}, {"cores", use.cores}, {"slots", or_null(use.slots)}};
  }

  Json operator()(const Core& core) const {
    return {{"cpu", or_null(core.cpu)},           {"core", or_null(core.core)}, {"sharing", to_string(core.sharing)},
            {"frame_ms", or_null(core.frame_ms)}, {"busy", core.busy},          {"uses", list(core.uses)}};
  }

  Json operator()(const Node& node) const {
    return {{"node", node.name},
            {"subchain", node.subchain ? Json(picture_.subchains[*node.subchain].name) : Json(nullptr)},
            {"weight", or_null(node.weight)},
            {"runs", node.runs},
            {"rate_hz", node.rate_hz},
            {"expected_hz", or_null(node.expected_hz)},
            {"period_ms", to_json(node.period_ms)},
            {"compute_ms", to_json(node.compute_ms)},
            {"wait_ms", to_json(node.wait_ms)},
            {"cores", node.cores},
            {"silent_ms", or_null(node.silent_ms)},
            {"absent", node.absent}};
  }

  Json operator()(const RelaxedBound& bound) const {
    return {{"bound", bound.bound}, {"asked_ms", bound.asked_ms}, {"planned_ms", bound.planned_ms}};
  }

  Json operator()(const AssumedCost& assumed) const { return {{"node", assumed.node}, {"cost_ms", assumed.cost_ms}}; }

  Json operator()(const PlanInForce& plan) const {
    return {{"at_s", plan.at_s},
            {"reason", plan.reason},
            {"planner", plan.planner},
            {"promises_for", plan::promises_for(plan.for_typical)},
            {"objective", plan.objective},
            {"relax_factor", plan.relax_factor},
            {"relaxed", list(plan.relaxed)},
            {"assumed", list(plan.assumed)}};
  }

  Json operator()(const Event& event) const {
    return {{"at_s", event.at_s}, {"kind", event.kind}, {"detail", event.detail}};
  }

 private:
  const Picture& picture_;
};

}  // namespace

std::string to_json(const Picture& picture) {
  const Writer write(picture);
  const Json document = {{"app", picture.app},
                         {"scheduler", picture.scheduler},
                         {"note", picture.note},
                         {"real_time", picture.real_time},
                         {"cpus", picture.cpus},
                         {"state", to_string(picture.state)},
                         {"silent_ms", picture.silent_ms},
                         {"up_s", picture.up_s},
                         {"window_s", picture.window_s},
                         {"lost", picture.lost},
                         {"plan", picture.plan ? write(*picture.plan) : Json(nullptr)},
                         {"objective", or_null(picture.objective)},
                         {"chains", write.list(picture.chains)},
                         {"subchains", write.list(picture.subchains)},
                         {"cores", write.list(picture.cores)},
                         {"nodes", write.list(picture.nodes)},
                         {"notices", write.list(picture.events)},
                         {"plans_made", picture.plans_made},
                         {"planning_ms", picture.planning_ms},
                         {"starved", picture.starved},
                         {"starved_ms", picture.starved_ms}};
  return document.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace ctn::view
