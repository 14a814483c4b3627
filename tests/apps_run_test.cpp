// The apps that come with Catan for some seconds of real time: that the whole way works, from the app's file to a
// record that can be read. That figures are right is checked in virtual time (apps_test.cpp). Here bounds only tell
// what works from what does not, on a machine that others use: a factor of five is a wrong unit, a chain that starves
// or a rate that is not kept, and no busy neighbour.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <ostream>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "command_test.h"
#include "os/linux/linux_os.h"
#include "os/testing/requires_real_time.h"
#include "record/reader.h"

namespace ctn::test {
namespace {

using nlohmann::json;

constexpr double kGenerous = 5.0;

std::vector<std::string> reasons_of_plans(const std::string& file) {
  std::vector<std::string> reasons;
  const auto record = record::Reader::open(file);
  if (!record) return reasons;
  const auto plans = record->plans();
  if (plans) {
    for (const record::PlanChange& change : *plans) reasons.push_back(change.reason);
  }
  return reasons;
}

struct AppRun {
  const char* name;
  const char* seconds;  // in which each chain responds, even on one CPU

  friend void PrintTo(const AppRun& run, std::ostream* out) { *out << run.name; }
};

class AppsRunTest : public testing::TestWithParam<AppRun> {};

TEST_P(AppsRunTest, IsScheduledMeasuredAndRecorded) {
  CATAN_REQUIRE_REAL_TIME(*os::make_linux_os());
  const std::string name = GetParam().name;
  const std::string folder = std::string(CATAN_APPS) + "/" + name;
  const std::string record = testing::TempDir() + "catan_apps_run_" + std::to_string(::getpid()) + ".catan";
  std::filesystem::remove(record);
  const Outcome ran = run_catan("run " + name + ".yaml --synthetic " + name + ".load.yaml --seconds " +
                                    GetParam().seconds + " --record '" + record + "' --json",
                                folder);
  ASSERT_EQ(ran.exit_code, 0) << ran.err;
  const Outcome reported = run_catan("report '" + record + "' --json", folder);
  ASSERT_EQ(reported.exit_code, 0) << reported.err;
  EXPECT_EQ(reported.out, ran.out);
  // Which plans followed is the search's affair. That one rests on what was measured is not: it may have come into
  // force while the run was warming up.
  EXPECT_THAT(reasons_of_plans(record), testing::Contains("measured"));
  std::filesystem::remove(record);

  const json report = json::parse(reported.out);
  EXPECT_EQ(report["app"], name);
  EXPECT_EQ(report["scheduler"], "catan");
  EXPECT_EQ(report["complete"], true);
  EXPECT_EQ(report["real_time"], true);
  EXPECT_GE(report["plans"], 1);
  ASSERT_FALSE(report["nodes"].empty());
  for (const json& node : report["nodes"]) {
    SCOPED_TRACE(node["node"]);
    EXPECT_GT(node["runs"], 0);
    EXPECT_GT(node["compute_ms"]["mean"], 0.0);
  }
  ASSERT_FALSE(report["chains"].empty());
  for (const json& chain : report["chains"]) {
    SCOPED_TRACE(chain["path"]);
    ASSERT_FALSE(chain["response_ms"].is_null()) << "served at all";
    ASSERT_FALSE(chain["predicted"].is_null());
    const double predicted = chain["predicted"]["response_ms"];
    EXPECT_GT(chain["response_ms"]["mean"], predicted / kGenerous);
    EXPECT_LT(chain["response_ms"]["mean"], predicted * kGenerous);
  }
  EXPECT_GT(report["objective"]["measured"], report["objective"]["predicted"].get<double>() / kGenerous);
  EXPECT_LT(report["objective"]["measured"], report["objective"]["predicted"].get<double>() * kGenerous);
}

std::string name_of(const testing::TestParamInfo<AppRun>& run) { return run.param.name; }

// Navigation maps and plans about once a second.
INSTANTIATE_TEST_SUITE_P(All, AppsRunTest, testing::Values(AppRun{"navigation", "10"}, AppRun{"vr", "4"}), name_of);

}  // namespace
}  // namespace ctn::test
