// The command line: exit codes, what goes to stdout and what to stderr, and that what it prints is what was meant.
#include "command_test.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include <nlohmann/json.hpp>

#include "test_apps.h"

namespace ctn::test {
namespace {

using nlohmann::json;
using testing::HasSubstr;
using testing::StartsWith;

Outcome catan(const std::string& arguments) { return run_catan(arguments, kTestApps); }

TEST(Command, HelpAndVersionAreSuccess) {
  for (const std::string command :
       {"",           "bench",    "check", "ctl",    "doctor", "export",   "http",     "illixr",
        "illixr run", "node",     "plan",  "report", "ros",    "ros bind", "ros node", "ros run",
        "ros2",       "ros2 run", "run",   "serve",  "sim",    "top",      "watch",    "whatif"}) {
    const Outcome outcome = catan(command + " --help");
    EXPECT_EQ(outcome.exit_code, 0) << command;
    EXPECT_EQ(outcome.err, "") << command;
    EXPECT_THAT(outcome.out, HasSubstr("Examples:")) << command;
    EXPECT_THAT(outcome.out, HasSubstr("Exit code: 0 ")) << command;
  }
  const Outcome version = catan("--version");
  EXPECT_EQ(version.exit_code, 0);
  EXPECT_THAT(version.out, StartsWith("catan "));
}

TEST(Command, MistakesOnTheCommandLineExitWith2) {
  for (const std::string arguments : {"",
                                      "chek minimal.yaml",
                                      "check",
                                      "check --colour minimal.yaml",
                                      "check minimal.yaml extra",
                                      "check minimal.yaml --json --dot",
                                      "plan minimal.yaml --cores 0",
                                      "plan minimal.yaml --cores two",
                                      "plan minimal.yaml --slack 6",
                                      "plan minimal.yaml --slack 100%",
                                      "plan minimal.yaml --planner best",
                                      "plan minimal.yaml --format yaml",
                                      "plan minimal.yaml --cpus 0",
                                      "plan minimal.yaml --template minimal.yaml",
                                      "check nowhere.yaml",
                                      "check .",
                                      "ros",
                                      "ros node one two",
                                      "ros2",
                                      "ros2 run minimal.yaml",
                                      "ros2 run minimal.yaml -- true",
                                      "ros run minimal.yaml",
                                      "ros run minimal.yaml -- true",
                                      "ros run nowhere.yaml -- true",
                                      "ros run minimal.yaml --bind nowhere.yaml -- true",
                                      "check minimal.yaml --costs nowhere.yaml",
                                      "plan minimal.yaml --costs ."}) {
    const Outcome outcome = catan(arguments);
    EXPECT_EQ(outcome.exit_code, 2) << arguments;
    EXPECT_EQ(outcome.out, "") << arguments;
    EXPECT_NE(outcome.err, "") << arguments;
    EXPECT_THAT(outcome.err, testing::Not(HasSubstr("\x1b"))) << "colours are for terminals";
  }
  EXPECT_EQ(catan("chek minimal.yaml").err, "catan: there is no command 'chek'; did you mean 'check'?\n");
}

TEST(Command, OutputThatCannotBeWrittenIsAFailure) {
  EXPECT_EQ(catan("check minimal.yaml > /dev/full #").exit_code, 1);
}

// Guards: writing on a log that is full ended the process, and with it a server that schedules a robot.
TEST(Command, ALogThatIsFullChangesNothing) {
  EXPECT_EQ(catan("check nowhere.yaml 2> /dev/full #").exit_code, 2);
  EXPECT_EQ(catan("check minimal.yaml > /dev/full 2> /dev/full #").exit_code, 1);
}

class ValidApp : public testing::TestWithParam<std::string> {};

TEST_P(ValidApp, IsShownInEveryForm) {
  const std::string files = GetParam() + ".yaml --costs " + GetParam() + ".costs.yaml";
  for (const std::string form : {"", " --json", " --dot"}) {
    const Outcome outcome = catan("check " + files + form);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_EQ(outcome.err, "");
    EXPECT_NE(outcome.out, "");
  }
  EXPECT_EQ(json::parse(catan("check " + files + " --json").out)["app"], GetParam());
  EXPECT_EQ(catan("check " + files).out, read_all(kTestApps + "/" + GetParam() + ".expected"));
}

INSTANTIATE_TEST_SUITE_P(All, ValidApp, testing::Values("navigation", "vr", "minimal", "one_node", "aged"),
                         [](const auto& param) { return param.param; });

TEST(Check, TellsProgramsWhatItUnderstood) {
  const json app = json::parse(catan("check navigation.yaml --json").out);
  EXPECT_EQ(app["nodes"]["GL"]["input"], "queue");
  EXPECT_EQ(app["nodes"]["odometry"]["period_ms"], 20.0);
  EXPECT_EQ(app["nodes"]["base"]["kind"], "external");
  EXPECT_EQ(app["subchains"]["local"]["nodes"], json({"scan", "LM", "LP"}));
  EXPECT_EQ(app["objective"][0]["max_ms"], 60.0);
  EXPECT_EQ(app["objective"][2]["elements"].size(), 3U);
  EXPECT_EQ(app["edges"].size(), 11U);
  EXPECT_EQ(app["order"], json({"local", "GL", "NC", "GP", "GM"}));
  EXPECT_EQ(app["age_limits"], json::array());
}

TEST(Check, ShowsAgeLimits) {
  const json app = json::parse(catan("check aged.yaml --json").out);
  EXPECT_EQ(app["age_limits"],
            json::parse(R"([{"from": "scan", "to": "steer", "max_age_ms": 10000.0, "on_stale": "skip"},
                            {"from": "map", "to": "steer", "max_age_ms": 400.0, "on_stale": "run"}])"));
  const std::string dot = catan("check aged.yaml --dot").out;
  EXPECT_THAT(dot, HasSubstr(R"("scan" -> "steer" [label="max 10s, else skip"];)"));
  EXPECT_THAT(dot, HasSubstr(R"("map" -> "steer" [label="max 400ms"];)"));
  EXPECT_THAT(dot, HasSubstr(R"("scan" -> "map";)"));
}

TEST(Plan, OfOneSubchain) {
  const Outcome outcome =
      catan("plan minimal.yaml --costs minimal.costs.yaml --cores 3 --slack 0% --effort 0.01 --json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(outcome.err, "");
  const json plan = json::parse(outcome.out);
  EXPECT_EQ(plan["app"], "minimal");
  EXPECT_FALSE(plan["subchains"]["track"]["cores"].empty());
  EXPECT_GT(plan["chains"][0]["response_time_ms"], 0.0);
  EXPECT_EQ(catan("plan minimal.yaml --costs minimal.costs.yaml --cores 3 --effort 0.01").exit_code, 0);
}

TEST(Plan, WithoutCostsSaysSo) {
  const Outcome outcome = catan("plan one_node.yaml --effort 0.05 --json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("no cost file: every node is taken to cost 5ms"));
  EXPECT_NEAR(json::parse(outcome.out)["expected"]["subchains"]["loop"]["period_ms"].get<double>(), 5.0 / 0.94, 0.1);
}

const std::string kPlanNavigation = "plan navigation.yaml --costs navigation.costs.yaml --cores 2 --explain --effort ";

std::string written(const std::string& name, const std::string& text) {
  const std::string path = testing::TempDir() + name;
  std::ofstream(path) << text;
  return path;
}

TEST(Plan, ByOtherMethods) {
  const std::string files = "plan navigation.yaml --cores 2 --costs navigation.costs.yaml --effort 0.02 --planner ";
  for (const std::string planner : {"davare", "verucchi"}) {
    const Outcome text = catan(files + planner);
    EXPECT_EQ(text.exit_code, 0) << text.err;
    EXPECT_THAT(text.out, HasSubstr("fixed priorities by " + planner));
    EXPECT_THAT(text.out, HasSubstr("Catan's plan: "));
    const json plan = json::parse(catan(files + planner + " --json").out);
    EXPECT_EQ(plan.at("planner"), planner);
    EXPECT_EQ(plan.at("chains").size(), 4U);
    EXPECT_GT(plan.at("catan_objective"), plan.at("catan_expected"));
    EXPECT_GT(plan.at("catan_expected"), 0.0);
    EXPECT_GE(plan.at("subchains").at("GP").at("period_ms"), 1000.0 - 1e-6);
  }
  const Outcome paper = catan(files + "paper");
  EXPECT_THAT(paper.out, StartsWith("navigation on 2 cores: optimal, objective "));
  for (const char* planner : {"davare", "paper"}) {
    const Outcome explained = catan(files + planner + " --explain");
    EXPECT_EQ(explained.exit_code, 2);
    EXPECT_THAT(explained.err, HasSubstr("--explain"));
  }
}

TEST(Plan, AsTheAppFileSays) {
  const auto planned = [](const std::string& scheduler) {
    const std::string app = written("asked.yaml", R"(catan: 1
app: pair
nodes: { fast: {}, slow: {} }
objective: [ { response_time: [fast], weight: 1.0 }, { response_time: [slow], weight: 0.05 } ]
scheduler: { )" + scheduler + " }\n");
    const std::string costs = written("asked.costs.yaml", "fast: 4ms\nslow: 40ms\n");
    const Outcome outcome = catan("plan " + app + " --costs " + costs + " --effort 0.02 --json");
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return json::parse(outcome.out);
  };
  EXPECT_EQ(planned("planner: auto")["planner"], "auto");
  EXPECT_EQ(planned("planner: paper")["planner"], "paper");
  EXPECT_EQ(planned("planner: paper")["cores"][0]["frames"], "fixed");
  EXPECT_EQ(planned("schedule: frames")["cores"][0]["frames"], "elastic");
  EXPECT_EQ(planned("schedule: frames")["cores"][0]["slots"].size(), 2U);
  EXPECT_EQ(planned("schedule: frames, frames: fixed")["cores"][0]["frames"], "fixed");
  EXPECT_EQ(planned("schedule: priorities")["cores"][0]["members"].size(), 2U);
}

TEST(Plan, ExplainsItself) {
  const Outcome outcome = catan(kPlanNavigation + "0.05");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(outcome.err, "");
  EXPECT_THAT(outcome.out, StartsWith("navigation on 2 cores: objective ")) << "the plan comes first";
  for (const char* fragment : {
           "ms expected, ",
           "why these periods",
           "objective[0].max  60.000ms",
           "one core more ",
           "one core fewer ",
           "period of GL (weight 0.5 -> 1)",
           "Differences of less than ",
       }) {
    EXPECT_THAT(outcome.out, HasSubstr(fragment));
  }
}

TEST(Plan, ExplainsWhoPaysForABound) {
  const std::string app = written("bound.yaml", R"(catan: 1
app: pair
nodes: { fast: { max_rate: 200Hz }, slow: {}, base: { external: true } }
edges: [fast -> base, slow -> base]
objective:
  - { response_time: [fast, base], weight: 1.0 }
  - { response_time: [slow, base], weight: 0.0005, max: 300ms }
)");
  const std::string costs = written("bound.costs.yaml", "fast: 4ms\nslow: 40ms\n");
  const Outcome outcome = catan("plan " + app + " --costs " + costs + " --explain --effort 0.05");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("objective[1].max keeps it this fast"));
  EXPECT_THAT(outcome.out, HasSubstr("fast has one; slow has one")) << "with one core more";
  const Outcome capped = catan("plan " + app + " --costs " + costs + " --cores 2 --explain --effort 0.05 --json");
  ASSERT_EQ(capped.exit_code, 0) << capped.err;
  const json why = json::parse(capped.out)["explanation"]["subchains"];
  EXPECT_EQ(why["fast"]["binds"], "rate_cap");
  EXPECT_EQ(why["fast"]["node"], "fast");
  EXPECT_EQ(why["slow"]["binds"], "cost");
}

TEST(Plan, ExplainsItselfToPrograms) {
  const Outcome outcome = catan(kPlanNavigation + "0.16 --json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const json plan = json::parse(outcome.out);
  const json& why = plan["explanation"];
  EXPECT_EQ(why["subchains"].size(), 5U);
  EXPECT_EQ(why["bounds"][0]["bound"], "objective[0].max");
  EXPECT_EQ(why["bounds"][0]["binds"], false);
  EXPECT_LE(why["objective"], plan["expected"]["objective"]);
  EXPECT_GE(why["noise"], 0.01);
  // GL may not run more often, so a third core gains next to nothing; a second one does. What the search compares has
  // tails in it, which may cost as much again as noise.
  const double by_noise = why["objective"].get<double>() * (1.0 + 2.0 * why["noise"].get<double>());
  EXPECT_LT(why["one_core_more"]["objective"], by_noise);
  EXPECT_GT(why["one_core_fewer"]["objective"], by_noise);
  ASSERT_EQ(why["weight_doubled"].size(), 5U);
  for (std::size_t term = 0; term < 5; ++term) {
    EXPECT_LE(why["weight_doubled"][term]["terms_ms"][term].get<double>(), why["terms_ms"][term].get<double>() + 1e-6)
        << "whose weight it is: " << term;
  }
  EXPECT_EQ(json::parse(catan("plan navigation.yaml --costs navigation.costs.yaml --effort 0.01 --json").out)
                .contains("explanation"),
            false);
}

}  // namespace
}  // namespace ctn::test
