#include "options.h"

#include <gtest/gtest.h>

#include <initializer_list>
#include <vector>

#include "program/testing/parsed.h"

namespace ctn::face_tracking {
namespace {

using program::Leave;

std::variant<Options, Leave> parse(std::initializer_list<const char*> words) {
  return program::testing::parsed("face_tracking", words, parse_options);
}
int code_of(std::initializer_list<const char*> words) { return program::testing::code_of(parse(words)); }

TEST(Options, AreWhatWasGiven) {
  const auto parsed = parse({"--scheduler", "rate:12Hz", "--cpus", "0,2-4", "--seconds", "3.5", "--speed", "1.5",
                             "--seed", "9", "--record", "r.db", "--slowdown", "2", "--json", "--app", "a.yaml"});
  ASSERT_TRUE(std::holds_alternative<Options>(parsed));
  const auto& options = std::get<Options>(parsed);
  EXPECT_EQ(options.scheduler, "rate:12Hz");
  EXPECT_EQ(options.cpus, (std::vector<int>{0, 2, 3, 4}));
  EXPECT_EQ(options.seconds, 3.5);
  EXPECT_EQ(options.speed, 1.5);
  EXPECT_EQ(options.seed, 9U);
  EXPECT_EQ(options.record, "r.db");
  EXPECT_EQ(options.slowdown, 2.0);
  EXPECT_EQ(options.app_file, "a.yaml");
  EXPECT_TRUE(options.json);
}

TEST(Options, OfVirtualTime) {
  const auto parsed = parse({"--virtual", "--costs", "c.yaml", "--cores", "3"});
  ASSERT_TRUE(std::holds_alternative<Options>(parsed));
  const auto& options = std::get<Options>(parsed);
  EXPECT_TRUE(options.virtual_time);
  EXPECT_EQ(options.costs, "c.yaml");
  EXPECT_EQ(options.cores, 3);
  EXPECT_FALSE(std::get<Options>(parse({})).virtual_time);
  EXPECT_EQ(code_of({"--cores", "3"}), 2) << "only in virtual time";
  EXPECT_EQ(code_of({"--virtual", "--cores", "0"}), 2);
}

TEST(Options, MistakesLeaveWithTwo) {
  EXPECT_EQ(code_of({"--cpus", "0,,1"}), 2);
  EXPECT_EQ(code_of({"--seconds", "0"}), 2);
  EXPECT_EQ(code_of({"--seconds", "nan"}), 2);
  EXPECT_EQ(code_of({"--speed", "-1"}), 2);
  EXPECT_EQ(code_of({"--slowdown", "0.5"}), 2);
  EXPECT_EQ(code_of({"--seed", "x"}), 2);
  EXPECT_EQ(code_of({"--frobnicate"}), 2);
  EXPECT_EQ(code_of({"stray"}), 2);
}

TEST(Options, HelpHasExamples) { EXPECT_TRUE(program::testing::shows_examples(parse({"--help"}))); }

}  // namespace
}  // namespace ctn::face_tracking
