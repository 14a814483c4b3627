#include "rate_plan_output.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "table.h"

namespace ctn::tool {
namespace {

using Json = nlohmann::ordered_json;

std::string title(const baselines::RatePlan& plan, const graph::App& app, const plan::Plan* catans) {
  std::string text = fmt::format(
      "{} on {} core{}: periods and fixed priorities by {} ({}), slack {:.3g}%, solved in {}\n"
      "objective {:.6g}ms by its own bounds, {:.6g}ms by Catan's formulas",
      app.name, plan.utilisations.size(), plan.utilisations.size() == 1 ? "" : "s", plan.planner,
      plan.exhaustive ? "all combinations searched" : "local search, not proven best", plan.slack * 100.0,
      ms_text(plan.solve_time), plan.objective, plan.formula_objective);
  if (catans) {
    text += fmt::format("; Catan's plan: {:.6g}ms at worst, {:.6g}ms expected", catans->objective,
                        catans->expected->objective);
  }
  return text + "\n";
}

std::string subchains_text(const baselines::RatePlan& plan, const graph::App& app) {
  Table table({"subchain", "nodes", "core", "priority", "rate", "period", "response"});
  for (std::size_t i = 0; i < plan.subchains.size(); ++i) {
    const baselines::TaskPlan& task = plan.subchains[i];
    const graph::Subchain& subchain = app.graph.subchain(SubchainId(i));
    table.add({subchain.name, app.graph.path_name(subchain.nodes), fmt::format("{}", task.core),
               fmt::format("{}", task.priority), fmt::format("{:.2f}Hz", 1000.0 / task.period.count()),
               ms_text(task.period), ms_text(task.response)});
  }
  return table.text();
}

std::string cores_text(const baselines::RatePlan& plan) {
  Table table({"core", "utilisation"});
  for (std::size_t core = 0; core < plan.utilisations.size(); ++core) {
    table.add({fmt::format("{}", core), fmt::format("{:.1f}%", plan.utilisations[core] * 100.0)});
  }
  return table.text();
}

std::string terms_text(const baselines::RatePlan& plan, const graph::App& app, const plan::Plan* catans) {
  Table table({"weight", "of", "value", "Catan's", "path"});
  for (std::size_t i = 0; i < plan.chains.size(); ++i) {
    const plan::ChainPlan& chain = plan.chains[i];
    table.add({fmt::format("{:.6g}", chain.weight), "response time", ms_text(chain.response),
               catans ? ms_text(catans->chains[i].response) : "", app.graph.path_name(chain.path)});
  }
  for (std::size_t i = 0; i < plan.nodes.size(); ++i) {
    const plan::NodePlan& node = plan.nodes[i];
    table.add({fmt::format("{:.6g}", node.weight), "period", ms_text(node.period),
               catans ? ms_text(catans->nodes[i].period) : "", app.graph.node(node.node).name});
  }
  return table.text();
}

std::string precedences_text(const baselines::RatePlan& plan, const graph::App& app) {
  if (plan.precedences.empty()) return "";
  Table table({"from", "to", "waits for the last triggered by"});
  for (const baselines::Precedence& precedence : plan.precedences) {
    table.add(
        {app.graph.subchain(precedence.from).name, app.graph.subchain(precedence.to).name,
         precedence.delay.count() > 0.0 ? ms_text(precedence.delay) + " before its own trigger" : "its own trigger"});
  }
  return fmt::format("\nhyperperiod {}; who uses which run\n{}", ms_text(plan.hyperperiod), table.text());
}

std::string relaxed_text(const baselines::RatePlan& plan) {
  if (plan.relaxed.empty()) return "";
  Table table({"bound", "asked", "planned"});
  for (const plan::RelaxedBound& bound : plan.relaxed)
    table.add({bound.key, ms_text(bound.asked), ms_text(bound.planned)});
  return fmt::format("\nnot all bounds hold: missed by a factor of {:.4g}\n{}", plan.relax_factor, table.text());
}

}  // namespace

std::string rate_plan_text(const baselines::RatePlan& plan, const graph::App& app, const plan::Plan* catans) {
  return fmt::format("{}\nsubchains\n{}\ncores\n{}\nobjective\n{}{}{}", title(plan, app, catans),
                     subchains_text(plan, app), cores_text(plan), terms_text(plan, app, catans),
                     precedences_text(plan, app), relaxed_text(plan));
}

std::string rate_plan_json(const baselines::RatePlan& plan, const graph::App& app, const plan::Plan* catans) {
  Json json = {{"app", app.name},
               {"planner", plan.planner},
               {"exhaustive", plan.exhaustive},
               {"solve_ms", plan.solve_time.count()},
               {"objective", plan.objective},
               {"formula_objective", plan.formula_objective},
               {"catan_objective", nullptr},
               {"catan_expected", nullptr},
               {"slack", plan.slack},
               {"relaxed", {{"factor", plan.relax_factor}, {"bounds", Json::array()}}},
               {"subchains", Json::object()},
               {"cores", Json::array()},
               {"chains", Json::array()},
               {"nodes", Json::array()},
               {"hyperperiod_ms", plan.hyperperiod.count()},
               {"handovers", Json::array()}};
  if (catans) json["catan_objective"] = catans->objective;
  if (catans) json["catan_expected"] = catans->expected->objective;
  for (const plan::RelaxedBound& bound : plan.relaxed) {
    json["relaxed"]["bounds"].push_back(
        {{"bound", bound.key}, {"asked_ms", bound.asked.count()}, {"planned_ms", bound.planned.count()}});
  }
  for (std::size_t i = 0; i < plan.subchains.size(); ++i) {
    const baselines::TaskPlan& task = plan.subchains[i];
    json["subchains"][app.graph.subchain(SubchainId(i)).name] = {{"core", task.core},
                                                                 {"priority", task.priority},
                                                                 {"period_ms", task.period.count()},
                                                                 {"response_ms", task.response.count()}};
  }
  for (std::size_t core = 0; core < plan.utilisations.size(); ++core) {
    json["cores"].push_back({{"core", core}, {"utilisation", plan.utilisations[core]}});
  }
  for (const plan::ChainPlan& chain : plan.chains) {
    Json path = Json::array();
    for (const NodeId id : chain.path) path.push_back(app.graph.node(id).name);
    json["chains"].push_back({{"path", std::move(path)},
                              {"response_time_ms", chain.response.count()},
                              {"latency_ms", chain.latency.count()},
                              {"weight", chain.weight}});
  }
  for (const plan::NodePlan& node : plan.nodes) {
    json["nodes"].push_back(
        {{"node", app.graph.node(node.node).name}, {"period_ms", node.period.count()}, {"weight", node.weight}});
  }
  for (const baselines::Precedence& precedence : plan.precedences) {
    json["handovers"].push_back({{"from", app.graph.subchain(precedence.from).name},
                                 {"to", app.graph.subchain(precedence.to).name},
                                 {"delay_ms", precedence.delay.count()}});
  }
  return json.dump() + "\n";
}

}  // namespace ctn::tool
