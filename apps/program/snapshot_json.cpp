#include "program/snapshot_json.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <utility>

namespace ctn::program {

using Json = nlohmann::ordered_json;

namespace {

std::optional<double> number_in(const Json& value) {
  return value.is_number() ? std::optional(value.get<double>()) : std::nullopt;
}

Json chains_of(const Snapshot& snapshot) {
  Json chains = Json::array();
  for (const ChainSnapshot& chain : snapshot.chains) {
    chains.push_back({{"path", chain.path},
                      {"response_ms", json_of(chain.response_ms)},
                      {"predicted_response_ms", or_null(chain.predicted_response_ms)},
                      {"latency_ms", json_of(chain.latency_ms)},
                      {"period_ms", json_of(chain.period_ms)}});
  }
  return chains;
}

Json nodes_of(const Snapshot& snapshot, const CostRatios& ratios) {
  Json nodes = Json::object();
  for (const NodeSnapshot& node : snapshot.nodes) {
    nodes[node.name] = {{"rate_hz", node.rate_hz}, {"compute_ms", json_of(node.compute_ms)}};
    if (ratios.contains(node.name)) nodes[node.name]["cost_ratio"] = ratios.at(node.name);
  }
  return nodes;
}

}  // namespace

Json or_null(const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); }

Json json_of(const Summary& summary) {
  if (summary.count == 0) return {{"mean", nullptr}, {"p50", nullptr}, {"p95", nullptr}, {"count", 0}};
  return {{"mean", summary.mean}, {"p50", summary.p50}, {"p95", summary.p95}, {"count", summary.count}};
}

Json json_of(const std::vector<Figure>& figures) {
  Json json = Json::object();
  for (const Figure& figure : figures) json[figure.name] = or_null(figure.value);
  return json;
}

Json json_of(const std::vector<FigureSpread>& spreads) {
  Json json = Json::object();
  for (const auto& [figure, spread] : spreads) {
    json[figure] = {{"count", spread.count}};
    if (spread.count == 0) continue;
    json[figure].update({{"mean", spread.mean},
                         {"deviation", spread.deviation},
                         {"min", spread.min},
                         {"lower_quartile", spread.lower_quartile},
                         {"median", spread.median},
                         {"upper_quartile", spread.upper_quartile},
                         {"max", spread.max}});
  }
  return json;
}

Json json_of(const ByTime& numbers) {
  Json json = Json::array();
  for (const auto& number : numbers) json.push_back(or_null(number));
  return json;
}

Json json_of(const ThreadUse& use) {
  Json json = {{"cpu_share", use.cpu_share}, {"late_ms_max", use.late_ms_max}};
  if (use.lost > 0) json["lost"] = use.lost;
  return json;
}

void add_snapshot(const Snapshot& snapshot, const CostRatios& ratios, Json& document) {
  document["chains"] = chains_of(snapshot);
  document["nodes"] = nodes_of(snapshot, ratios);
  document["plans"] = snapshot.plans;
  document["notices"] = snapshot.notices;
}

std::string name_of(const ChainSnapshot& chain) { return fmt::format("{}", fmt::join(chain.path, " -> ")); }

std::string text_of(const Json& json) { return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n"; }

std::string machine_of(bool virtual_time, int cores, const Snapshot& snapshot) {
  if (virtual_time) return fmt::format("in virtual time on {} core{}", cores, cores == 1 ? "" : "s");
  return fmt::format("real-time levels {}", snapshot.real_time ? "enforced" : "not used");
}

std::string list_of(const std::vector<Figure>& figures) {
  std::string text;
  for (const Figure& figure : figures) {
    text += fmt::format("  {:<46} {}\n", figure.name, figure.value ? fmt::format("{:.6g}", *figure.value) : "-");
  }
  return text;
}

std::string table_of_nodes(const Snapshot& snapshot, const CostRatios& ratios) {
  std::string text =
      fmt::format("  node        rate Hz   compute ms mean     p95{}\n", ratios.empty() ? "" : " x charged");
  for (const NodeSnapshot& node : snapshot.nodes) {
    text += fmt::format("  {:<10} {:>8.2f} {:>17.3f} {:>7.3f}{}\n", node.name, node.rate_hz, node.compute_ms.mean,
                        node.compute_ms.p95,
                        ratios.contains(node.name) ? fmt::format(" {:>9.2f}", ratios.at(node.name)) : "");
  }
  return text;
}

Json in_common(const Json& options) {
  Json common = options;
  common.erase("seed");
  common.erase("calibration");
  return common;
}

void add_in_common(const Json& options, Json& document) {
  const Json common = in_common(options);
  Json names = Json::array();
  for (const auto& [name, value] : common.items()) names.push_back(name);
  if (document.contains("real_time")) names.emplace_back("real_time");
  document["in_common"] = std::move(names);
}

std::optional<Json> common_options_in(const Json& document) {
  if (!document.contains("in_common") || !document["in_common"].is_array()) return std::nullopt;
  Json options = Json::object();
  for (const Json& name : document["in_common"]) {
    if (name.is_string() && document.contains(name)) options[name.get<std::string>()] = document[name];
  }
  return options;
}

bool has_figures(const Json& document) {
  return document.is_object() && document.contains("figures") && document["figures"].is_object();
}

std::vector<Figure> figures_in(const Json& document) {
  std::vector<Figure> figures;
  for (const auto& [name, value] : document["figures"].items()) figures.push_back({name, number_in(value)});
  return figures;
}

ByTime by_time_in(const Json& list) {
  ByTime numbers;
  for (const Json& value : list) numbers.push_back(number_in(value));
  return numbers;
}

}  // namespace ctn::program
