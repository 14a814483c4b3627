#include <nlohmann/json.hpp>

#include "explain.h"

namespace ctn::tool {
namespace {

using Json = nlohmann::ordered_json;  // keys in the order written: a person reads them too
using planner::Binding;

const char* binding_name(Binding binding) {
  switch (binding) {
    case Binding::kNothing:
      return "nothing";
    case Binding::kExactRate:
      return "exact_rate";
    case Binding::kRateCap:
      return "rate_cap";
    case Binding::kLongestNode:
      return "longest_node";
    case Binding::kCost:
      return "cost";
    case Binding::kOtherRate:
      return "other_rate";
    case Binding::kMinSlice:
      return "min_slice";
    case Binding::kBound:
      return "bound";
    case Binding::kOtherBound:
      return "other_bound";
    case Binding::kCore:
      return "core";
  }
  return "";
}

Json names(const std::vector<SubchainId>& ids, const graph::Graph& graph) {
  Json all = Json::array();
  for (const SubchainId id : ids) all.push_back(graph.subchain(id).name);
  return all;
}

Json reason_json(const planner::Reason& reason, const graph::Graph& graph) {
  return {{"binds", binding_name(reason.binding)},
          {"node", reason.node ? Json(graph.node(*reason.node).name) : Json(nullptr)},
          {"through", reason.through ? Json(graph.subchain(*reason.through).name) : Json(nullptr)},
          {"bounds", reason.bounds},
          {"cost_ms", reason.cost.count()},
          {"shares_with", names(reason.others, graph)},
          {"core_part", reason.core_part}};
}

Json allocation_json(const plan::Plan& plan, const graph::Graph& graph) {
  Json groups = Json::array();
  for (const planner::CoreGroup& group : planner::allocation_groups(plan)) {
    groups.push_back({{"subchains", names(group.subchains, graph)}, {"cores", group.cores}});
  }
  return groups;
}

Json plan_json(const plan::Plan& plan, const graph::Graph& graph) {
  return {
      {"objective", plan.objective}, {"relax_factor", plan.relax_factor}, {"allocation", allocation_json(plan, graph)}};
}

Json variation_json(const planner::Variation& variation, const graph::Graph& graph) {
  if (!variation.plan) return {{"refused", variation.refusal}};
  return plan_json(*variation.plan, graph);
}

Json bound_json(const planner::BoundCost& bound, const graph::Graph& graph) {
  return {{"bound", bound.key},
          {"asked_ms", bound.asked.count()},
          {"planned_ms", bound.planned.count()},
          {"binds", bound.binds},
          {"cost", bound.without.plan ? Json(bound.cost) : Json(nullptr)},
          {"without", variation_json(bound.without, graph)}};
}

Json runner_up_json(const planner::RunnerUp& runner_up, const graph::Graph& graph) {
  return {{"proven", runner_up.proven},
          {"allocations", runner_up.allocations},
          {"plan", runner_up.plan ? plan_json(*runner_up.plan, graph) : Json(nullptr)}};
}

Json times(const std::vector<Millis>& values) {
  Json all = Json::array();
  for (const Millis value : values) all.push_back(value.count());
  return all;
}

Json doubled_json(const planner::DoubledWeight& doubled, std::size_t term, const graph::Graph& graph) {
  Json document = {{"term", term}};
  if (!doubled.with.plan) {
    document["refused"] = doubled.with.refusal;
    return document;
  }
  document["terms_ms"] = times(doubled.terms);
  document["objective"] = doubled.objective;
  document["allocation_changes"] = doubled.allocation_changes;
  document["allocation"] = allocation_json(*doubled.with.plan, graph);
  return document;
}

Json explanation_json(const planner::Explanation& explanation, const graph::Graph& graph) {
  Json document = {{"subchains", Json::object()}, {"terms_ms", times(explanation.terms)}, {"bounds", Json::array()}};
  for (std::size_t i = 0; i < explanation.reasons.size(); ++i) {
    document["subchains"][graph.subchain(SubchainId(i)).name] = reason_json(explanation.reasons[i], graph);
  }
  for (const planner::BoundCost& bound : explanation.bounds) document["bounds"].push_back(bound_json(bound, graph));
  document["one_core_more"] = variation_json(explanation.one_more, graph);
  document["one_core_fewer"] = explanation.one_fewer ? variation_json(*explanation.one_fewer, graph) : Json(nullptr);
  document["runner_up"] = runner_up_json(explanation.runner_up, graph);
  document["weight_doubled"] = Json::array();
  for (std::size_t i = 0; i < explanation.doubled.size(); ++i) {
    document["weight_doubled"].push_back(doubled_json(explanation.doubled[i], i, graph));
  }
  return document;
}

}  // namespace

std::string add_explanation(std::string_view plan_json, const planner::Explanation& explanation,
                            const graph::App& app) {
  Json document = Json::parse(plan_json);
  document["explanation"] = explanation_json(explanation, app.graph);
  return document.dump(1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace ctn::tool
