#include "whatif_output.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include <nlohmann/json.hpp>

#include "graph/change.h"
#include "report/plot.h"
#include "table.h"

namespace ctn::tool {
namespace {

using Json = nlohmann::ordered_json;
using sim::Answer;

std::string number_text(double value) { return fmt::format("{:.4g}", value); }
std::string cores_text(int cores) { return fmt::format("{} core{}", cores, cores == 1 ? "" : "s"); }
std::string number_text(std::optional<double> value) { return value ? number_text(*value) : "-"; }

// Of the response times, as an index among them; none where the objective has none.
std::optional<std::size_t> heaviest_chain(const graph::App& app) {
  std::optional<std::size_t> best;
  double weight = -1.0;
  std::size_t chain = 0;
  for (const graph::Term& term : app.objective) {
    if (term.metric != graph::Metric::kResponseTime) continue;
    if (term.weight > weight) {
      weight = term.weight;
      best = chain;
    }
    ++chain;
  }
  return best;
}

std::string chain_name(const graph::App& app, std::size_t chain) {
  for (std::size_t term = 0; term < app.objective.size(); ++term) {
    if (app.objective[term].metric == graph::Metric::kResponseTime && chain-- == 0)
      return graph::term_name(app, app.objective[term]);
  }
  return {};
}

std::string verdict(const Answer& answer) {
  if (!answer.promised && !answer.simulated) return "no plan: " + answer.why_not;
  if (!answer.promised) return answer.simulation_holds() ? "yes" : "no";
  if (answer.holds()) return "yes";
  if (answer.promise_holds()) return "promised, not simulated";
  const std::string by = fmt::format("{:.2f} x over", answer.promised->relax_factor);
  return answer.simulation_holds() ? "simulated, not promised (" + by + ")" : "no (" + by + ")";
}

// Objective and heaviest chain: promised, mean and p99 as simulated; whether bounds hold.
std::vector<std::string> figures(const Answer& answer, std::optional<std::size_t> chain, bool bounds) {
  std::vector<std::string> cells;
  cells.push_back(answer.promised ? number_text(answer.promised->objective) : "-");
  cells.push_back(answer.simulated ? number_text(answer.simulated->objective) : "-");
  if (chain) {
    cells.push_back(answer.promised ? number_text(answer.promised->responses_ms[*chain]) : "-");
    const Summary* measured = answer.simulated ? &answer.simulated->chains[*chain].response_ms : nullptr;
    const bool any = measured != nullptr && measured->count > 0;
    cells.push_back(any ? number_text(measured->mean) : "-");
    cells.push_back(any ? number_text(measured->p99) : "-");
  }
  if (bounds) cells.push_back(verdict(answer));
  return cells;
}

std::vector<std::string> header(std::vector<std::string> first, bool chain, bool bounds) {
  first.insert(first.end(), {"objective promised", "simulated"});
  if (chain) first.insert(first.end(), {"response promised", "mean", "p99"});
  if (bounds) first.emplace_back("bounds hold");
  return first;
}

template <class Label>
std::string table_of(const std::vector<Answer>& answers, const WhatIf& result, std::vector<std::string> labels,
                     const Label& label) {
  const auto chain = heaviest_chain(result.app);
  const bool bounds = result.app.has_bounds();
  Table table(header(std::move(labels), chain.has_value(), bounds));
  for (const Answer& each : answers) {
    std::vector<std::string> cells = label(each);
    for (std::string& figure : figures(each, chain, bounds)) cells.push_back(std::move(figure));
    table.add(std::move(cells));
  }
  return table.text();
}

std::string conclusions(const WhatIf& result) {
  if (!result.app.has_bounds()) {
    return "\nThe app has no bounds (max, min_rate), so nothing says which hardware is enough.\n";
  }
  std::string text = "\n";
  if (const Answer* min = sim::cheapest(result.hardware)) {
    text += fmt::format("Cheapest of these that meets all bounds: {} of speed {}.\n", cores_text(min->asked.cores),
                        number_text(min->asked.speed));
  } else {
    text += "None of these meets all bounds.\n";
  }
  for (const auto& [cores, speed] : result.limits) {
    text += fmt::format("{}: {}\n", cores_text(cores),
                        speed ? fmt::format("no plan was found that meets all bounds below speed {:.3g}", *speed)
                              : "no plan was found that meets all bounds at any speed");
  }
  for (const auto& [node, factor] : result.node_limits) {
    const std::string& name = result.app.graph.node(node).name;
    text +=
        factor ? fmt::format("{}: no plan was found that meets all bounds above {:.3g} times its cost\n", name, *factor)
               : fmt::format("{}: no plan was found that meets all bounds at any cost\n", name);
  }
  return text;
}

Json summary(const Summary& of) {
  if (of.count == 0) return nullptr;
  return {{"count", of.count}, {"mean", of.mean}, {"p50", of.p50}, {"p95", of.p95}, {"p99", of.p99}, {"max", of.max}};
}

Json json_of(const Answer& answer, const graph::App& app) {
  const sim::Hypothesis& asked = answer.asked;
  Json json{{"cores", asked.cores}, {"speed", asked.speed}};
  if (asked.node) {
    json["node"] = app.graph.node(*asked.node).name;
    json["factor"] = asked.factor;
  }
  if (asked.term) {
    json["term"] = *asked.term;
    json["weight"] = asked.weight;
  }
  json["promised"] = nullptr;
  if (answer.promised) {
    json["promised"] = {{"objective_ms", answer.promised->objective},
                        {"relax_factor", answer.promised->relax_factor},
                        {"response_ms", answer.promised->responses_ms},
                        {"holds", answer.promise_holds()}};
  }
  json["simulated"] = nullptr;
  if (answer.simulated) {
    Json chains = Json::array();
    for (const sim::ChainOutcome& chain : answer.simulated->chains) {
      chains.push_back({{"path", chain.path},
                        {"bound_ms", chain.bound_ms ? Json(*chain.bound_ms) : Json(nullptr)},
                        {"over_bound", chain.over_bound},
                        {"response_ms", summary(chain.response_ms)}});
    }
    const auto& objective = answer.simulated->objective;
    json["simulated"] = {{"objective_ms", objective ? Json(*objective) : Json(nullptr)},
                         {"chains", chains},
                         {"holds", answer.simulation_holds()}};
  }
  json["holds"] = answer.holds();
  json["why_not"] = answer.why_not.empty() ? Json(nullptr) : Json(answer.why_not);
  return json;
}

Json json_of(const std::vector<Answer>& answers, const graph::App& app) {
  Json json = Json::array();
  for (const Answer& each : answers) json.push_back(json_of(each, app));
  return json;
}

}  // namespace

std::string whatif_text(const WhatIf& result) {
  std::string text = fmt::format("{} under {}; {} s simulated of each case, seed {}. Times in ms", result.app.name,
                                 result.scheduler, number_text(result.seconds), result.seed);
  if (const auto chain = heaviest_chain(result.app)) text += "; response of " + chain_name(result.app, *chain);
  text += "\n\nHardware\n";
  text += table_of(result.hardware, result, {"cores", "speed"}, [](const Answer& each) {
    return std::vector<std::string>{std::to_string(each.asked.cores), number_text(each.asked.speed)};
  });
  if (!result.nodes.empty()) {
    text += fmt::format("\nOne node's cost, {} of speed 1\n", cores_text(result.nodes.front().asked.cores));
    text += table_of(result.nodes, result, {"node", "cost"}, [&](const Answer& each) {
      return std::vector<std::string>{result.app.graph.node(*each.asked.node).name,
                                      number_text(each.asked.factor) + " x"};
    });
  }
  if (!result.weights.empty()) {
    text += fmt::format("\nOne weight, {} of speed 1\n", cores_text(result.weights.front().asked.cores));
    text += table_of(result.weights, result, {"term", "weight"}, [&](const Answer& each) {
      return std::vector<std::string>{graph::term_name(result.app, result.app.objective[*each.asked.term]),
                                      number_text(each.asked.weight)};
    });
  }
  return text + conclusions(result);
}

std::string whatif_json(const WhatIf& result) {
  const Answer* min = result.app.has_bounds() ? sim::cheapest(result.hardware) : nullptr;
  Json limits = Json::array();
  for (const auto& [cores, speed] : result.limits) {
    limits.push_back({{"cores", cores}, {"min_speed", speed ? Json(*speed) : Json(nullptr)}});
  }
  Json node_limits = Json::array();
  for (const auto& [node, factor] : result.node_limits) {
    node_limits.push_back(
        {{"node", result.app.graph.node(node).name}, {"max_factor", factor ? Json(*factor) : Json(nullptr)}});
  }
  Json json{{"app", result.app.name},
            {"scheduler", result.scheduler},
            {"seconds", result.seconds},
            {"seed", result.seed},
            {"hardware", json_of(result.hardware, result.app)},
            {"nodes", json_of(result.nodes, result.app)},
            {"weights", json_of(result.weights, result.app)},
            {"cheapest", nullptr},
            {"limits", limits},
            {"node_limits", node_limits}};
  if (min != nullptr) json["cheapest"] = {{"cores", min->asked.cores}, {"speed", min->asked.speed}};
  return json.dump(2) + "\n";
}

Result<std::string> whatif_svg(const WhatIf& result) {
  const auto chain = heaviest_chain(result.app);
  if (!chain) return Error::caller("the objective has no response time to draw", "leave --svg out");
  std::map<int, std::pair<report::Series, report::Series>> lines;  // by cores: simulated, promised
  for (const Answer& each : result.hardware) {
    auto& [simulated, promised] = lines[each.asked.cores];
    if (each.simulated && each.simulated->chains[*chain].response_ms.count > 0) {
      const Summary& response = each.simulated->chains[*chain].response_ms;
      simulated.points.push_back({each.asked.speed, response.mean});
    }
    if (each.promised) promised.points.push_back({each.asked.speed, each.promised->responses_ms[*chain]});
  }
  report::Panel panel{.title = "Response time of " + chain_name(result.app, *chain),
                      .x = {.label = "speed of each core"},
                      .y = {.label = "ms", .log = true}};
  constexpr std::array kColours{report::Colour::kBlue,   report::Colour::kOrange, report::Colour::kGreen,
                                report::Colour::kPurple, report::Colour::kYellow, report::Colour::kSky};
  std::size_t index = 0;
  for (auto& [cores, pair] : lines) {
    const report::Colour colour = kColours[index++ % kColours.size()];
    pair.first.label = cores_text(cores) + ", mean simulated";
    pair.first.colour = colour;
    pair.second.label = index == 1 ? "dashed: promised at worst" : "";
    pair.second.colour = colour;
    pair.second.line = report::Line::kDashed;
    pair.second.marks = false;
    panel.series.push_back(std::move(pair.first));
    panel.series.push_back(std::move(pair.second));
  }
  std::size_t position = 0;
  for (const graph::Term& term : result.app.objective) {
    if (term.metric != graph::Metric::kResponseTime) continue;
    if (position++ == *chain && term.max) panel.levels.push_back({to_millis(*term.max).count(), "bound"});
  }
  return report::render_svg({.title = "What if: " + result.app.name, .panels = {panel}}, report::SvgUse::kStandalone);
}

}  // namespace ctn::tool
