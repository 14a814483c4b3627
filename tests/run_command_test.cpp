// catan run from outside: a synthetic load on the real machine. What it measures depends on what else runs there, so
// the bounds are wide; that the draws are right is the model's to test.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <vector>

#include <nlohmann/json.hpp>

#include "command_test.h"
#include "os/linux/linux_os.h"
#include "os/testing/requires_real_time.h"
#include "test_apps.h"

namespace ctn::test {
namespace {

using nlohmann::json;
using testing::HasSubstr;

const std::string kLoad = "synthetic.yaml --synthetic synthetic.costs.yaml ";

Outcome run(const std::string& arguments) { return run_catan("run " + arguments, kTestApps); }

json node(const json& report, const std::string& name) {
  for (const json& entry : report["nodes"]) {
    if (entry["node"] == name) return entry;
  }
  return nullptr;
}

TEST(RunCommand, MeasuresASyntheticLoad) {
  const Outcome outcome = run(kLoad + "--scheduler default --seconds 2 --seed 3 --json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(outcome.err, "");
  const json report = json::parse(outcome.out);
  EXPECT_EQ(report["app"], "synthetic");
  EXPECT_EQ(report["scheduler"], "default");
  EXPECT_EQ(report["complete"], true);
  EXPECT_EQ(report["note"], "synthetic load synthetic.costs.yaml, seed 3");
  EXPECT_NEAR(report["measured_s"].get<double>(), 2.0, 0.5);

  // Above its cost are the clock and what it gives out: 7 us of CPU, 25 to 62 in a build for the address sanitizer.
  EXPECT_NEAR(node(report, "imu")["compute_ms"]["p50"].get<double>(), 0.5, 0.2);
  const json camera = node(report, "camera");
  EXPECT_NEAR(camera["rate_hz"].get<double>(), 25.0, 8.0);
  EXPECT_NEAR(camera["compute_ms"]["p50"].get<double>(), 1.0, 0.4);
  const json detect = node(report, "detect");
  EXPECT_NEAR(detect["compute_ms"]["p50"].get<double>(), 1.02, 0.3);
  // What the machine below takes from a virtual one counts as CPU time, so there is no upper bound.
  EXPECT_GE(detect["compute_ms"]["max"].get<double>(), 6.0) << "one that takes 5 ms longer";
  const json map = node(report, "map");
  EXPECT_NEAR(map["compute_ms"]["mean"].get<double>(), 3.0, 0.5);
  EXPECT_NEAR(map["outputs"].get<double>(), 5.0, 2.0) << "of " << map["runs"] << " runs";

  const json chain = report["chains"][0];
  EXPECT_EQ(chain["path"], "camera -> detect -> motor");
  EXPECT_TRUE(chain["predicted"].is_null()) << "no plan was made";
  EXPECT_GT(chain["response_ms"]["count"].get<int>(), 10);
  EXPECT_NEAR(chain["response_ms"]["mean"].get<double>(), 43.0, 15.0);
  EXPECT_NEAR(report["objective"]["measured"].get<double>(),
              chain["response_ms"]["mean"].get<double>() + 0.5 * map["period_ms"]["mean"].get<double>(), 1e-6);
}

TEST(RunCommand, ShowsPredictedBesideMeasured) {
  const Outcome outcome = run("one_node.yaml --synthetic one_node.costs.yaml --seconds 0.5");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  for (const char* part : {"one_node, scheduler catan", "Hz predicted", "objective", "loop"}) {
    EXPECT_THAT(outcome.out, HasSubstr(part));
  }
}

// 10 ms on one thread, 2 x 6 on two: whoever has two CPUs is sooner done on two.
TEST(RunCommand, NodesWorkOnAsManyThreadsAsPlanned) {
  const auto cpu_time_on = [](const std::string& cpus) {
    const Outcome outcome = run("parallel.yaml --synthetic parallel.costs.yaml --seconds 1 --json --cpus " + cpus);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return outcome.exit_code != 0 ? 0.0 : node(json::parse(outcome.out), "solve")["compute_ms"]["p50"].get<double>();
  };
  const auto os = os::make_linux_os();
  const std::vector<int> cpus = os->affinity(os->current_thread())->cpus();
  const std::string first = std::to_string(cpus[0]);
  EXPECT_NEAR(cpu_time_on(first), 10.0, 0.9);
  CATAN_REQUIRE(cpus.size() >= 2, "needs two CPUs: let it use more (taskset)");
  EXPECT_NEAR(cpu_time_on(first + "," + std::to_string(cpus[1])), 12.0, 0.9);
}

TEST(RunCommand, KeepsTheRecordThatWasAskedFor) {
  const std::string record = testing::TempDir() + "catan_run_command.catan";
  std::filesystem::remove(record);
  const std::string arguments = kLoad + "--scheduler default --seconds 0.2 --record '" + record + "'";
  const Outcome outcome = run(arguments);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const Outcome report = run_catan("report '" + record + "'", kTestApps);
  EXPECT_EQ(report.exit_code, 0) << report.err;
  EXPECT_EQ(report.out, outcome.out);
  EXPECT_EQ(run(arguments).exit_code, 2) << "a record is never overwritten";
  std::filesystem::remove(record);
}

TEST(RunCommand, ShowsWhatItHasOnASignal) {
  const std::string folder = testing::TempDir() + "catan_run_signal";
  std::filesystem::create_directory(folder);
  const std::string command = "cd '" + kTestApps + "' && TMPDIR='" + folder +
                              "' timeout --preserve-status -s INT 1.5 '" + CATAN_COMMAND "' run " + kLoad +
                              "--scheduler default --seconds 600 --json > '" + folder + ".json'";
  const int status = std::system(command.c_str());
  EXPECT_EQ(WEXITSTATUS(status), 128 + 2);
  const json report = json::parse(read_all(folder + ".json"));
  EXPECT_EQ(report["complete"], true);
  EXPECT_GT(node(report, "camera")["runs"].get<int>(), 0);
  EXPECT_TRUE(std::filesystem::is_empty(folder)) << "what nobody asked to keep is gone";
  std::filesystem::remove(folder);
  std::filesystem::remove(folder + ".json");
}

// What a start script leaves in the background, even in a session of its own, ends with the run.
TEST(RunCommand, WhatItsCommandStartedEndsWithIt) {
  const std::string numbers = ::testing::TempDir() + "catan-run-numbers";
  std::filesystem::remove(numbers);
  const Outcome outcome =
      run("synthetic.yaml --seconds 0.5 -- sh -c \"(sleep 600 & echo \\$! >> " + numbers +
          "); setsid sh -c 'trap \\\"\\\" TERM; echo \\$\\$ >> " + numbers + "; sleep 601' & sleep 602\"");
  EXPECT_NE(outcome.exit_code, 2) << outcome.err;
  std::ifstream file(numbers);
  int count = 0;
  for (int number = 0; file >> number; ++count) {
    EXPECT_FALSE(std::filesystem::exists("/proc/" + std::to_string(number))) << number;
  }
  EXPECT_EQ(count, 2) << outcome.err;
  std::filesystem::remove(numbers);
}

TEST(RunCommand, WhatProgramsPrintIsNoPartOfTheDocument) {
  const std::string command = " -- sh -c 'echo printed; exec \"" + std::string(CATAN_COMMAND) +
                              "\" node synthetic.yaml camera detect map --synthetic synthetic.costs.yaml'";
  const Outcome outcome = run("synthetic.yaml --scheduler default --seconds 0.5 --json" + command);
  EXPECT_TRUE(json::accept(outcome.out)) << outcome.out;
  EXPECT_THAT(outcome.err, HasSubstr("printed"));
}

TEST(RunCommand, MistakesExitWith2) {
  for (const std::string arguments : {"", "nowhere.yaml", "synthetic.yaml", "synthetic.yaml --synthetic nowhere.yaml",
                                      "synthetic.yaml --synthetic minimal.costs.yaml",
                                      "synthetic.yaml --synthetic synthetic.costs.yaml --seconds nan",
                                      "synthetic.yaml --synthetic synthetic.costs.yaml --seconds 0",
                                      "synthetic.yaml --synthetic synthetic.costs.yaml --scheduler best",
                                      "synthetic.yaml --synthetic synthetic.costs.yaml --cpus x",
                                      "synthetic.yaml --synthetic synthetic.costs.yaml --cpus 4095",
                                      "synthetic.yaml --synthetic synthetic.costs.yaml --seed -1",
                                      "minimal.yaml --synthetic minimal.costs.yaml --scheduler default"}) {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.exit_code, 2) << arguments << "\n" << outcome.err;
    EXPECT_EQ(outcome.out, "") << arguments;
    EXPECT_NE(outcome.err, "") << arguments;
  }
  EXPECT_THAT(run("synthetic.yaml").err, HasSubstr("--synthetic COSTS"));
}

TEST(RunCommand, ARecordThatCannotBeMadeIsAFailure) {
  EXPECT_EQ(run(kLoad + "--scheduler default --record /nowhere/run.catan").exit_code, 1);
}

}  // namespace
}  // namespace ctn::test
