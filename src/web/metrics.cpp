#include "web/metrics.h"

#include <fmt/format.h>

#include <cmath>
#include <initializer_list>
#include <optional>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

namespace ctn::web {
namespace {

using Json = nlohmann::json;
using Labels = std::vector<std::pair<std::string_view, std::string>>;

constexpr double kMilli = 1e-3;

std::string label_text(std::string_view value) {
  std::string text;
  for (const char c : value) {
    if (c == '\\' || c == '"') text += '\\';
    if (c == '\n') {
      text += "\\n";
    } else {
      text += c;
    }
  }
  return text;
}

// One metric: its description and its samples.
class Family {
 public:
  Family(std::string name, std::string_view type, std::string_view help) : name_(std::move(name)) {
    head_ = fmt::format("# HELP {} {}\n# TYPE {} {}\n", name_, help, name_, type);
  }

  Family& add(const Labels& labels, std::optional<double> value, std::string_view suffix = {}) {
    if (!value || !std::isfinite(*value)) return *this;
    samples_ += name_;
    samples_ += suffix;
    std::string_view before = "{";
    for (const auto& [key, text] : labels) {
      samples_ += fmt::format("{}{}=\"{}\"", before, key, label_text(text));
      before = ",";
    }
    samples_ += fmt::format("{} {}\n", labels.empty() ? "" : "}", *value);
    return *this;
  }

  // A summary of values in milliseconds. It has no sum, since its count is of all values and its mean of the newest.
  void add_summary(const Labels& labels, const Json& summary) {
    if (!summary.is_object()) return;
    const auto count = number(summary, "count");
    if (!count) return;
    if (*count > 0.0) {
      using Quantile = std::pair<const char*, const char*>;
      for (const auto& [key, quantile] : {Quantile{"p50", "0.5"}, {"p95", "0.95"}, {"p99", "0.99"}, {"max", "1"}}) {
        Labels with_quantile = labels;
        with_quantile.emplace_back("quantile", quantile);
        const auto value = number(summary, key);
        if (value) add(with_quantile, *value * kMilli);
      }
    }
    add(labels, *count, "_count");
  }

  std::string text() const { return samples_.empty() ? std::string() : head_ + samples_; }

  static std::optional<double> number(const Json& object, const char* key, double unit = 1.0) {
    const auto found = object.find(key);
    if (found == object.end()) return std::nullopt;
    if (found->is_boolean()) return found->get<bool>() ? 1.0 : 0.0;
    if (!found->is_number()) return std::nullopt;
    return found->get<double>() * unit;
  }

 private:
  std::string name_;
  std::string head_;
  std::string samples_;
};

const Json& list(const Json& object, const char* key) {
  static const Json kNone = Json::array();
  const auto found = object.find(key);
  return found != object.end() && found->is_array() ? *found : kNone;
}

std::string text_of(const Json& object, const char* key) {
  if (!object.is_object()) return {};
  const auto found = object.find(key);
  return found != object.end() && found->is_string() ? found->get<std::string>() : std::string();
}

std::string path_of(const Json& chain) {
  std::string path;
  if (!chain.is_object()) return path;
  for (const Json& node : list(chain, "path")) {
    if (node.is_string()) path += (path.empty() ? "" : " -> ") + node.get<std::string>();
  }
  return path;
}

void add_mean(Family& family, const Labels& labels, const Json& summary) {
  if (summary.is_object() && Family::number(summary, "count").value_or(0.0) > 0.0) {
    family.add(labels, Family::number(summary, "mean", kMilli));
  }
}

std::string up(bool answers) {
  return Family("catan_up", "gauge", "Whether the app is scheduled.").add({}, answers ? 1.0 : 0.0).text();
}

std::string of_the_scheduler(const Json& snapshot) {
  struct Single {
    const char* key;
    const char* name;
    const char* type;
    const char* help;
    double unit;
  };
  std::string text;
  for (const Single& one : std::initializer_list<Single>{
           {"real_time", "catan_real_time", "gauge", "Whether real-time levels are in force; 0: rates only.", 1.0},
           {"warmed_up", "catan_warmed_up", "gauge", "Whether the warm-up is over, which figures leave out.", 1.0},
           {"plans", "catan_plans_total", "counter", "Plans that came into force.", 1.0},
           {"changes", "catan_changes_total", "counter", "Changes of weights, bounds and CPUs while it ran.", 1.0},
           {"cost_changes", "catan_cost_changes_total", "counter", "Lasting changes of compute times.", 1.0},
           {"planning_ms", "catan_planning_cpu_seconds_total", "counter", "CPU time that plans took.", kMilli},
           {"budget_overruns", "catan_budget_overruns_total", "counter",
            "Runs that used more CPU time than their budget.", 1.0},
           {"starved", "catan_starved_total", "counter", "How often the kernel kept a CPU from real-time threads.",
            1.0},
           {"starved_ms", "catan_starved_seconds_total", "counter",
            "How long the kernel kept CPUs from real-time threads.", kMilli},
           {"relax_factor", "catan_relax_factor", "gauge",
            "Factor by which the plan in force relaxes bounds; 1: all hold.", 1.0}}) {
    text += Family(one.name, one.type, one.help).add({}, Family::number(snapshot, one.key, one.unit)).text();
  }
  Family policy("catan_info", "gauge", "The policy that schedules the app.");
  policy.add({{"policy", text_of(snapshot, "policy")}}, 1.0);
  Family cpus("catan_cpus", "gauge", "CPUs that are planned for.");
  cpus.add({}, static_cast<double>(list(snapshot, "cpus").size()));
  Family notices("catan_notices", "gauge", "Notices that the scheduler keeps.");
  notices.add({}, static_cast<double>(list(snapshot, "notices").size()));
  return policy.text() + text + cpus.text() + notices.text();
}

std::string of_chains(const Json& snapshot) {
  Family response("catan_response_time_seconds", "summary", "Response times of a chain.");
  Family latency("catan_latency_seconds", "summary", "Latencies of a chain.");
  Family period("catan_period_seconds", "summary", "Times between two outputs of a chain.");
  Family mean("catan_response_time_mean_seconds", "gauge", "Mean of the newest response times of a chain.");
  Family expected("catan_expected_response_time_seconds", "gauge", "Mean response time that plans expected.");
  for (const Json& chain : list(snapshot, "chains")) {
    if (!chain.is_object()) continue;
    const Labels labels{{"chain", path_of(chain)}};
    response.add_summary(labels, chain.value("response_ms", Json()));
    add_mean(mean, labels, chain.value("response_ms", Json()));
    latency.add_summary(labels, chain.value("latency_ms", Json()));
    period.add_summary(labels, chain.value("period_ms", Json()));
    expected.add(labels, Family::number(chain, "predicted_response_ms", kMilli));
  }
  Family weight("catan_term_weight", "gauge", "Weight of a term of the objective.");
  Family bound("catan_term_bound_seconds", "gauge", "Bound of a response time.");
  for (const Json& term : list(snapshot, "objective")) {
    if (!term.is_object()) continue;
    const Labels labels{{"term", text_of(term, "term")}};
    weight.add(labels, Family::number(term, "weight"));
    bound.add(labels, Family::number(term, "max_ms", kMilli));
  }
  return response.text() + mean.text() + latency.text() + period.text() + expected.text() + weight.text() +
         bound.text();
}

std::string of_nodes(const Json& snapshot) {
  Family compute("catan_compute_time_seconds", "summary", "CPU times of the runs of a node.");
  Family mean("catan_compute_time_mean_seconds", "gauge", "Mean of the newest CPU times of the runs of a node.");
  Family rate("catan_node_rate_hertz", "gauge", "Runs of a node in a second, since the warm-up.");
  Family minimum("catan_node_min_rate_hertz", "gauge", "Lowest rate that the app asks of a node.");
  for (const Json& node : list(snapshot, "nodes")) {
    if (!node.is_object()) continue;
    const Labels labels{{"node", text_of(node, "name")}};
    compute.add_summary(labels, node.value("compute_ms", Json()));
    add_mean(mean, labels, node.value("compute_ms", Json()));
    rate.add(labels, Family::number(node, "rate_hz"));
    minimum.add(labels, Family::number(node, "min_rate_hz"));
  }
  Family stale("catan_stale_inputs_total", "counter", "Runs whose input was older than its edge's limit.");
  Family runs("catan_aged_runs_total", "counter", "Runs whose input had an age, on an edge with a limit.");
  for (const Json& edge : list(snapshot, "ages")) {
    if (!edge.is_object()) continue;
    const Labels labels{{"from", text_of(edge, "from")}, {"to", text_of(edge, "to")}};
    stale.add(labels, Family::number(edge, "stale"));
    runs.add(labels, Family::number(edge, "runs"));
  }
  return compute.text() + mean.text() + rate.text() + minimum.text() + stale.text() + runs.text();
}

// The metrics that are of the last seconds, from `live`.
std::string of_cores(const Json& live) {
  Family window("catan_window_seconds", "gauge", "How many seconds the figures of CPUs and subchains are of.");
  window.add({}, Family::number(live, "window_s"));
  Family busy("catan_cpu_busy_ratio", "gauge", "CPU time of all runs that ended on a CPU, over time.");
  Family use("catan_cpu_use_ratio", "gauge", "CPU time of a subchain or an unscheduled node on a CPU, over time.");
  for (const Json& core : list(live, "cores")) {
    const auto cpu = core.is_object() ? Family::number(core, "cpu") : std::nullopt;
    if (!cpu) continue;
    const std::string number = fmt::format("{}", *cpu);
    busy.add({{"cpu", number}}, Family::number(core, "busy"));
    for (const Json& one : list(core, "uses")) {
      if (one.is_object()) use.add({{"cpu", number}, {"subchain", text_of(one, "name")}}, Family::number(one, "cores"));
    }
  }
  return window.text() + busy.text() + use.text();
}

// Since `catan http` began to watch the app.
std::string of_late_responses(const Json& live) {
  Family late("catan_late_responses_total", "counter", "Late responses of a chain, by cause.");
  for (const Json& chain : list(live, "chains")) {
    const Json causes = chain.is_object() ? chain.value("late_by_in_all", Json()) : Json();
    if (!causes.is_object()) continue;
    for (const auto& [cause, count] : causes.items()) {
      late.add({{"chain", text_of(chain, "path")}, {"cause", cause}}, Family::number(causes, cause.c_str()));
    }
  }
  return late.text();
}

std::string of_subchains(const Json& live) {
  Family runs("catan_subchain_rate_hertz", "gauge", "Runs of a subchain in a second.");
  Family execution("catan_subchain_execution_p95_seconds", "gauge",
                   "95th percentile of the time from the begin of a subchain's first run to the end of its last.");
  Family promised("catan_subchain_promised_execution_seconds", "gauge", "The longest such time that is promised.");
  Family late("catan_subchain_late_ratio", "gauge", "Part of a subchain's runs that took longer than promised.");
  const double window = Family::number(live, "window_s").value_or(0.0);
  for (const Json& subchain : list(live, "subchains")) {
    if (!subchain.is_object()) continue;
    const Labels labels{{"subchain", text_of(subchain, "subchain")}};
    const auto count = Family::number(subchain, "runs");
    if (count && window > 0.0) runs.add(labels, *count / window);
    const Json times = subchain.value("execution_ms", Json());
    if (times.is_object()) execution.add(labels, Family::number(times, "p95", kMilli));
    promised.add(labels, Family::number(subchain, "promised_execution_ms", kMilli));
    const auto missed = Family::number(subchain, "late");
    if (missed && count && *count > 0.0) late.add(labels, *missed / *count);
  }
  Family response("catan_promised_response_time_seconds", "gauge", "The longest response time that is promised.");
  for (const Json& chain : list(live, "chains")) {
    if (chain.is_object())
      response.add({{"chain", text_of(chain, "path")}}, Family::number(chain, "promised_ms", kMilli));
  }
  return runs.text() + execution.text() + promised.text() + late.text() + response.text();
}

}  // namespace

std::string metrics_text(std::string_view snapshot, std::string_view live) {
  const Json measured = Json::parse(snapshot, nullptr, false);
  const Json seen = Json::parse(live, nullptr, false);
  std::string text = up(measured.is_object() || (seen.is_object() && text_of(seen, "state") == "running"));
  if (measured.is_object()) text += of_the_scheduler(measured) + of_chains(measured) + of_nodes(measured);
  if (seen.is_object()) text += of_cores(seen) + of_subchains(seen) + of_late_responses(seen);
  return text;
}

}  // namespace ctn::web
