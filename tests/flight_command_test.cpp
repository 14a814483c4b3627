// The last seconds, from outside: saved when asked for, when a response was late, when a server is killed. Times are
// generous: it is the real machine.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "command_test.h"
#include "record/reader.h"
#include "served_app.h"

namespace ctn::test {
namespace {

using testing::HasSubstr;
using testing::SizeIs;

class FlightCommandTest : public ServedNodesTest {
 protected:
  // Of the test's folder.
  std::vector<std::string> records(const std::string& prefix) const {
    std::vector<std::string> found;
    for (const auto& entry : std::filesystem::directory_iterator(folder_)) {
      const std::string name = entry.path().filename().string();
      if (name.starts_with(prefix) && name.ends_with(".catan")) found.push_back(entry.path().string());
    }
    return found;
  }
  // How many runs are in it; 0 where it is no record yet.
  static std::uint64_t runs_in(const std::string& file) {
    const auto record = record::Reader::open(file);
    std::uint64_t count = 0;
    if (!record) return 0;
    EXPECT_TRUE(record->each_run([&](const record::Run&) { ++count; }).ok());
    return count;
  }
  static std::string why_saved(const std::string& file) {
    const auto record = record::Reader::open(file);
    if (!record) return record.error().message();
    const auto notices = record->notices();
    for (const record::Notice& notice : *notices) {
      if (notice.kind == "flight-recorder") return notice.detail;
    }
    return "not said";
  }

  // Dumps until so many runs are in it: they are collected 20 times a second.
  bool dumps(const std::string& target, const std::string& file, std::uint64_t runs) const {
    return eventually([&] {
      std::filesystem::remove(file);
      const Outcome dumped = run_catan("ctl " + target + " dump " + file, folder_);
      EXPECT_EQ(dumped.exit_code, 0) << dumped.err;
      return dumped.exit_code != 0 || runs_in(file) >= runs;
    });
  }

  // Whether another process than the server has what it keeps.
  bool is_watched() const {
    for (const auto& process : std::filesystem::directory_iterator("/proc")) {
      const std::string number = process.path().filename().string();
      if (number == std::to_string(static_cast<int>(server_->process()))) continue;
      std::error_code gone;
      for (std::filesystem::directory_iterator entry(process.path() / "fd", gone), end; !gone && entry != end;
           entry.increment(gone)) {
        std::error_code unreadable;
        const std::string target = std::filesystem::read_symlink(entry->path(), unreadable).string();
        if (target.starts_with("/memfd:catan-flight:served")) return true;
      }
    }
    return false;
  }
};

TEST_F(FlightCommandTest, TheLastSecondsAreSavedWhenAskedFor) {
  serve_all();
  const std::string file = path("dumped.catan");
  EXPECT_TRUE(dumps(path("socket"), file, 20));
  EXPECT_THAT(why_saved(file), HasSubstr("catan ctl dump"));
  const Outcome report = run_catan("report --all " + file, folder_);
  EXPECT_EQ(report.exit_code, 0) << report.err;
  EXPECT_THAT(report.out, HasSubstr("eye -> hand"));
  // Nothing that was recorded is overwritten.
  const Outcome again = run_catan("ctl " + path("socket") + " dump " + file, folder_);
  EXPECT_EQ(again.exit_code, 2);
  EXPECT_THAT(again.err, HasSubstr("exists already"));
  EXPECT_EQ(run_catan("ctl " + path("socket") + " dump", folder_).exit_code, 2);
}

TEST_F(FlightCommandTest, AnyProcessThatSchedulesIsFound) {
  serve_all();
  const std::string process = std::to_string(static_cast<int>(server_->process()));
  EXPECT_TRUE(dumps(process, path("found.catan"), 20));
}

TEST_F(FlightCommandTest, AServerThatIsKilledLeavesThem) {
  serve_all();
  ASSERT_TRUE(fast_->runs_on(50));
  EXPECT_TRUE(dumps(path("socket"), path("before.catan"), 50));
  ASSERT_TRUE(eventually([this] { return is_watched(); }));
  kill_server(SIGKILL);
  ASSERT_TRUE(says("the last seconds are in")) << said();
  const std::vector<std::string> saved = records("served-killed-");
  ASSERT_THAT(saved, SizeIs(1));
  EXPECT_GE(runs_in(saved.front()), 50U);
  EXPECT_THAT(why_saved(saved.front()), HasSubstr("ended without stopping"));
}

TEST_F(FlightCommandTest, AServerThatEndsInOrderLeavesNone) {
  serve_all("--record " + path("whole.catan"));
  EXPECT_EQ(kill_server(SIGTERM).code, 0) << said();
  EXPECT_GE(runs_in(path("whole.catan")), 20U);
  EXPECT_THAT(records("served-"), SizeIs(0));
}

TEST_F(FlightCommandTest, ALateResponseIsSaved) {
  serve_all("--on-late 'hand>0.001' --at-most 1");
  ASSERT_TRUE(says("the last seconds are in")) << said();
  const std::vector<std::string> saved = records("served-late-");
  ASSERT_THAT(saved, SizeIs(1));
  EXPECT_THAT(why_saved(saved.front()), HasSubstr("a response of eye -> hand took"));
  EXPECT_GE(runs_in(saved.front()), 1U);
  EXPECT_EQ(kill_server(SIGTERM).code, 0) << said();
}

// At rates that leave the watch time to begin: otherwise nodes take all that threads at real-time levels may have.
TEST_F(FlightCommandTest, ASessionIsWatchedToo) {
  std::ofstream(path("app.yaml")) << served_app("{ eye: { max_rate: 50Hz }, hand: {}, map: { max_rate: 20Hz } }");
  const Outcome outcome =
      run_catan("run app.yaml --synthetic costs.yaml --seconds 2 --on-late 'hand>0.001ms' --at-most 1", folder_);
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("the last seconds are in"));
  ASSERT_THAT(records("served-late-"), SizeIs(1));
}

TEST_F(FlightCommandTest, MistakesExitWith2) {
  for (const char* arguments :
       {"run app.yaml --synthetic costs.yaml --on-late nothing", "serve app.yaml --on-late 'eye>1ms'",
        "run app.yaml --synthetic costs.yaml --on-late hand --flight-recorder 0", "watch no-such-app-runs-here",
        "run app.yaml --synthetic costs.yaml --flight-recorder -1"}) {
    const Outcome outcome = run_catan(arguments, folder_);
    EXPECT_EQ(outcome.exit_code, 2) << arguments << "\n" << outcome.err;
    EXPECT_NE(outcome.err, "") << arguments;
  }
}

}  // namespace
}  // namespace ctn::test
