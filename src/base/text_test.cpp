#include "base/text.h"

#include <gtest/gtest.h>

namespace ctn {
namespace {

using Names = std::vector<std::string>;

TEST(Quoted, KeepsTheTerminalSafe) {
  EXPECT_EQ(quote("GL"), "'GL'");
  EXPECT_EQ(quote("a\x1b[31m\n"), "'a\\x1b[31m\\x0a'");
  EXPECT_EQ(quote(std::string(1000, 'x')), "'" + std::string(60, 'x') + "...'");
}

TEST(Quoted, CutsBetweenCharacters) {
  const std::string umlauts = std::string(59, 'x') + "\xC3\xA4\xC3\xA4";
  EXPECT_EQ(quote(umlauts), "'" + std::string(59, 'x') + "...'");
}

TEST(AsFileName, LeadsToNoOtherFolder) {
  EXPECT_EQ(as_file_name("robot"), "robot");
  EXPECT_EQ(as_file_name("team/robot"), "team-robot");
  EXPECT_EQ(as_file_name("../evil"), "-.-evil");
}

TEST(QuotedList, NamesTheFirstOfMany) {
  EXPECT_EQ(quote_list(Names{"a"}), "'a'");
  EXPECT_EQ(quote_list(Names{"a", "b", "c"}), "'a', 'b' and 'c'");
  EXPECT_EQ(quote_list(Names(10, "a")), "'a', 'a', 'a', 'a', 'a', 'a', 'a', 'a' and 2 more");
}

TEST(Trimmed, LeavesWhatIsBetweenBlanks) {
  EXPECT_EQ(trimmed(" \ta b\r\n"), "a b");
  EXPECT_EQ(trimmed("a"), "a");
  EXPECT_EQ(trimmed(" \n"), "");
  EXPECT_EQ(trimmed(""), "");
}

TEST(Ordinal, IsAsItIsSpoken) {
  std::string all;
  for (const int number : {1, 2, 3, 4, 10, 11, 12, 13, 21, 22, 101, 111, 113, 123}) all += ordinal(number) + " ";
  EXPECT_EQ(all, "1st 2nd 3rd 4th 10th 11th 12th 13th 21st 22nd 101st 111th 113th 123rd ");
}

TEST(Nearest, FindsSlipsOfAFewLetters) {
  const Names keys{"max_rate", "min_rate", "period"};
  EXPECT_EQ(nearest("max_rat", keys), "max_rate");
  EXPECT_EQ(nearest("mxa_rate", keys), "max_rate");
  EXPECT_EQ(nearest("Period", keys), "period");
  EXPECT_EQ(nearest("colour", keys), std::nullopt);
  EXPECT_EQ(nearest("", keys), std::nullopt);
  EXPECT_EQ(nearest("x", keys), std::nullopt);
}

}  // namespace
}  // namespace ctn
