#include "program/command_line.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <vector>

namespace ctn::program {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST(CommandLine, TakesListsOfCpus) {
  std::vector<int> cpus;
  EXPECT_EQ(take_cpus("", cpus), std::nullopt) << "nothing was said";
  EXPECT_THAT(cpus, IsEmpty());
  EXPECT_EQ(take_cpus("6,0-3", cpus), std::nullopt);
  EXPECT_THAT(cpus, ElementsAre(0, 1, 2, 3, 6));
}

TEST(CommandLine, SaysWhatIsNoListOfCpus) {
  for (const std::string text : {"0,,1", "1-0", "0,0", "two", "-1", ",", "4096"}) {
    std::vector<int> cpus{5};
    EXPECT_THAT(take_cpus(text, cpus).value_or(""), HasSubstr("--cpus: '" + text + "' is no list of CPUs"));
    EXPECT_THAT(cpus, ElementsAre(5)) << text;
  }
}

TEST(CommandLine, ARangeKeepsOutWhatIsNoNumber) {
  const CLI::Validator half_to_two = within(0.5, 2.0);
  for (const std::string text : {"0.5", "1", "2"}) EXPECT_EQ(half_to_two(text), "") << text;
  for (const std::string text : {"0.4", "2.1", "nan", "x", ""})
    EXPECT_THAT(half_to_two(text), HasSubstr("from 0.5 to 2"));
}

TEST(CommandLine, LeavesOverAMistakeWithTwo) {
  const Leave leave = leave_over("vr", "--size: none");
  EXPECT_EQ(leave.code, kMistake);
  EXPECT_EQ(leave.text, "vr: --size: none\n");
}

}  // namespace
}  // namespace ctn::program
