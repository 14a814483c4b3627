#include "web/metrics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace ctn::web {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

constexpr const char* kSnapshot = R"({
 "policy": "catan", "real_time": true, "warmed_up": false, "cpus": [0, 2], "changes": 3, "source_hz": 10.0, "plans": 4,
 "cost_changes": 1, "planning_ms": 12.5, "budget_overruns": 2, "starved": 0, "starved_ms": 0.0, "relax_factor": 1.25,
 "objective": [{"term": "scan -> LM", "weight": 0.5, "max_ms": 60}, {"term": "period of LM", "weight": 1, "max_ms": null}],
 "chains": [{"path": ["scan", "LM"],
             "response_ms": {"count": 4, "mean": 10.0, "p50": 8.0, "p95": 20.0, "p99": 21.0, "max": 22.0},
             "latency_ms": {"count": 0, "mean": 0, "p50": 0, "p95": 0, "p99": 0, "max": 0},
             "period_ms": null, "predicted_response_ms": 11.0}],
 "nodes": [{"name": "L\"M\\\n", "compute_ms": {"count": 1, "mean": 2, "p50": 2, "p95": 2, "p99": 2, "max": 2},
            "rate_hz": 9.5, "min_rate_hz": null}],
 "ages": [{"from": "scan", "to": "LM", "max_age_ms": 5, "skips": false, "runs": 7, "stale": 1}],
 "notices": ["one", "two"]})";

constexpr const char* kLive = R"({"state": "running", "window_s": 10.0,
 "cores": [{"cpu": 3, "busy": 0.75, "uses": [{"name": "front", "cores": 0.5}]}, {"cpu": null, "busy": 1}],
 "subchains": [{"subchain": "front", "runs": 50, "late": 5, "promised_execution_ms": 30.0, "execution_ms": {"p95": 25.0}},
               {"subchain": "back", "runs": 0, "late": 0, "promised_execution_ms": null, "execution_ms": null}],
 "chains": [{"path": "scan -> LM", "promised_ms": 40.0, "late_by": {"long-run": 1},
             "late_by_in_all": {"long-run": 7, "pre-empted": 2}},
            {"path": "LM", "promised_ms": null, "late_by_in_all": {}}]})";

// What a strict reader of the format makes of it: the value of each sample by its name and labels as they are written,
// and what is wrong. A metric's HELP and TYPE come once, before its samples, which are all together.
struct Exposition {
  std::map<std::string, double> samples;
  std::map<std::string, std::string> types;
  std::vector<std::string> wrong;
};

bool is_name(std::string_view text) {
  if (text.empty() || (text.front() >= '0' && text.front() <= '9')) return false;
  return text.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_") == std::string_view::npos;
}

// Past the labels that begin at '{'; nothing: they are wrong.
std::optional<std::size_t> end_of_labels(std::string_view line, std::size_t begin) {
  std::size_t i = begin + 1;
  while (true) {
    const std::size_t equals = line.find("=\"", i);
    if (equals == std::string_view::npos || !is_name(line.substr(i, equals - i))) return std::nullopt;
    for (i = equals + 2; i < line.size() && line[i] != '"'; ++i) {
      if (line[i] == '\\' && std::string_view("\\\"n").find(line.at(++i)) == std::string_view::npos)
        return std::nullopt;
    }
    if (++i >= line.size()) return std::nullopt;
    if (line[i] == '}') return i + 1;
    if (line[i++] != ',') return std::nullopt;
  }
}

std::string family_of(std::string name, const Exposition& seen) {
  for (const std::string_view suffix : {"_count"}) {
    if (!name.ends_with(suffix)) continue;
    const std::string family = name.substr(0, name.size() - suffix.size());
    const auto type = seen.types.find(family);
    if (type != seen.types.end() && type->second == "summary") return family;
  }
  return name;
}

Exposition read_exposition(std::string_view text) {
  Exposition seen;
  std::string helped;
  std::string current;
  std::set<std::string> done;
  if (!text.ends_with('\n')) seen.wrong.emplace_back("no end of line at the end");
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    const std::string line(text.substr(0, end));
    text.remove_prefix(end + 1);
    if (line.starts_with("# HELP ")) {
      const std::size_t blank = line.find(' ', 7);
      helped = line.substr(7, blank - 7);
      if (blank == std::string::npos || !is_name(helped) || done.contains(helped)) seen.wrong.push_back(line);
    } else if (line.starts_with("# TYPE ")) {
      const std::size_t blank = line.find(' ', 7);
      current = line.substr(7, blank - 7);
      const std::string type = line.substr(blank + 1);
      const std::set<std::string> known{"gauge", "counter", "summary"};
      if (current != helped || !known.contains(type) || !done.insert(current).second) seen.wrong.push_back(line);
      if ((type == "counter") != current.ends_with("_total")) seen.wrong.push_back(line);
      seen.types[current] = type;
    } else {
      const std::size_t name_end = line.find_first_of("{ ");
      if (name_end == std::string::npos || !is_name(std::string_view(line).substr(0, name_end)) ||
          family_of(line.substr(0, name_end), seen) != current) {
        seen.wrong.push_back(line);
        continue;
      }
      const auto labels_end = line[name_end] == '{' ? end_of_labels(line, name_end) : std::optional(name_end);
      if (!labels_end || *labels_end >= line.size() || line[*labels_end] != ' ') {
        seen.wrong.push_back(line);
        continue;
      }
      char* rest = nullptr;
      const double value = std::strtod(line.c_str() + *labels_end + 1, &rest);
      if (rest == line.c_str() + *labels_end + 1 || *rest != '\0') seen.wrong.push_back(line);
      if (!seen.samples.emplace(line.substr(0, *labels_end), value).second) seen.wrong.push_back("twice: " + line);
    }
  }
  return seen;
}

TEST(MetricsTest, AreWellFormedAndInBaseUnits) {
  const Exposition seen = read_exposition(metrics_text(kSnapshot, kLive));
  EXPECT_THAT(seen.wrong, IsEmpty());
  const std::map<std::string, double> wanted{
      {"catan_up", 1},
      {"catan_info{policy=\"catan\"}", 1},
      {"catan_real_time", 1},
      {"catan_warmed_up", 0},
      {"catan_plans_total", 4},
      {"catan_changes_total", 3},
      {"catan_cost_changes_total", 1},
      {"catan_planning_cpu_seconds_total", 0.0125},
      {"catan_budget_overruns_total", 2},
      {"catan_starved_total", 0},
      {"catan_starved_seconds_total", 0},
      {"catan_relax_factor", 1.25},
      {"catan_cpus", 2},
      {"catan_notices", 2},
      {"catan_response_time_seconds{chain=\"scan -> LM\",quantile=\"0.5\"}", 0.008},
      {"catan_response_time_seconds{chain=\"scan -> LM\",quantile=\"0.95\"}", 0.02},
      {"catan_response_time_seconds{chain=\"scan -> LM\",quantile=\"0.99\"}", 0.021},
      {"catan_response_time_seconds{chain=\"scan -> LM\",quantile=\"1\"}", 0.022},
      {"catan_response_time_mean_seconds{chain=\"scan -> LM\"}", 0.01},
      {"catan_response_time_seconds_count{chain=\"scan -> LM\"}", 4},
      {"catan_latency_seconds_count{chain=\"scan -> LM\"}", 0},
      {"catan_expected_response_time_seconds{chain=\"scan -> LM\"}", 0.011},
      {"catan_term_weight{term=\"scan -> LM\"}", 0.5},
      {"catan_term_weight{term=\"period of LM\"}", 1},
      {"catan_term_bound_seconds{term=\"scan -> LM\"}", 0.06},
      {"catan_compute_time_seconds{node=\"L\\\"M\\\\\\n\",quantile=\"0.5\"}", 0.002},
      {"catan_compute_time_seconds{node=\"L\\\"M\\\\\\n\",quantile=\"0.95\"}", 0.002},
      {"catan_compute_time_seconds{node=\"L\\\"M\\\\\\n\",quantile=\"0.99\"}", 0.002},
      {"catan_compute_time_seconds{node=\"L\\\"M\\\\\\n\",quantile=\"1\"}", 0.002},
      {"catan_compute_time_mean_seconds{node=\"L\\\"M\\\\\\n\"}", 0.002},
      {"catan_compute_time_seconds_count{node=\"L\\\"M\\\\\\n\"}", 1},
      {"catan_node_rate_hertz{node=\"L\\\"M\\\\\\n\"}", 9.5},
      {"catan_stale_inputs_total{from=\"scan\",to=\"LM\"}", 1},
      {"catan_aged_runs_total{from=\"scan\",to=\"LM\"}", 7},
      {"catan_window_seconds", 10},
      {"catan_cpu_busy_ratio{cpu=\"3\"}", 0.75},
      {"catan_cpu_use_ratio{cpu=\"3\",subchain=\"front\"}", 0.5},
      {"catan_subchain_rate_hertz{subchain=\"front\"}", 5},
      {"catan_subchain_rate_hertz{subchain=\"back\"}", 0},
      {"catan_subchain_execution_p95_seconds{subchain=\"front\"}", 0.025},
      {"catan_subchain_promised_execution_seconds{subchain=\"front\"}", 0.03},
      {"catan_subchain_late_ratio{subchain=\"front\"}", 0.1},
      {"catan_promised_response_time_seconds{chain=\"scan -> LM\"}", 0.04},
      {"catan_late_responses_total{chain=\"scan -> LM\",cause=\"long-run\"}", 7},
      {"catan_late_responses_total{chain=\"scan -> LM\",cause=\"pre-empted\"}", 2}};
  std::map<std::string, double> left = seen.samples;
  for (const auto& [name, value] : wanted) {
    ASSERT_TRUE(left.contains(name)) << name;
    EXPECT_DOUBLE_EQ(left.at(name), value) << name;
    left.erase(name);
  }
  EXPECT_THAT(left, IsEmpty());
}

TEST(MetricsTest, WhatIsNoDocumentIsASchedulerThatIsNotThere) {
  for (const char* text : {"", "no", "[]", "1"}) {
    const Exposition seen = read_exposition(metrics_text(text, text));
    EXPECT_THAT(seen.wrong, IsEmpty());
    EXPECT_EQ(seen.samples, (std::map<std::string, double>{{"catan_up", 0}})) << text;
  }
}

// A session in one process has no socket at which it could be asked.
TEST(MetricsTest, WithoutASnapshotThereIsWhatIsSeen) {
  EXPECT_EQ(read_exposition(metrics_text("", kLive)).samples.at("catan_up"), 1);
  EXPECT_EQ(read_exposition(metrics_text("", kLive)).samples.at("catan_cpu_busy_ratio{cpu=\"3\"}"), 0.75);
  EXPECT_EQ(read_exposition(metrics_text("", R"({"state": "killed"})")).samples.at("catan_up"), 0);
}

TEST(MetricsTest, WhatIsMissingOrOddIsLeftOut) {
  const Exposition seen = read_exposition(metrics_text(
      R"({"plans": "many", "chains": [1, {"path": 3, "response_ms": []}], "nodes": {}, "objective": [null], "ages": 1})",
      R"({"window_s": "long", "cores": [1, {"cpu": "one"}], "subchains": [[]], "chains": [null, {"late_by_in_all": 1}]})"));
  EXPECT_THAT(seen.wrong, IsEmpty());
  EXPECT_FALSE(seen.samples.contains("catan_plans_total"));
  EXPECT_EQ(seen.samples.at("catan_up"), 1);
}

// The reader above finds what it is to find.
TEST(MetricsTest, TheStrictReaderIsStrict) {
  const std::string head = "# HELP a x\n# TYPE a gauge\n";
  EXPECT_THAT(read_exposition(head + "a 1\n").wrong, IsEmpty());
  for (const char* bad : {"a", "a ", "a x", "b 1", "a{} 1", "a{l=\"x} 1", "a{l=\"\\x\"} 1", "a{l=\"x\"}1", "a 1 x",
                          "# TYPE a gauge", "# HELP a again"}) {
    EXPECT_EQ(read_exposition(head + bad + "\n").wrong.size(), 1U) << bad;
  }
  EXPECT_THAT(read_exposition(head + "a 1\na 2\n").wrong, ElementsAre("twice: a 2"));
  EXPECT_EQ(read_exposition("# HELP a x\n# TYPE a counter\n").wrong.size(), 1U);
}

}  // namespace
}  // namespace ctn::web
