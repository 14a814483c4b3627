// catan whatif, and catan sim over many apps and beside records, from outside.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include <nlohmann/json.hpp>

#include "command_test.h"
#include "test_apps.h"

namespace ctn::test {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using ::testing::HasSubstr;

const std::string kAsk = "whatif synthetic.yaml --costs synthetic.costs.yaml --seconds 1 ";

TEST(WhatIfCommand, ShowsEachHardwareAndWhatFollows) {
  const Outcome outcome = run_catan(kAsk + "--cores 1-2 --speeds 0.5,1", kTestApps);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("Hardware"));
  EXPECT_THAT(outcome.out, HasSubstr("objective promised"));
  EXPECT_EQ(outcome.err, "");
}

TEST(WhatIfCommand, PrintsOneDocumentTheSameWithAnyNumberOfThreads) {
  const std::string ask = kAsk + "--cores 1,2 --speeds 1,2 --weight 0=1,4 --json ";
  const Outcome outcome = run_catan(ask + "--threads 1", kTestApps);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const Json document = Json::parse(outcome.out);
  ASSERT_EQ(document["hardware"].size(), 4U);
  EXPECT_EQ(document["hardware"][0]["cores"], 1);
  EXPECT_GT(document["hardware"][0]["promised"]["objective_ms"], document["hardware"][1]["promised"]["objective_ms"]);
  ASSERT_EQ(document["weights"].size(), 2U);
  EXPECT_EQ(outcome.out, run_catan(ask + "--threads 4", kTestApps).out);
}

TEST(WhatIfCommand, Draws) {
  const fs::path drawing = fs::path(testing::TempDir()) / ("catan_whatif_" + std::to_string(::getpid()) + ".svg");
  const Outcome outcome = run_catan(kAsk + "--cores 1 --speeds 1,2 --svg " + drawing.string(), kTestApps);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  std::ostringstream text;
  text << std::ifstream(drawing).rdbuf();
  EXPECT_THAT(text.str(), HasSubstr("<svg"));
  fs::remove(drawing);
}

TEST(WhatIfCommand, MistakesExitWith2) {
  for (const std::string arguments :
       {"whatif", "whatif synthetic.yaml", "whatif synthetic.yaml --costs nowhere.yaml", "--cores 0", "--cores none",
        "--speeds 0", "--speeds fast", "--speeds nan", "--seconds nan", "--node nobody=1", "--node =1", "--weight 99=1",
        "--weight 0=-1", "--weight 0=", "--scheduler best"}) {
    const bool whole = arguments.starts_with("whatif");
    const Outcome outcome = run_catan(whole ? arguments : kAsk + arguments, kTestApps);
    EXPECT_EQ(outcome.exit_code, 2) << arguments << "\n" << outcome.err;
    EXPECT_EQ(outcome.out, "") << arguments;
    EXPECT_NE(outcome.err, "") << arguments;
  }
}

class SweepCommand : public ::testing::Test {
 protected:
  SweepCommand() {
    fs::remove_all(folder);
    fs::create_directories(folder);
    for (const char* name : {"one", "three", "two"}) {
      fs::copy(kTestApps + "/synthetic.yaml", folder / (std::string(name) + ".yaml"));
      fs::copy(kTestApps + "/synthetic.costs.yaml", folder / (std::string(name) + ".costs.yaml"));
    }
  }
  ~SweepCommand() override { fs::remove_all(folder); }

  Outcome sweep(const std::string& out, const std::string& more = {}) const {
    return run_catan("sim --sweep . --seconds 2 --out " + out + " " + more, folder.string());
  }
  std::string text(const std::string& file) const {
    std::ostringstream all;
    all << std::ifstream(folder / file).rdbuf();
    return all.str();
  }

  const fs::path folder = fs::path(testing::TempDir()) / ("catan_sweep_" + std::to_string(::getpid()));
};

TEST_F(SweepCommand, GoesOnWhereItWasStopped) {
  ASSERT_EQ(sweep("all.jsonl", "--threads 1").exit_code, 0);
  const std::string all = text("all.jsonl");
  EXPECT_EQ(std::count(all.begin(), all.end(), '\n'), 4);
  for (const std::size_t cut : {std::size_t{5}, all.find('\n') + 1, all.size() / 2, all.size() - 1}) {
    std::ofstream(folder / "cut.jsonl", std::ios::binary) << all.substr(0, cut);
    ASSERT_EQ(sweep("cut.jsonl", "--threads 3").exit_code, 0) << cut;
    EXPECT_EQ(text("cut.jsonl"), all) << cut;
  }
}

TEST_F(SweepCommand, AnAppThatCannotBeSimulatedStopsNoOther) {
  std::ofstream(folder / "one.yaml") << "catan: 1\n";
  const Outcome outcome = sweep("out.jsonl");
  EXPECT_EQ(outcome.exit_code, 1);
  std::istringstream lines(text("out.jsonl"));
  std::string line;
  std::getline(lines, line);
  std::getline(lines, line);
  EXPECT_TRUE(Json::parse(line).contains("error"));
  std::getline(lines, line);
  EXPECT_TRUE(Json::parse(line).contains("result"));
}

TEST_F(SweepCommand, AnotherSweepsFileIsLeftAlone) {
  ASSERT_EQ(sweep("out.jsonl").exit_code, 0);
  const std::string before = text("out.jsonl");
  EXPECT_EQ(sweep("out.jsonl", "--seed 2").exit_code, 2);
  EXPECT_EQ(text("out.jsonl"), before);
  EXPECT_EQ(run_catan("sim --sweep .", folder.string()).exit_code, 2) << "nowhere to write";
  EXPECT_EQ(run_catan("sim --sweep nowhere --out x.jsonl", folder.string()).exit_code, 2);
}

TEST(ValidateCommand, ComparesWithARecord) {
  const Outcome outcome = run_catan("sim --validate face_tracking --json", CATAN_RECORDS);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const Json document = Json::parse(outcome.out);
  EXPECT_EQ(document["app"], "face_tracking");
  EXPECT_TRUE(document["chains"][0]["response_ms"]["p50"].contains("error"));
  EXPECT_EQ(run_catan("sim --validate nowhere", CATAN_RECORDS).exit_code, 2);
}

// Guards: where there was nothing to compare, the error was 0.
TEST(ValidateCommand, SaysThatNothingWasMeasured) {
  std::string folder = ::testing::TempDir() + "catan-validate-XXXXXX";
  ASSERT_NE(::mkdtemp(folder.data()), nullptr);
  std::ofstream(folder + "/app.yaml") << "catan: 1\napp: slow\nnodes: { a: {} }\n"
                                         "objective: [ { response_time: [a], weight: 1 } ]\n";
  std::ofstream(folder + "/costs.yaml") << "a: 500ms\n";
  const Outcome simulated =
      run_catan("sim app.yaml --costs costs.yaml --cores 1 --seconds 0.1 --record run.catan", folder);
  ASSERT_EQ(simulated.exit_code, 0) << simulated.err;
  const Outcome text = run_catan("sim --validate run.catan", folder);
  EXPECT_EQ(text.exit_code, 0) << text.err;
  EXPECT_NE(text.out.find("response times: none, as none was measured"), std::string::npos) << text.out;
  const Outcome document = run_catan("sim --validate run.catan --json", folder);
  EXPECT_TRUE(Json::parse(document.out)["worst_response_error"].is_null()) << document.out;
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace ctn::test
