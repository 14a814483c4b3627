// catan export from outside, on the record of a real run (a seed of the record's fuzzer) and on that of a simulation.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "command_test.h"
#include "export/trace.pb.h"
#include "test_apps.h"

namespace ctn::test {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

class ExportCommand : public testing::Test {
 protected:
  ExportCommand() {
    std::string pattern = ::testing::TempDir() + "catan-export-XXXXXX";
    folder_ = ::mkdtemp(pattern.data());
  }
  ~ExportCommand() override { std::filesystem::remove_all(folder_); }

  static Outcome run(const std::string& arguments) { return run_catan("export " + arguments, CATAN_RECORDS); }
  std::string file(const std::string& name) const { return folder_ + "/" + name; }

  std::string folder_;
};

TEST_F(ExportCommand, WritesATrace) {
  const Outcome outcome = run("face_tracking --format perfetto --output " + file("t.pftrace"));
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(outcome.out + outcome.err, "");
  const std::string trace = read_all(file("t.pftrace"));
  EXPECT_THAT(trace, HasSubstr("camera"));
  EXPECT_EQ(run("face_tracking --format perfetto").out, trace) << "stdout is the same";
}

TEST_F(ExportCommand, WritesATraceOfASimulation) {
  const std::string record = file("sim.catan");
  const Outcome simulated = run_catan(
      "sim navigation.yaml --costs navigation.costs.yaml --cores 1 --seconds 20 --record " + record, kTestApps);
  ASSERT_EQ(simulated.exit_code, 0) << simulated.err;
  ASSERT_EQ(run(record + " --format perfetto --output " + file("t")).exit_code, 0);
  exports::proto::Trace trace;
  ASSERT_TRUE(trace.ParseFromString(read_all(file("t"))));
  int begins = 0;
  int ends = 0;
  int counts = 0;
  int flow_begins = 0;
  int flow_ends = 0;
  for (const auto& packet : trace.packet()) {
    const auto& event = packet.track_event();
    begins += event.type() == exports::proto::TrackEvent::TYPE_SLICE_BEGIN ? 1 : 0;
    ends += event.type() == exports::proto::TrackEvent::TYPE_SLICE_END ? 1 : 0;
    counts += event.type() == exports::proto::TrackEvent::TYPE_COUNTER ? 1 : 0;
    flow_begins += event.flow_ids_size();
    flow_ends += event.terminating_flow_ids_size();
  }
  EXPECT_GT(begins, 1000);
  EXPECT_EQ(begins, ends);
  EXPECT_GT(counts, 1000);
  EXPECT_GT(flow_begins, 1000);
  EXPECT_EQ(flow_begins, flow_ends);
}

TEST_F(ExportCommand, WritesOneFileATable) {
  const Outcome outcome = run("face_tracking --format csv --output " + file("tables"));
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(outcome.out + outcome.err, "");
  EXPECT_THAT(read_all(file("tables/runs.csv")), StartsWith("node,run,begin_s"));
  EXPECT_THAT(read_all(file("tables/responses.csv")), HasSubstr("\ncamera -> detect -> plan -> motor,"));
  EXPECT_EQ(run("face_tracking --format csv --table runs").out, read_all(file("tables/runs.csv")));
}

TEST_F(ExportCommand, OverwritesNothing) {
  const auto content = [&](const std::string& name) { return read_all(file(name)); };
  std::filesystem::create_directory(file("tables"));
  for (const char* name : {"there", "tables/notices.csv"}) std::ofstream(file(name)) << "mine";
  for (const std::string& arguments :
       {"--format perfetto --output " + file("there"), "--format csv --table runs --output " + file("there"),
        "--format csv --output " + file("there"), "--format csv --output " + file("tables")}) {
    const Outcome outcome = run("face_tracking " + arguments);
    EXPECT_EQ(outcome.exit_code, 2) << arguments;
    EXPECT_NE(outcome.err, "") << arguments;
  }
  EXPECT_EQ(content("there"), "mine");
  EXPECT_EQ(content("tables/notices.csv"), "mine");
  EXPECT_FALSE(std::filesystem::exists(file("tables/runs.csv"))) << "all tables or none";
}

TEST_F(ExportCommand, NothingHalfMadeStays) {
  const std::string record = file("bad.catan");
  std::ofstream(record) << "no record";
  EXPECT_EQ(run(record + " --format perfetto --output " + file("t")).exit_code, 2);
  EXPECT_FALSE(std::filesystem::exists(file("t")));
  EXPECT_EQ(run("face_tracking --format perfetto --output " + file("no/folder")).exit_code, 1);
  const Outcome full = run("face_tracking --format csv --table runs >/dev/full 2>" + file("err") + " #");
  EXPECT_EQ(full.exit_code, 1);
  EXPECT_THAT(read_all(file("err")), HasSubstr("could not be written"));
}

// The system ends it as soon as a file becomes larger than that: within the first one, or in a later one.
TEST_F(ExportCommand, WhatIsInterruptedLeavesNothingUnderItsName) {
  const auto interrupted = [&](const std::string& arguments) {
    const std::string command =
        "ulimit -f 1; exec " CATAN_COMMAND " export " CATAN_RECORDS "/face_tracking " + arguments + " >/dev/null 2>&1";
    return std::system(command.c_str());
  };
  const std::string trace = "--format perfetto --output " + file("t");
  const std::string tables = "--format csv --output " + file("tables");
  EXPECT_NE(interrupted(trace), 0);
  EXPECT_NE(interrupted(tables), 0);
  EXPECT_FALSE(std::filesystem::exists(file("t")));
  for (const auto& entry : std::filesystem::directory_iterator(file("tables"))) {
    EXPECT_EQ(entry.path().extension(), ".unfinished") << entry.path();
  }
  // The next takes over what is left.
  EXPECT_EQ(run("face_tracking " + trace).exit_code, 0);
  EXPECT_EQ(read_all(file("t")), run("face_tracking --format perfetto").out);
  EXPECT_EQ(run("face_tracking " + tables).exit_code, 0);
  EXPECT_EQ(read_all(file("tables/runs.csv")), run("face_tracking --format csv --table runs").out);
  for (const std::string& folder : {folder_, file("tables")}) {
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
      EXPECT_NE(entry.path().extension(), ".unfinished") << entry.path();
    }
  }
}

TEST_F(ExportCommand, MistakesExitWith2) {
  for (const char* arguments : {"", "face_tracking", "nowhere --format perfetto", "face_tracking --format json",
                                "face_tracking --format csv", "face_tracking --format csv --table nothing",
                                "face_tracking --format perfetto --table runs", "face_tracking extra --format csv"}) {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.exit_code, 2) << arguments;
    EXPECT_EQ(outcome.out, "") << arguments;
    EXPECT_NE(outcome.err, "") << arguments;
  }
}

}  // namespace
}  // namespace ctn::test
