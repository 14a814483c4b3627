// The program as a script sees it: what it prints where, and how it ends.
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <string>

#include <nlohmann/json.hpp>

namespace ctn::face_tracking {
namespace {

struct Ended {
  int code = -1;
  std::string out;  // stdout; stderr goes with the test's
};

Ended run(const std::string& before, const std::string& arguments) {
  const std::string command = before + " '" FACE_TRACKING_PROGRAM "' " + arguments;
  std::FILE* pipe = popen(command.c_str(), "re");
  if (pipe == nullptr) return {};
  Ended ended;
  std::array<char, 4096> chunk{};
  while (const std::size_t length = std::fread(chunk.data(), 1, chunk.size(), pipe)) {
    ended.out.append(chunk.data(), length);
  }
  const int status = pclose(pipe);
  if (WIFEXITED(status)) ended.code = WEXITSTATUS(status);
  return ended;
}

TEST(Program, PrintsOneJsonDocumentAndNothingElse) {
  for (const char* scheduler : {"default", "catan", "rate:8Hz"}) {
    const Ended ended = run("", std::string("--json --seconds 2 --scheduler ") + scheduler);
    ASSERT_EQ(ended.code, 0) << scheduler;
    const auto json = nlohmann::json::parse(ended.out, nullptr, false);
    ASSERT_FALSE(json.is_discarded()) << ended.out;
    EXPECT_EQ(json["scheduler"], scheduler);
    EXPECT_GT(json["source_hz"].get<double>(), 0.0);
    EXPECT_EQ(json["predicted_response_time_ms"].is_number(), std::string(scheduler) == "catan");
  }
}

TEST(Program, EndsCleanlyOnASignalAndPrintsWhatItHas) {
  const Ended ended = run("timeout --preserve-status -s TERM 6", "--json --seconds 600");
  EXPECT_EQ(ended.code, 128 + 15);
  const auto json = nlohmann::json::parse(ended.out, nullptr, false);
  ASSERT_FALSE(json.is_discarded()) << ended.out;
  EXPECT_EQ(json["interrupted"], true);
}

TEST(Program, LeavesWithTwoOnAMistake) {
  for (const char* arguments : {"--scheduler fastest", "--scheduler rate:0", "--cpus 4095", "--app /nowhere/app.yaml",
                                "--speed nan", "--no-such-option"}) {
    const Ended ended = run("", arguments);
    EXPECT_EQ(ended.code, 2) << arguments;
    EXPECT_EQ(ended.out, "") << arguments;
  }
}

TEST(Program, LeavesWithOneWhereTheRecordCannotBeMade) {
  EXPECT_EQ(run("", "--seconds 1 --record /nowhere/record.db").code, 1);
}

}  // namespace
}  // namespace ctn::face_tracking
