// catan top from outside: the real command watches a real session and a real server. What these measure depends on the
// machine, so that only what holds on any is asked; exact figures are the module's to test (src/view/view_test.cpp).
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <fstream>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include <nlohmann/json.hpp>

#include "command_test.h"
#include "served_app.h"

namespace ctn::test {
namespace {

using nlohmann::json;
using testing::HasSubstr;

class TopTest : public ServedAppTest {
 protected:
  Outcome top(const std::string& arguments) const { return run_catan("top " + arguments, folder_); }

  // A session in a process of its own, on one CPU.
  std::string start_session() {
    const std::string cpu = std::to_string(os_->online_cpus()->cpus().front());
    Result<os::ChildProcess> started = os::ChildProcess::start(
        {"/bin/sh", "-c", "exec \"$0\" run \"$1\" --synthetic \"$2\" --cpus \"$3\" --seconds 600 >/dev/null 2>>\"$4\"",
         CATAN_COMMAND, path("app.yaml"), path("costs.yaml"), cpu, path("said")});
    EXPECT_TRUE(started.ok()) << started.error().message();
    session_.emplace(std::move(*started));
    return std::to_string(static_cast<int>(session_->process()));
  }
  // Once responses have been measured.
  json watched(const std::string& target) const {
    json picture;
    EXPECT_TRUE(eventually(
        [&] {
          const Outcome outcome = top(target + " --once --json");
          if (outcome.exit_code != 0) return false;
          EXPECT_EQ(outcome.err, "");
          picture = json::parse(outcome.out);
          return !picture["plan"].is_null() && !picture["chains"][0]["response_ms"].is_null() &&
                 !picture["subchains"][1]["period_ms"].is_null();
        },
        seconds{60}))
        << top(target + " --once").err << said();
    return picture;
  }
  void expect_all_of_the_app(const json& picture) const {
    EXPECT_EQ(picture["app"], "served");
    EXPECT_EQ(picture["scheduler"], "catan");
    EXPECT_EQ(picture["state"], "running");
    EXPECT_GT(picture["window_s"], 0.5);
    EXPECT_LE(picture["window_s"], 10.0);
    const json& chain = picture["chains"][0];
    EXPECT_EQ(chain["path"], "eye -> hand");
    EXPECT_GT(chain["response_ms"]["p95"], 2.0) << "two nodes of a millisecond each";
    EXPECT_GT(chain["promised_ms"], 2.0);
    EXPECT_EQ(chain["worst_ms"].size(), 60U);
    std::set<std::string> names;
    for (const json& subchain : picture["subchains"]) {
      names.insert(subchain["subchain"]);
      EXPECT_GT(subchain["runs"], 0);
      EXPECT_GT(subchain["used_ms"]["p50"], 0.9);
      EXPECT_GT(subchain["budget_ms"], 0.9);
      EXPECT_EQ(subchain["cores"], json{0});
    }
    EXPECT_EQ(names, (std::set<std::string>{"fast", "slow"}));
    ASSERT_EQ(picture["cores"].size(), 1U);
    EXPECT_GT(picture["cores"][0]["busy"], 0.1);
    EXPECT_EQ(picture["cores"][0]["uses"].size(), 2U);
    EXPECT_EQ(picture["nodes"].size(), 3U);
    EXPECT_EQ(picture["notices"][0]["kind"].is_string(), true);
  }

  std::optional<os::ChildProcess> session_;
};

TEST_F(TopTest, WatchesASessionUntilItIsKilled) {
  const std::string process = start_session();
  expect_all_of_the_app(watched(process));
  const Outcome text = top(process + " --once");
  EXPECT_EQ(text.exit_code, 0) << text.err;
  for (const char* part : {"served  catan", "eye -> hand", "fast", "slow", "CPU", "plan: ", "compute ms"}) {
    EXPECT_THAT(text.out, HasSubstr(part));
  }
  const Outcome undrawn = top(process);
  EXPECT_EQ(undrawn.exit_code, 2);
  EXPECT_THAT(undrawn.err, HasSubstr("--once"));
  EXPECT_EQ(undrawn.out, "");

  ASSERT_TRUE(session_->signal(SIGKILL).ok());
  ASSERT_TRUE(eventually([&] { return session_->wait().has_value(); }));
  const Outcome gone = top(process + " --once");
  EXPECT_EQ(gone.exit_code, 2);
  EXPECT_THAT(gone.err, HasSubstr("no process schedules an app"));
  session_.reset();
}

TEST_F(TopTest, WatchesAServerByItsSocket) {
  serve();
  play({"eye", "hand", "map"});
  expect_all_of_the_app(watched(path("socket")));
}

// Two that watch, one of which is stopped, and then killed: the app does not notice.
TEST_F(TopTest, ViewersAreNoConcernOfTheApp) {
  const std::string process = start_session();
  watched(process);
  Result<os::ChildProcess> viewer = os::ChildProcess::start(
      {"/bin/sh", "-c", "exec \"$0\" top \"$1\" --once >\"$2\" 2>&1", CATAN_COMMAND, process, path("shown")});
  ASSERT_TRUE(viewer.ok());
  ASSERT_TRUE(viewer->signal(SIGSTOP).ok());
  const json before = watched(process);
  const json after = watched(process);
  EXPECT_GT(after["up_s"], before["up_s"]);
  EXPECT_EQ(after["state"], "running");
  ASSERT_TRUE(viewer->signal(SIGKILL).ok());
  ASSERT_TRUE(eventually([&] { return viewer->wait().has_value(); }));
  EXPECT_EQ(watched(process)["lost"], 0);
}

TEST_F(TopTest, WatchesFromCpusThatTheAppDoesNotUse) {
  const std::string process = start_session();
  watched(process);
  expect_off_the_apps_cpu("top " + process + " --once");
}

TEST_F(TopTest, MistakesAreTold) {
  EXPECT_EQ(top("nowhere/app.yaml --once").exit_code, 1);
  EXPECT_EQ(top("catan-top-test-no-such-app --once").exit_code, 2);
  EXPECT_EQ(top("--json").exit_code, 2);
  std::ofstream(path("broken.yaml")) << "catan: 1\napp: served\nnodes: {}\nedgs: []\n";
  const Outcome broken = top("broken.yaml --once");
  EXPECT_EQ(broken.exit_code, 2);
  EXPECT_THAT(broken.err, HasSubstr("edgs"));
}

}  // namespace
}  // namespace ctn::test
