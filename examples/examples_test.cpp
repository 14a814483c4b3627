// Each example does what its page says: it is scheduled, and its runs are reported.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <string>

#include <nlohmann/json.hpp>

#include "command_test.h"

namespace ctn::test {
namespace {

using nlohmann::json;
using testing::HasSubstr;

std::string source(const std::string& example) { return CATAN_EXAMPLES "/" + example; }
std::string built(const std::string& example) { return CATAN_EXAMPLES_BUILT "/" + example; }

json node(const json& report, const std::string& name) {
  for (const json& entry : report["nodes"]) {
    if (entry["node"] == name) return entry;
  }
  return nullptr;
}

// `catan run` of an example's app with a command, for a second and a half.
json run(const std::string& example, const std::string& command) {
  const Outcome outcome = run_catan("run app.yaml --seconds 1.5 --json -- " + command, source(example));
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  const json report = json::parse(outcome.out, nullptr, false);
  EXPECT_FALSE(report.is_discarded()) << outcome.out << outcome.err;
  return report;
}

// That it ran at about this rate; a machine that is busy with other things does not reach it.
void expect_scheduled(const json& report, const std::string& name, double min_hz, double max_hz) {
  const json entry = node(report, name);
  ASSERT_FALSE(entry.is_null()) << report;
  ASSERT_FALSE(entry["rate_hz"].is_null()) << report;
  EXPECT_GT(entry["rate_hz"].get<double>(), min_hz) << entry;
  EXPECT_LT(entry["rate_hz"].get<double>(), max_hz) << entry;
}

TEST(Examples, NodesInProcessesOfTheirOwn) {
  const json report = run("node", "./start.sh " + built("node"));
  expect_scheduled(report, "camera", 10, 33);
  expect_scheduled(report, "detect", 10, 33);
  EXPECT_GT(node(report, "detect")["compute_ms"]["p50"], 1.5);
  EXPECT_GT(report["chains"][0]["response_ms"]["count"], 5) << report;
}

TEST(Examples, NodeInC) {
  const json report = run("c", built("c") + "/node");
  expect_scheduled(report, "detect", 10, 55);
  EXPECT_GT(node(report, "detect")["compute_ms"]["p50"], 1.5);
  EXPECT_LT(node(report, "detect")["outputs"], node(report, "detect")["runs"]);
}

TEST(Examples, NodeInPython) {
  if (std::system("command -v python3 > /dev/null") != 0) {
    const char* const must = std::getenv("CATAN_REQUIRE_REALTIME");  // as src/os/testing/requires_real_time.h has it
    if (must != nullptr && std::string(must) == "1") FAIL() << "there is no python3: install it";
    GTEST_SKIP() << "there is no python3: install it";
  }
  if (std::string(CATAN_SANITIZE) != "") GTEST_SKIP() << "python3 cannot load a library that has a sanitizer in it";
  ::setenv("CATAN_LIBRARY", CATAN_LIBRARY, 1);
  const json report = run("python", "python3 node.py");
  expect_scheduled(report, "detect", 10, 55);
  EXPECT_LT(node(report, "detect")["outputs"], node(report, "detect")["runs"]);
}

TEST(Examples, SessionInOneProcess) {
  const std::string record = testing::TempDir() + "catan_example_session.catan";
  std::filesystem::remove(record);
  const std::string command = built("session") + "/session " + source("session") + "/app.yaml " + record;
  ASSERT_EQ(std::system(("timeout 60 " + command + " > " + record + ".out").c_str()), 0);
  EXPECT_THAT(read_all(record + ".out"), HasSubstr("drive: "));
  const Outcome outcome = run_catan("report --json " + record, "/");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const json report = json::parse(outcome.out);
  expect_scheduled(report, "scan", 20, 55);
  EXPECT_LT(node(report, "drive")["outputs"], node(report, "drive")["runs"]);
  std::filesystem::remove(record);
  std::filesystem::remove(record + ".out");
}

}  // namespace
}  // namespace ctn::test
