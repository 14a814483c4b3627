// catan doctor on the machine that runs the tests, whatever that is.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "command_test.h"

namespace ctn::test {
namespace {

using nlohmann::json;
using testing::HasSubstr;

Outcome doctor(const std::string& arguments) { return run_catan("doctor " + arguments, CATAN_TESTS); }

TEST(Doctor, SaysWhatItFound) {
  const Outcome outcome = doctor("");
  EXPECT_EQ(outcome.err, "");
  for (const char* check : {"permission", "slack", "quota", "clock", "timer", "steal"}) {
    EXPECT_THAT(outcome.out, HasSubstr(std::string("\n  ") + check + " "));
  }
  const bool hinders = outcome.out.find("\nSomething hinders") != std::string::npos;
  EXPECT_NE(hinders, outcome.out.find("\nNothing hinders") != std::string::npos);
  EXPECT_EQ(outcome.exit_code, hinders ? 1 : 0);
  EXPECT_THAT(outcome.out, testing::Not(HasSubstr("\x1b"))) << "colours are for terminals";
}

TEST(Doctor, TellsPrograms) {
  const Outcome outcome = doctor("--json");
  EXPECT_EQ(outcome.err, "");
  const json checkup = json::parse(outcome.out);
  EXPECT_EQ(outcome.exit_code, checkup["hinders"].get<bool>() ? 1 : 0);
  EXPECT_EQ(checkup["hinders"], checkup["verdict"] == "problem");
  EXPECT_EQ(checkup["checks"].size(), 18U);
  for (const json& check : checkup["checks"]) {
    for (const char* key : {"check", "verdict", "found", "meaning", "mend"}) {
      EXPECT_TRUE(check[key].is_string()) << check;
    }
    EXPECT_TRUE(check["lines"].is_array());
    EXPECT_EQ(check["mend"] == "", check["verdict"] == "ok") << check;
  }
  EXPECT_EQ(checkup["checks"][0]["verdict"] == "ok", checkup["real_time"]["permitted"].get<bool>());
  ASSERT_EQ(checkup["wake_ups"].size(), 2 * checkup["cpus"].size());
  EXPECT_LE(checkup["wake_ups"][0]["p50_us"], checkup["wake_ups"][0]["p99_us"]);
  EXPECT_FALSE(checkup["host"]["kernel"].get<std::string>().empty());
}

TEST(Doctor, LooksAtTheCpusThatAreAsked) {
  const json all = json::parse(doctor("--json").out);
  const int cpu = all["cpus"].back().get<int>();
  const json one = json::parse(doctor("--json --cpus " + std::to_string(cpu)).out);
  EXPECT_EQ(one["cpus"], json({cpu}));
}

TEST(Doctor, RefusesMistakes) {
  for (const std::string arguments : {"--cpus x", "--cpus 0-", "--cpus 130000", "--cpu 0", "extra"}) {
    const Outcome outcome = doctor(arguments);
    EXPECT_EQ(outcome.exit_code, 2) << arguments;
    EXPECT_EQ(outcome.out, "");
    EXPECT_NE(outcome.err, "");
  }
  EXPECT_THAT(doctor("--help").out, HasSubstr("Examples:"));
}

}  // namespace
}  // namespace ctn::test
