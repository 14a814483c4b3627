#include <optional>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "explain.h"
#include "planner/planner.h"

namespace ctn::tool {
namespace {

using Json = nlohmann::ordered_json;  // keys in the order written: a person reads them too
using planner::Binding;

const char* binding_name(Binding binding) {
  switch (binding) {
    case Binding::kExactRate:
      return "exact_rate";
    case Binding::kRateCap:
      return "rate_cap";
    case Binding::kInput:
      return "input";
    case Binding::kLongestNode:
      return "longest_node";
    case Binding::kCost:
      return "cost";
    case Binding::kLeader:
      return "leader";
    case Binding::kBound:
      return "bound";
    case Binding::kCore:
      return "core";
    case Binding::kChosen:
      return "chosen";
  }
  return "";
}

Json names(const std::vector<SubchainId>& ids, const graph::Graph& graph) {
  Json all = Json::array();
  for (const SubchainId id : ids) all.push_back(graph.subchain(id).name);
  return all;
}

// As in the plan's "after".
Json leader_json(const std::optional<plan::After>& leader, const graph::Graph& graph) {
  if (!leader) return nullptr;
  if (const SubchainId* const subchain = leader->subchain()) return graph.subchain(*subchain).name;
  return graph.node(*leader->node()).name;
}

Json reason_json(const planner::Reason& reason, const graph::Graph& graph) {
  return {{"binds", binding_name(reason.binding)},
          {"node", reason.node ? Json(graph.node(*reason.node).name) : Json(nullptr)},
          {"through", leader_json(reason.leader, graph)},
          {"bounds", reason.bounds},
          {"period_ms", reason.period.count()},
          {"cost_ms", reason.cost.count()},
          {"shares_with", names(reason.others, graph)},
          {"core_part", reason.core_part},
          {"core_used", reason.core_used}};
}

Json allocation_json(const plan::Plan& plan, const graph::App& app) {
  Json groups = Json::array();
  for (const planner::CoreGroup& group : planner::allocation_groups(plan, app)) {
    Json entry{{"subchains", names(group.subchains, app.graph)}, {"cores", group.cores}};
    if (!app.core_kinds.empty()) entry["kind"] = app.core_kinds[static_cast<std::size_t>(group.kind)].name;
    groups.push_back(std::move(entry));
  }
  return groups;
}

Json variation_json(const planner::Variation& variation, const graph::App& app) {
  if (!variation.plan) return {{"refused", variation.refusal}};
  const plan::Plan& plan = *variation.plan;
  return {{"objective", plan.expected->objective},
          {"relax_factor", plan.relax_factor},
          {"allocation", allocation_json(plan, app)}};
}

Json bound_json(const planner::BoundCost& bound, const graph::App& app) {
  return {{"bound", bound.key},
          {"asked_ms", bound.asked.count()},
          {"planned_ms", bound.planned.count()},
          {"binds", bound.binds},
          {"cost", bound.without.plan ? Json(bound.cost) : Json(nullptr)},
          {"without", variation_json(bound.without, app)}};
}

Json times(const std::vector<Millis>& values) {
  Json all = Json::array();
  for (const Millis value : values) all.push_back(value.count());
  return all;
}

Json doubled_json(const planner::DoubledWeight& doubled, std::size_t term, const graph::App& app) {
  Json document = {{"term", term}};
  if (!doubled.with.plan) {
    document["refused"] = doubled.with.refusal;
    return document;
  }
  document["terms_ms"] = times(doubled.terms);
  document["objective"] = doubled.objective;
  document["allocation_changes"] = doubled.allocation_changes;
  document["allocation"] = allocation_json(*doubled.with.plan, app);
  return document;
}

// With one core more or fewer: one plan, or one a kind of cores.
Json with_cores_json(const std::vector<std::optional<planner::Variation>>& by_kind, const graph::App& app, int cores,
                     int more) {
  const auto one = [&](std::size_t kind) {
    const auto& variation = by_kind[kind];
    return variation ? variation_json(*variation, planner::with_more_cores(app, cores, kind, more)) : Json(nullptr);
  };
  if (app.core_kinds.empty()) return one(0);
  Json all = Json::object();
  for (std::size_t kind = 0; kind < by_kind.size(); ++kind) all[app.core_kinds[kind].name] = one(kind);
  return all;
}

Json explanation_json(const planner::Explanation& explanation, const graph::App& app, int cores) {
  const graph::Graph& graph = app.graph;
  Json document = {{"objective", explanation.again.expected->objective},
                   {"noise", explanation.noise},
                   {"subchains", Json::object()},
                   {"terms_ms", times(explanation.terms)},
                   {"bounds", Json::array()}};
  for (std::size_t i = 0; i < explanation.reasons.size(); ++i) {
    document["subchains"][graph.subchain(SubchainId(i)).name] = reason_json(explanation.reasons[i], graph);
  }
  for (const planner::BoundCost& bound : explanation.bounds) document["bounds"].push_back(bound_json(bound, app));
  document["one_core_more"] =
      with_cores_json({explanation.one_more.begin(), explanation.one_more.end()}, app, cores, 1);
  document["one_core_fewer"] = with_cores_json(explanation.one_fewer, app, cores, -1);
  document["weight_doubled"] = Json::array();
  for (std::size_t i = 0; i < explanation.doubled.size(); ++i) {
    document["weight_doubled"].push_back(doubled_json(explanation.doubled[i], i, app));
  }
  return document;
}

}  // namespace

std::string add_explanation(std::string_view plan_json, const planner::Explanation& explanation,
                            const graph::App& app) {
  Json document = Json::parse(plan_json);
  const auto cores = static_cast<int>(document["cores"].size());
  document["explanation"] = explanation_json(explanation, app, cores);
  return document.dump(1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace ctn::tool
