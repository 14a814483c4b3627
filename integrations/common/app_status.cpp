#include "common/app_status.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <set>

namespace catan_ros {
namespace {

using nlohmann::json;
using Level = Diagnostic::Level;

std::string text_of(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", value);
  return text;
}

std::string text_of(const json& value) {
  if (value.is_string()) return value.get<std::string>();
  if (value.is_number_float()) return text_of(value.get<double>());
  return value.is_null() ? "-" : value.dump();
}

// "1 response was", "3 responses were".
std::string count_of(std::uint64_t count, const std::string& what) {
  return std::to_string(count) + " " + what + (count == 1 ? " was" : "s were");
}

std::string list_of(const std::vector<std::string>& texts) {
  std::string all;
  for (const std::string& text : texts) all += (all.empty() ? "" : ", ") + text;
  return all;
}

void add(Diagnostic& diagnostic, const std::string& key, const json& value) {
  diagnostic.values.emplace_back(key, text_of(value));
}

void add_summary(Diagnostic& diagnostic, const std::string& what, const json& summary) {
  if (!summary.is_object()) return;
  for (const char* const figure : {"mean", "p95", "max"}) add(diagnostic, what + ' ' + figure, summary.at(figure));
}

Diagnostic of_app(const json& live) {
  Diagnostic app{.name = "app", .level = Level::kOk, .message = "", .values = {}};
  const std::string state = live.at("state");
  app.message = live.at("app").get<std::string>() + " is " + state;
  if (state != "running") {
    app.level = Level::kError;
  } else if (!live.at("real_time").get<bool>()) {
    app.level = Level::kWarning;
    app.message += ", without real-time levels: rates alone are kept";
  }
  for (const char* const key : {"scheduler", "cpus", "up_s", "objective", "plans_made", "planning_ms", "starved"}) {
    add(app, key, live.at(key));
  }
  const json& notices = live.at("notices");
  if (!notices.empty()) add(app, "last notice", notices.back().at("detail"));
  return app;
}

Diagnostic of_plan(const json& live) {
  Diagnostic plan{.name = "plan", .level = Level::kOk, .message = "all bounds hold", .values = {}};
  const json& in_force = live.at("plan");
  if (in_force.is_null()) {
    plan.message = "none: rates are those of the app file";
    return plan;
  }
  std::vector<std::string> wrong;
  for (const json& bound : in_force.at("relaxed")) {
    wrong.push_back(text_of(bound.at("bound")) + " is relaxed from " + text_of(bound.at("asked_ms")) + " to " +
                    text_of(bound.at("planned_ms")) + " ms");
  }
  for (const json& node : in_force.at("assumed")) wrong.push_back(text_of(node.at("node")) + " had not run");
  if (!wrong.empty()) {
    plan.level = Level::kWarning;
    plan.message = list_of(wrong);
  }
  for (const char* const key : {"reason", "planner", "at_s", "objective", "relax_factor"}) {
    add(plan, key, in_force.at(key));
  }
  return plan;
}

Diagnostic of_chain(const json& chain) {
  Diagnostic told{.name = "chain " + text_of(chain.at("path")), .level = Level::kOk, .message = "", .values = {}};
  const bool bounded = !chain.at("bound_ms").is_null();
  const std::uint64_t late = chain.at(bounded ? "over_bound" : "over_promise");
  if (late > 0) {
    told.level = Level::kWarning;
    told.message = count_of(late, "response") + (bounded ? " over the bound" : " longer than was promised");
  } else {
    told.message = chain.at("response_ms").is_object() ? "in time" : "no response in the last seconds";
  }
  add_summary(told, "response ms", chain.at("response_ms"));
  for (const char* const key : {"newest_ms", "bound_ms", "expected_ms", "promised_ms", "weight"}) {
    add(told, key, chain.at(key));
  }
  for (const auto& [cause, times] : chain.at("late_by").items()) add(told, "late by: " + cause, times);
  return told;
}

Diagnostic of_subchain(const json& subchain) {
  Diagnostic told{.name = "subchain " + text_of(subchain.at("subchain")),
                  .level = Level::kOk,
                  .message = "within its budget",
                  .values = {}};
  const std::uint64_t overruns = subchain.at("overruns");
  if (overruns > 0) {
    told.level = Level::kWarning;
    told.message = count_of(overruns, "run") + " demoted, over the budget";
  }
  for (const char* const key : {"cores", "sharing", "priority", "expected_period_ms", "budget_ms", "late", "stole"}) {
    add(told, key, subchain.at(key));
  }
  add_summary(told, "period ms", subchain.at("period_ms"));
  add_summary(told, "CPU ms", subchain.at("used_ms"));
  return told;
}

Diagnostic of_node(const json& node) {
  Diagnostic told{.name = "node " + text_of(node.at("node")), .level = Level::kOk, .message = "runs", .values = {}};
  const json& silent = node.at("silent_ms");
  const bool absent = node.at("absent").get<bool>();
  if (absent) told.level = Level::kError;
  if (silent.is_null()) {
    told.message = "has not run";
  } else if (absent) {
    told.message = "has not run for " + text_of(silent.get<double>() / 1000.0) + " s";
  }
  for (const char* const key : {"rate_hz", "expected_hz", "runs", "cores"}) add(told, key, node.at(key));
  add_summary(told, "CPU ms", node.at("compute_ms"));
  return told;
}

// "scan -> LM -> LP" as a part of a ROS name: scan_LM_LP.
std::string ros_name(const std::string& text) {
  std::string name;
  for (const char letter : text) {
    const bool allowed = std::isalnum(static_cast<unsigned char>(letter)) != 0;
    if (allowed) {
      name += letter;
    } else if (!name.empty() && name.back() != '_') {
      name += '_';
    }
  }
  while (!name.empty() && name.back() == '_') name.pop_back();
  return name;
}

// Adds a number where several texts come to one name.
class Names {
 public:
  std::string add(const std::string& wanted) {
    std::string name = wanted;
    for (int number = 2; !taken_.insert(name).second; ++number) name = wanted + '_' + std::to_string(number);
    return name;
  }

 private:
  std::set<std::string> taken_;
};

}  // namespace

std::vector<Diagnostic> diagnostics_of(const json& live) {
  std::vector<Diagnostic> all{of_app(live), of_plan(live)};
  for (const json& chain : live.at("chains")) all.push_back(of_chain(chain));
  for (const json& subchain : live.at("subchains")) all.push_back(of_subchain(subchain));
  for (const json& node : live.at("nodes")) all.push_back(of_node(node));
  return all;
}

Diagnostic diagnostic_of_no_app(const std::string& why) {
  return {.name = "app", .level = Level::kError, .message = why, .values = {}};
}

std::vector<ResponseTime> response_times_of(const json& live) {
  Names names;
  std::vector<ResponseTime> all;
  for (const json& chain : live.at("chains")) {
    ResponseTime one{.name = names.add(ros_name(chain.at("path")))};
    const json& response = chain.at("response_ms");
    if (response.is_object()) {
      one.mean_ms = response.at("mean");
      one.p95_ms = response.at("p95");
    }
    all.push_back(std::move(one));
  }
  return all;
}

std::vector<Setting> settings_of(const json& status) {
  Names names;
  std::vector<Setting> all;
  std::size_t index = 0;
  for (const json& term : status.at("objective")) {
    const std::string name = term.at("term");
    const std::string place = std::to_string(index++);
    all.push_back({names.add(ros_name("weight " + name)), "weight of " + name, Setting::Kind::kWeight, place,
                   term.at("weight").get<double>()});
    if (name.starts_with("period of ")) continue;
    const json& max = term.at("max_ms");
    all.push_back({names.add(ros_name("max_ms " + name)), "bound of the response time " + name + ", ms; 0: none",
                   Setting::Kind::kMax, place, max.is_null() ? 0.0 : max.get<double>()});
  }
  for (const json& node : status.at("nodes")) {
    const std::string name = node.at("name");
    const json& min = node.at("min_rate_hz");
    all.push_back({names.add(ros_name("min_rate_hz " + name)), "lowest rate of node " + name + ", Hz; 0: none",
                   Setting::Kind::kMinRate, name, min.is_null() ? 0.0 : min.get<double>()});
  }
  return all;
}

ctn::Changes changes_to(const std::vector<Setting>& settings, const std::vector<std::pair<std::string, double>>& values,
                        std::vector<std::string>& unknown) {
  ctn::Changes changes;
  for (const auto& [name, value] : values) {
    const auto setting =
        std::find_if(settings.begin(), settings.end(), [&name = name](const Setting& one) { return one.name == name; });
    if (setting == settings.end()) {
      unknown.push_back(name);
      continue;
    }
    if (setting->value == value) continue;
    const std::optional<double> bound = value == 0.0 ? std::nullopt : std::optional(value);
    switch (setting->kind) {
      case Setting::Kind::kWeight:
        changes.weights.push_back({setting->of, value});
        break;
      case Setting::Kind::kMax:
        changes.maxes.push_back({setting->of, bound});
        break;
      case Setting::Kind::kMinRate:
        changes.min_rates.push_back({setting->of, bound});
        break;
    }
  }
  return changes;
}

}  // namespace catan_ros
