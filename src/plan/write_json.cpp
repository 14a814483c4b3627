#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "plan/json.h"

namespace ctn::plan {
namespace {

using Ordered = nlohmann::ordered_json;  // keys in the order written: a person reads them too

Ordered every_json(const std::optional<int>& every) { return every ? Ordered(*every) : Ordered(nullptr); }

Ordered relaxed_json(const Plan& plan) {
  Ordered bounds = Ordered::array();
  for (const RelaxedBound& bound : plan.relaxed) {
    bounds.push_back({{"bound", bound.key}, {"asked_ms", bound.asked.count()}, {"planned_ms", bound.planned.count()}});
  }
  return {{"factor", plan.relax_factor}, {"bounds", std::move(bounds)}};
}

Ordered subchain_json(const SubchainPlan& subchain) {
  Ordered json = {{"cores", subchain.cores},
                  {"period_ms", subchain.period.count()},
                  {"execution_ms", subchain.execution.count()},
                  {"every", every_json(subchain.every)},
                  {"share", subchain.share},
                  {"slice_ms", subchain.slice.count()},
                  {"threads", subchain.threads}};
  if (subchain.wait > Millis{0}) json["wait_ms"] = subchain.wait.count();
  return json;
}

Ordered member_json(const Member& member, const graph::Graph& graph) {
  Ordered json = {{"subchain", graph.subchain(member.subchain).name},
                  {"priority", member.priority},
                  {"period_ms", member.period.count()},
                  {"phase_ms", member.phase.count()}};
  if (member.clock) json["clock"] = graph.node(*member.clock).name;
  if (member.pause) json["pause_ms"] = member.pause->count();
  if (member.after) {
    if (const SubchainId* const leader = member.after->subchain()) {
      json["after"]["subchain"] = graph.subchain(*leader).name;
    } else {
      json["after"]["node"] = graph.node(*member.after->node()).name;
    }
    json["after"]["every"] = member.after->every;
  }
  json["budget_ms"] = member.budget.count();
  return json;
}

Ordered core_json(const CorePlan& core, std::size_t number, const graph::Graph& graph) {
  if (core.form == Form::kPriorities) {
    Ordered members = Ordered::array();
    for (const Member& member : core.members) members.push_back(member_json(member, graph));
    return {{"core", number}, {"form", to_string(core.form)}, {"members", std::move(members)}};
  }
  Ordered slots = Ordered::array();
  for (const Slot& slot : core.slots) {
    slots.push_back({{"subchain", graph.subchain(slot.subchain).name},
                     {"offset_ms", slot.offset.count()},
                     {"slice_ms", slot.slice.count()},
                     {"every", every_json(slot.every)},
                     {"phase", slot.phase}});
  }
  return {{"core", number},
          {"form", to_string(core.form)},
          {"frame_ms", core.frame.count()},
          {"frame_min_ms", core.frame_min.count()},
          {"frames", core.frames == graph::FrameMode::kFixed ? "fixed" : "elastic"},
          {"slots", std::move(slots)},
          {"idle_ms", core.idle.count()}};
}

Ordered chain_json(const ChainPlan& chain, const graph::Graph& graph) {
  Ordered path = Ordered::array();
  for (const NodeId node : chain.path) path.push_back(graph.node(node).name);
  return {{"path", std::move(path)},
          {"response_time_ms", chain.response.count()},
          {"latency_ms", chain.latency.count()},
          {"period_ms", chain.period.count()},
          {"weight", chain.weight}};
}

Ordered expected_json(const Expectation& expected, const graph::Graph& graph) {
  Ordered document = {
      {"objective", expected.objective}, {"subchains", Ordered::object()}, {"chains", Ordered::array()}};
  for (std::size_t i = 0; i < expected.subchains.size(); ++i) {
    const Expectation::Timing& timing = expected.subchains[i];
    document["subchains"][graph.subchain(SubchainId{i}).name] = {{"period_ms", timing.period.count()},
                                                                 {"execution_ms", timing.execution.count()}};
  }
  for (const Expectation::Chain& chain : expected.chains) {
    document["chains"].push_back({{"response_time_ms", chain.response.count()},
                                  {"latency_ms", chain.latency.count()},
                                  {"period_ms", chain.period.count()}});
  }
  return document;
}

}  // namespace

std::string to_json(const Plan& plan, const graph::App& app) {
  Ordered document = {{"version", kJsonVersion},
                      {"app", app.name},
                      {"planner", plan.planner},
                      {"status", plan.quality == Quality::kOptimal ? "optimal" : "feasible"},
                      {"gap", plan.gap},
                      {"solve_ms", plan.solve_time.count()},
                      {"objective", plan.objective},
                      {"slack", plan.slack},
                      {"relaxed", relaxed_json(plan)},
                      {"subchains", Ordered::object()},
                      {"cores", Ordered::array()},
                      {"chains", Ordered::array()},
                      {"nodes", Ordered::array()}};
  for (std::size_t i = 0; i < plan.subchains.size(); ++i) {
    document["subchains"][app.graph.subchain(SubchainId{i}).name] = subchain_json(plan.subchains[i]);
  }
  for (std::size_t i = 0; i < plan.cores.size(); ++i) {
    document["cores"].push_back(core_json(plan.cores[i], i, app.graph));
  }
  for (const ChainPlan& chain : plan.chains) document["chains"].push_back(chain_json(chain, app.graph));
  for (const NodePlan& node : plan.nodes) {
    document["nodes"].push_back(
        {{"node", app.graph.node(node.node).name}, {"period_ms", node.period.count()}, {"weight", node.weight}});
  }
  for (const AssumedCost& assumed : plan.assumed) {
    document["assumed"].push_back({{"node", app.graph.node(assumed.node).name}, {"cost_ms", assumed.cost.count()}});
  }
  for (const RunsPerOutput& output : plan.outputs) {
    document["outputs"].push_back({{"node", app.graph.node(output.node).name}, {"runs_per_output", output.runs}});
  }
  for (const Batch& batch : plan.batches) {
    document["batches"].push_back({{"node", app.graph.node(batch.node).name}, {"items", batch.items}});
  }
  if (plan.for_typical) document["promises_for"] = promises_for(true);
  if (plan.expected) document["expected"] = expected_json(*plan.expected, app.graph);
  return document.dump(1, ' ', false, Ordered::error_handler_t::replace);
}

}  // namespace ctn::plan
