// Every malformed file of tests/malformed through the real command: exit code 2, nothing on stdout, and on stderr
// exactly the text that stands beside it, each line with file, line and column. update.sh there rewrites the expected
// texts.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>

#include "command_test.h"

namespace ctn::test {
namespace {

const std::string kFolder = std::string(CATAN_TESTS) + "/malformed";

std::vector<std::string> files_of(const std::string& kind) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(kFolder + "/" + kind)) {
    if (entry.path().extension() == ".yaml") names.push_back(entry.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

void expect_places(const std::string& text, const std::string& file) {
  const std::regex place(R"(^[^:]+\.yaml:[1-9][0-9]*:[1-9][0-9]*: .*; .+$)");
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    EXPECT_TRUE(std::regex_match(line, place)) << line;
    EXPECT_TRUE(line.starts_with(file)) << line;
  }
}

void expect_refused(const std::string& arguments, const std::string& stem) {
  const Outcome outcome = run_catan(arguments, kFolder);
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_EQ(outcome.out, "");
  EXPECT_EQ(outcome.err, read_all(kFolder + "/" + stem + ".expected"));
  EXPECT_NE(outcome.err, "");
  expect_places(outcome.err, stem + ".yaml");
}

std::string test_name(const testing::TestParamInfo<std::string>& param) { return param.param; }

class MalformedApp : public testing::TestWithParam<std::string> {};
TEST_P(MalformedApp, IsRefused) { expect_refused("check app/" + GetParam() + ".yaml", "app/" + GetParam()); }
INSTANTIATE_TEST_SUITE_P(Corpus, MalformedApp, testing::ValuesIn(files_of("app")), test_name);

class MalformedCosts : public testing::TestWithParam<std::string> {};
TEST_P(MalformedCosts, AreRefused) {
  expect_refused("check costs.app.yaml --costs costs/" + GetParam() + ".yaml", "costs/" + GetParam());
}
INSTANTIATE_TEST_SUITE_P(Corpus, MalformedCosts, testing::ValuesIn(files_of("costs")), test_name);

// Too big to keep.
class BigFile : public testing::Test {
 protected:
  Outcome check(const std::string& text) {
    const std::string name = testing::UnitTest::GetInstance()->current_test_info()->name();
    const std::string path = testing::TempDir() + "catan_" + name + ".yaml";
    std::ofstream(path, std::ios::binary) << text;
    Outcome outcome = run_catan("check '" + path + "'", kFolder);
    std::filesystem::remove(path);
    return outcome;
  }
};

TEST_F(BigFile, OverTheLimitIsRefused) {
  const Outcome outcome = check(std::string((1U << 20U) + 1, '#'));
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_THAT(outcome.err, testing::HasSubstr("has more than 1048576 bytes"));
}

TEST_F(BigFile, OfBracketsEnds) { EXPECT_EQ(check(std::string(1U << 20U, '[')).exit_code, 2); }

TEST_F(BigFile, OfDashesEnds) {
  std::string text;
  while (text.size() + 2 < (1U << 20U)) text += "- ";
  EXPECT_EQ(check(text).exit_code, 2);
}

TEST_F(BigFile, OfNodesAndNamesEnds) {
  std::string text = "catan: 1\napp: big\nnodes:\n";
  for (int i = 0; i < 10'000; ++i) text += "  n" + std::to_string(i) + ": {}\n";
  text += "edges:\n";
  for (int i = 0; i < 10'000; ++i) text += "  - n" + std::to_string(i) + " -> m" + std::to_string(i) + "\n";
  const Outcome outcome = check(text);
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_THAT(outcome.err, testing::HasSubstr("more problems from here on"));
}

}  // namespace
}  // namespace ctn::test
