// catan ctl from outside: the real command controls a real server, and who may not is refused. Times are generous: it
// is the real machine.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <utility>

#include <nlohmann/json.hpp>

#include "os/linux/forked_process.h"
#include "os/testing/requires_real_time.h"
#include "record/app_changes.h"
#include "record/reader.h"
#include "runtime/control.h"
#include "served_app.h"

namespace ctn::test {
namespace {

using testing::HasSubstr;
using Json = nlohmann::json;

struct Answer {
  int code = -1;
  std::string text;  // of both outputs
};

class CtlTest : public ServedNodesTest {
 protected:
  Answer ctl(const std::string& arguments) const {
    const std::string command = std::string(CATAN_COMMAND) + " ctl " + arguments + " 2>&1";
    std::FILE* const pipe = ::popen(command.c_str(), "r");
    Answer answer;
    std::array<char, 4096> buffer{};
    for (std::size_t count = 0; (count = std::fread(buffer.data(), 1, buffer.size(), pipe)) > 0;) {
      answer.text.append(buffer.data(), count);
    }
    const int status = ::pclose(pipe);
    answer.code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    return answer;
  }
  // Of the server of the test.
  Answer ask(const std::string& arguments) const { return ctl(path("socket") + " " + arguments); }
  Json status() const { return Json::parse(ask("status --json").text); }
  void expect_done(const std::string& arguments) const {
    const Answer answer = ask(arguments);
    EXPECT_EQ(answer.code, 0) << arguments << ": " << answer.text;
    EXPECT_EQ(answer.text, "") << arguments;
  }
  void expect_refused(const std::string& arguments, int code, const std::string& why) const {
    const Answer answer = ask(arguments);
    EXPECT_EQ(answer.code, code) << arguments;
    EXPECT_THAT(answer.text, HasSubstr(why)) << arguments;
  }
};

TEST_F(CtlTest, ChangesWhatIsAskedAndSaysWhatIsInForce) {
  serve_all("--record " + path("record.catan"));
  expect_done("weight 'eye -> hand' 2.5 map 0");
  expect_done("max 0 400ms");
  expect_done("min-rate map 3Hz");
  // What is asked within one step of the server is said in one line.
  ASSERT_TRUE(says("nodes.map.min_rate: none -> 3Hz")) << said();
  EXPECT_THAT(said(), HasSubstr("objective[0].weight (eye -> hand): 1 -> 2.5"));
  Json now = status();
  EXPECT_EQ(now["changes"], 3);
  EXPECT_EQ(now["objective"][0], (Json{{"term", "eye -> hand"}, {"weight", 2.5}, {"max_ms", 400.0}}));
  EXPECT_EQ(now["objective"][1]["weight"], 0.0);
  const Answer page = ask("status");
  EXPECT_EQ(page.code, 0);
  EXPECT_THAT(page.text, HasSubstr("0: eye -> hand"));
  EXPECT_THAT(page.text, HasSubstr("3 changes"));
  expect_done("max 0 none");
  expect_done("min-rate map none");
  EXPECT_TRUE(eventually([&] { return status()["objective"][0]["max_ms"].is_null(); }));
  EXPECT_TRUE(fast_->runs_on(20)) << "it runs on";
  ASSERT_TRUE(says("nodes.map.min_rate: 3Hz -> none"));
  EXPECT_EQ(kill_server(SIGTERM), os::Exit{});
  const Result<record::Reader> record = record::Reader::open(path("record.catan"));
  ASSERT_TRUE(record.ok()) << record.error().message();
  const auto changes = record->app_changes();
  ASSERT_TRUE(changes.ok());
  EXPECT_EQ(changes->size(), 6U);
  EXPECT_EQ(record::app_after(record->app(), *changes)->objective[0].weight, 2.5);
}

TEST_F(CtlTest, CpusAreThoseThatAreAsked) {
  const os::CpuSet mine = *os_->affinity(os_->current_thread());
  CATAN_REQUIRE(mine.size() >= 2, "needs two CPUs that this process may use; here: " << mine.size());
  const std::string one = std::to_string(mine.cpus()[1]);
  const std::string both = os::to_string(os::CpuSet{mine.cpus()[0], mine.cpus()[1]});
  serve_all("", both);
  expect_done("cpus " + one);
  EXPECT_TRUE(eventually([&] { return status()["cpus"] == Json{mine.cpus()[1]}; })) << said();
  EXPECT_TRUE(fast_->runs_on(20));
  expect_done("cpus " + both);
  EXPECT_TRUE(eventually([&] { return status()["cpus"].size() == 2; }));
  expect_refused("cpus 4095", 2, "CPU 4095 is not one of those that were given; choose from " + both);
}

// A program may not go where the plan wants it any more, so the whole app keeps off that CPU.
TEST_F(CtlTest, CpusThatAreTakenFromAProgramOrFromTheServerAreNotUsed) {
  const os::CpuSet mine = *os_->affinity(os_->current_thread());
  CATAN_REQUIRE(mine.size() >= 2, "needs two CPUs that this process may use; here: " << mine.size());
  const os::CpuSet one{mine.cpus()[1]};
  const os::CpuSet both{mine.cpus()[0], mine.cpus()[1]};
  serve_all("", os::to_string(both));
  const auto uses = [&](const os::CpuSet& cpus) {
    return eventually([&] { return status()["cpus"] == Json(cpus.cpus()); });
  };
  ASSERT_TRUE(uses(both));
  const auto bind_threads = [&](os::ProcessId process, const os::CpuSet& cpus) {
    for (const os::ThreadId thread : *os_->threads(process)) EXPECT_TRUE(os_->set_affinity(thread, cpus).ok());
  };
  const os::ProcessId map = programs_.front()->process();
  bind_threads(map, one);
  EXPECT_TRUE(uses(one)) << said();
  bind_threads(map, both);
  EXPECT_TRUE(uses(both)) << said();
  const os::ThreadId main_of_server = os_->main_thread(server_->process());
  EXPECT_TRUE(os_->set_affinity(main_of_server, one).ok());
  EXPECT_TRUE(uses(one)) << said();
  // Whoever ends takes nothing from the others any more.
  EXPECT_TRUE(os_->set_affinity(main_of_server, both).ok());
  bind_threads(map, one);
  EXPECT_TRUE(uses(one));
  programs_.clear();
  EXPECT_TRUE(uses(both)) << said();
  EXPECT_TRUE(fast_->runs_on(20));
}

TEST_F(CtlTest, MistakesAreToldAndChangeNothing) {
  serve_all();
  expect_refused("weight nobody 1", 2, "the objective has no such term; choose from 0 (eye -> hand)");
  expect_refused("weight 0 much", 2, "'much' is no number");
  expect_refused("weight 0 0.5 1", 2, "takes pairs");
  expect_refused("max map 5ms", 2, "a period is bounded by a rate");
  expect_refused("max 0 5", 2, "has no unit");
  expect_refused("min-rate map fast", 2, "map");
  expect_refused("cpus", 2, "takes one list of CPUs");
  expect_refused("cpus -- -1", 2, "-1");
  expect_refused("shrink 1", 2, "status");
  expect_refused("cpus 0 --json", 2, "--json is for 'status'");
  EXPECT_EQ(status()["changes"], 0);
  EXPECT_EQ(ctl(path("nowhere.sock") + " status").code, 1);
  EXPECT_EQ(ctl("").code, 2);
}

TEST_F(CtlTest, FindsTheServerByTheAppsFileOrName) {
  ASSERT_EQ(::setenv("CATAN_SOCKET", path("socket").c_str(), 1), 0);
  serve_all();
  EXPECT_EQ(ctl(path("app.yaml") + " status").code, 0);
  EXPECT_EQ(ctl("served status").code, 0);
  ::unsetenv("CATAN_SOCKET");
}

// In a shell below `catan run APP -- COMMAND`, where CATAN_SOCKET is that of APP.
TEST_F(CtlTest, AnAppThatIsNamedGoesBeforeTheEnvironment) {
  const std::string other = folder_ + "/catan/other.sock";
  std::filesystem::create_directory(folder_ + "/catan");
  std::string text = served_app();
  text.replace(text.find("app: served"), 11, "app: other");
  std::ofstream(path("other.yaml")) << text;
  serve_all();
  ASSERT_EQ(::setenv("CATAN_SOCKET", path("socket").c_str(), 1), 0);
  ASSERT_EQ(::setenv("XDG_RUNTIME_DIR", folder_.c_str(), 1), 0);
  for (const std::string& target : {path("other.yaml"), std::string("other")}) {
    for (const char* const action : {" weight 0 2.5", " status"}) {
      const Answer answer = ctl(target + action);
      EXPECT_EQ(answer.code, 1) << answer.text;
      EXPECT_THAT(answer.text, HasSubstr("no server answers for 'other' at"));
      EXPECT_THAT(answer.text, HasSubstr("the one at " + path("socket") + " schedules 'served'"));
    }
  }
  EXPECT_EQ(status()["changes"], 0);

  std::optional<os::ChildProcess> first = std::exchange(server_, std::nullopt);
  serve("catan/other.sock", "other.yaml");
  ASSERT_TRUE(eventually([&] { return ctl(other + " status").code == 0; })) << said();
  EXPECT_EQ(ctl("other weight 0 2.5").code, 0);
  EXPECT_EQ(status()["changes"], 0);
  EXPECT_EQ(Json::parse(ctl(other + " status --json").text)["changes"], 1);
  // What lasts in memory is that of the app that is named, too.
  EXPECT_EQ(ctl("other dump " + path("last.catan")).code, 0);
  const Result<record::Reader> dumped = record::Reader::open(path("last.catan"));
  ASSERT_TRUE(dumped.ok()) << dumped.error().message();
  EXPECT_EQ(dumped->app().name, "other");
  ::unsetenv("XDG_RUNTIME_DIR");
  ::unsetenv("CATAN_SOCKET");
}

// Somebody may register, and may not control.
TEST_F(CtlTest, OnlyRootAndTheServersOwnUserMayControlIt) {
  CATAN_REQUIRE(::geteuid() == 0, "needs root, to be another user");
  constexpr uid_t kSomebody = 65534;
  constexpr int kShutOut = 8;
  ASSERT_EQ(::chmod(folder_.c_str(), 0755), 0);
  serve("socket", "app.yaml", "", "--allow-user " + std::to_string(kSomebody));
  ASSERT_TRUE(eventually([&] { return ask("status").code == 0; }));
  os::ForkedProcess somebody([&] {
    if (::setuid(kSomebody) != 0) return 9;
    if (::access(folder_.c_str(), X_OK) != 0) return kShutOut;
    const runtime::ServerAddress server{.sockets = {path("socket")}};
    const Status changed = runtime::ask_to_change(*os_, server, {.weights = {{"0", 5.0}}});
    if (changed.ok() || changed.error().kind() != ErrorKind::kCaller) return 1;
    if (changed.error().message().find("only root and the user that the server runs as") == std::string::npos) return 2;
    return runtime::ask_for_status(*os_, server).ok() ? 3 : 0;
  });
  const int ended = somebody.join();
  CATAN_REQUIRE(ended != kShutOut, "needs a folder for temporary files that other users may enter");
  EXPECT_EQ(ended, 0);
  EXPECT_EQ(status()["changes"], 0);
}

}  // namespace
}  // namespace ctn::test
