// catan serve from outside, with programs that die, hang, lie and come back. Times are generous: it is the real
// machine.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <optional>
#include <random>
#include <string>
#include <utility>

#include "os/linux/connection.h"
#include "os/linux/descriptor.h"
#include "os/linux/forked_process.h"
#include "os/linux/listener.h"
#include "os/linux/shared_memory.h"
#include "os/testing/requires_real_time.h"
#include "runtime/protocol.h"
#include "served_app.h"

namespace ctn::test {
namespace {

using testing::HasSubstr;

class ServeTest : public ServedAppTest {
 protected:
  std::unique_ptr<CountingNodes> run_here(const std::vector<std::pair<std::string, Nanos>>& nodes,
                                          std::function<void(const std::string&)> on_notice = {}) {
    Result<Client> client = connect(std::move(on_notice));
    if (!client) {
      ADD_FAILURE() << client.error().message();
      return nullptr;
    }
    return std::make_unique<CountingNodes>(std::move(*client), *os_, nodes);
  }
  std::unique_ptr<CountingNodes> run_fast() { return run_here({{"eye", milliseconds{1}}, {"hand", milliseconds{1}}}); }
  // Has a thread raised that has run its node. Before that the program may still wait for the answer to its
  // registration.
  bool raises(os::ProcessId process) {
    return eventually([&] {
      const std::vector<os::ThreadId> raised = raised_of(process);
      return std::any_of(raised.begin(), raised.end(), [&](os::ThreadId thread) {
        const Result<Nanos> used = os_->thread_cpu_time(thread);
        return used && *used >= milliseconds{1};
      });
    });
  }
  // A connection of our own, to say to the server what no client of ours says.
  Result<os::Connection> dial(const std::string& socket = "socket") {
    Result<os::Connection> connection = os::Connection::connect(path(socket));
    for (int attempt = 0; !connection && attempt < 100; ++attempt) {
      std::this_thread::sleep_for(milliseconds{20});
      connection = os::Connection::connect(path(socket));
    }
    return connection;
  }
  std::string ask(const os::Connection& connection, const std::string& text, os::Message& answer) {
    if (Status sent = connection.send(text); !sent) return "not sent";
    os::Arrival arrival = os::Arrival::kNothing;
    eventually([&] { return (arrival = connection.receive(answer)) != os::Arrival::kNothing; }, seconds{2});
    if (arrival == os::Arrival::kClosed) return "closed";
    return arrival == os::Arrival::kMessage ? answer.text : "nothing";
  }
  std::string ask(const os::Connection& connection, const std::string& text) {
    os::Message answer;
    return ask(connection, text, answer);
  }
  std::string hello() const {
    return runtime::to_text(runtime::Request{.kind = runtime::Request::Kind::kHello,
                                             .node = {},
                                             .thread = static_cast<std::int32_t>(os_->current_thread())});
  }
};

TEST_F(ServeTest, SchedulesProgramsOfTheirOwn) {
  serve();
  play({"map"});
  const auto fast = run_fast();
  ASSERT_TRUE(fast);
  EXPECT_TRUE(fast->runs_on(100)) << said();
  EXPECT_TRUE(says("subchain slow runs"));
  EXPECT_EQ(kill_server(SIGTERM), os::Exit{});
}

TEST_F(ServeTest, RaisesThreadsOfProgramsAndRestoresThemWhenItEnds) {
  CATAN_REQUIRE_REAL_TIME(*os_);
  serve();
  const os::ProcessId map = play({"map"}).process();
  const auto fast = run_fast();
  ASSERT_TRUE(fast);
  EXPECT_TRUE(raises(os_->current_process())) << said();
  EXPECT_TRUE(raises(map)) << said();
  EXPECT_EQ(kill_server(SIGTERM), os::Exit{});
  EXPECT_EQ(raised_threads(os_->current_process()) + raised_threads(map), 0);
}

// Guards: the file was read once by the command and once by the server. What has come out of a pipe does not come
// again.
TEST_F(ServeTest, ReadsItsAppFileOnce) {
  ASSERT_EQ(::mkfifo(path("pipe").c_str(), 0600), 0);
  serve("socket", "pipe");
  std::thread([&] { std::ofstream(path("pipe")) << served_app(); }).join();
  const auto fast = run_fast();
  ASSERT_TRUE(fast) << said();
  EXPECT_TRUE(fast->runs_on(10)) << said();
}

TEST_F(ServeTest, ANodeOfTwoProcessesOfASubchainTriggersTheNext) {
  serve();
  play({"eye"});
  const auto hand = run_here({{"hand", milliseconds{1}}});
  ASSERT_TRUE(hand);
  EXPECT_TRUE(hand->runs_on(50)) << said();
}

TEST_F(ServeTest, KilledItLeavesNobodyRaisedNodesGoOnAndAnotherTakesOver) {
  serve();
  os::ChildProcess& map = play({"map"});
  const auto fast = run_fast();
  ASSERT_TRUE(fast && fast->runs_on(50)) << said();
  ASSERT_TRUE(says("subchain slow runs"));
  for (int round = 0; round < 3; ++round) {
    SCOPED_TRACE(round);
    const int before = fast->runs;
    kill_server(SIGKILL);
    EXPECT_TRUE(eventually([&] { return !fast->client().served(); }, seconds{2}));
    EXPECT_TRUE(eventually([&] { return raised_threads(os_->current_process()) + raised_threads(map.process()) == 0; },
                           seconds{2}))
        << testing::PrintToString(names_of_raised(os_->current_process())) << " and of map "
        << testing::PrintToString(names_of_raised(map.process()));
    EXPECT_TRUE(fast->runs_on(10)) << "after " << before << " runs";
    serve();
    EXPECT_TRUE(eventually([&] { return fast->client().served(); }));
    EXPECT_TRUE(fast->runs_on(20)) << said();
  }
}

TEST_F(ServeTest, TheNextServerRaisesThreadsOfProgramsAgain) {
  CATAN_REQUIRE_REAL_TIME(*os_);
  serve();
  const os::ProcessId map = play({"map"}).process();
  const auto fast = run_fast();
  ASSERT_TRUE(fast && raises(map) && raises(os_->current_process())) << said();
  kill_server(SIGKILL);
  ASSERT_TRUE(eventually([&] { return raised_threads(os_->current_process()) + raised_threads(map) == 0; }));
  serve();
  EXPECT_TRUE(raises(map)) << said();
  EXPECT_TRUE(raises(os_->current_process())) << said();
}

// A driver of two processes. Without a server, too, and without its leader it waits.
TEST_F(ServeTest, AFollowerRunsWithTheLeaderOfAnotherProcess) {
  std::ofstream(path("app.yaml")) << R"(catan: 1
app: served
nodes: { imu: { unscheduled: true, period: 10ms }, sum: { unscheduled: true }, warp: { fallback_rate: 20Hz } }
edges: [ imu -> sum -> warp ]
objective: [ { period: warp, weight: 1 } ]
scheduler: { bootstrap: 200ms, bootstrap_cost: 2ms }
)";
  std::ofstream(path("costs.yaml")) << "imu: 0.1ms\nwarp: 1ms\n";
  serve();
  const auto sum = run_here({{"sum", Nanos{0}}});
  ASSERT_TRUE(sum);
  std::this_thread::sleep_for(milliseconds{200});
  EXPECT_EQ(sum->runs, 0);
  os::ChildProcess* imu = &play({"imu"});
  EXPECT_TRUE(sum->runs_on(50)) << said();
  kill_server(SIGKILL);
  EXPECT_TRUE(eventually([&] { return !sum->client().served(); }, seconds{2}));
  EXPECT_TRUE(sum->runs_on(50)) << "both are by themselves";
  serve();
  EXPECT_TRUE(eventually([&] { return sum->client().served(); }));
  EXPECT_TRUE(sum->runs_on(50)) << said();
  for (int round = 1; round <= 2; ++round) {
    ASSERT_TRUE(imu->signal(SIGKILL).ok());
    EXPECT_TRUE(eventually([&] { return times_said("node imu is gone") == round; }, seconds{2})) << said();
    const int before = sum->runs;
    std::this_thread::sleep_for(milliseconds{200});
    EXPECT_LE(sum->runs, before + 1);
    imu = &play({"imu"});
    EXPECT_TRUE(sum->runs_on(50)) << said();
  }
}

TEST_F(ServeTest, ANodeThatDiesIsNoticedAndMayComeBack) {
  serve();
  const auto fast = run_fast();
  ASSERT_TRUE(fast);
  for (int round = 1; round <= 5; ++round) {
    os::ChildProcess& map = play({"map"});
    EXPECT_TRUE(eventually([&] { return times_said("subchain slow runs") == round; })) << said();
    std::this_thread::sleep_for(milliseconds{50 * round});
    ASSERT_TRUE(map.signal(SIGKILL).ok());
    EXPECT_TRUE(eventually([&] { return times_said("node map is gone") == round; }, seconds{2})) << said();
    EXPECT_TRUE(fast->runs_on(20)) << "others go on";
  }
  EXPECT_THAT(said(), testing::Not(HasSubstr("hangs")));
}

TEST_F(ServeTest, AStoppedProgramIsSuspendedAndGoesOn) {
  serve();
  const auto fast = run_fast();
  os::ChildProcess& map = play({"map"});
  ASSERT_TRUE(fast && says("subchain slow runs"));
  std::this_thread::sleep_for(milliseconds{300});
  ASSERT_TRUE(map.signal(SIGSTOP).ok());
  // It stops between runs, too; then its next trigger waits.
  EXPECT_TRUE(says("a run of subchain slow hangs"));
  EXPECT_TRUE(fast->runs_on(50)) << "others go on";
  ASSERT_TRUE(map.signal(SIGCONT).ok());
  EXPECT_TRUE(says("the run of subchain slow that hung has ended"));
}

TEST_F(ServeTest, WhoForksAndDiesIsGone) {
  serve();
  const auto fast = run_fast();
  ASSERT_TRUE(fast);
  const os::ForkedProcess child([&] {
    Result<os::Connection> connection = dial();
    if (!connection) return 1;
    ask(*connection, hello());
    ask(*connection,
        runtime::to_text(runtime::Request{
            .kind = runtime::Request::Kind::kJoin, .node = "map", .thread = static_cast<std::int32_t>(::getpid())}));
    if (::fork() == 0) {  // keeps the socket, speaks in its parent's name, and lives on for a while
      for (int i = 0; i < 50; ++i) {
        ask(*connection, runtime::to_text(runtime::Request{.kind = runtime::Request::Kind::kLeave, .node = "map"}));
        ::usleep(50000);
      }
      ::_exit(0);
    }
    ::usleep(500000);
    return 0;
  });
  EXPECT_TRUE(says("subchain slow runs"));
  EXPECT_TRUE(says("node map is gone: its process has ended")) << said();
  EXPECT_TRUE(fast->runs_on(20));
}

TEST_F(ServeTest, AForkedChildLeavesTheClientAlone) {
  CATAN_REQUIRE_REAL_TIME(*os_);
  serve();
  play({"map"});
  Result<Client> client = connect();
  ASSERT_TRUE(client.ok()) << client.error().message();
  CountingNodes nodes(std::move(*client), *os_, {{"eye", milliseconds{1}}, {"hand", milliseconds{1}}});
  ASSERT_TRUE(nodes.runs_on(20)) << said();
  os::ForkedProcess child([&] {
    ::alarm(20);
    const auto refused = [](const Status& done) { return !done && done.error().kind() == ErrorKind::kCaller; };
    Client& copy = nodes.client();
    const Result<AttachedNode> attached = copy.attach("map");
    const bool all_refused = refused(copy.start()) && refused(copy.adopt_this_thread("eye")) &&
                             refused(copy.share_thread(static_cast<int>(os_->current_thread()))) && !attached;
    const bool served = copy.served();
    copy.stop();
    { const Client destroyed = std::move(copy); }
    return all_refused && !served ? 0 : 1;
  });
  EXPECT_EQ(child.join(), 0) << "negative: the signal that ended it";
  EXPECT_TRUE(nodes.client().served());
  EXPECT_TRUE(nodes.runs_on(20)) << said();
  EXPECT_TRUE(raises(os_->current_process()));
}

TEST_F(ServeTest, NobodyTouchesThreadsThatAreNotTheirOwn) {
  serve();
  const os::ForkedProcess victim([] { return ::pause(); });
  Result<os::Connection> connection = dial();
  ASSERT_TRUE(connection.ok());
  EXPECT_THAT(ask(*connection, R"({"join": {"node": "map", "thread": 1}})"), HasSubstr("before hello"));
  EXPECT_THAT(ask(*connection, R"({"hello": {"version": 2, "thread": 1}})"), HasSubstr("is not one of process"));
  EXPECT_THAT(ask(*connection, R"({"hello": {"version": 99, "thread": 1}})"), HasSubstr("version"));
  EXPECT_THAT(ask(*connection, hello()), HasSubstr("done"));
  for (const int thread : {1, static_cast<int>(victim.number())}) {
    const std::string text =
        runtime::to_text(runtime::Request{.kind = runtime::Request::Kind::kJoin, .node = "map", .thread = thread});
    EXPECT_THAT(ask(*connection, text), HasSubstr("is not one of process"));
  }
  EXPECT_THAT(ask(*connection, R"({"add": {"node": "map", "thread": 1}})"), HasSubstr("does not run node map"));
  EXPECT_THAT(ask(*connection, R"({"join": {"node": "nobody", "thread": 1}})"), HasSubstr("no node 'nobody'"));
  EXPECT_THAT(ask(*connection, std::string(5000, 'x').substr(0, 4096)), HasSubstr("not understood"));
  EXPECT_EQ(*os_->level(os::ThreadId{victim.number()}), os::Level::kOrdinary);
}

// A program that has the region may write anything into it, as long as it likes.
TEST_F(ServeTest, SurvivesAProgramThatWritesAnythingAnywhere) {
  serve();
  const auto map = run_here({{"map", milliseconds{1}}});
  ASSERT_TRUE(map && map->runs_on(10)) << said();
  {
    const os::ForkedProcess vandal([&] {
      Result<os::Connection> connection = dial();
      os::Message answer;
      if (!connection) return 1;
      ask(*connection, hello(), answer);
      auto memory = os::SharedMemory::open(std::move(answer.descriptor));
      if (!memory) return 2;
      std::mt19937_64 random(1);
      const std::span<std::byte> bytes = memory->bytes();
      for (;;) {
        for (int i = 0; i < 10000; ++i) {
          const std::size_t at = random() % (bytes.size() / 8) * 8;
          const std::uint64_t value = random() % 3 == 0 ? random() : random() % 100;
          std::memcpy(bytes.data() + at, &value, sizeof value);
        }
        ::usleep(1000);
      }
      return 0;
    });
    std::this_thread::sleep_for(seconds{3});
    EXPECT_FALSE(server_->wait().has_value()) << said();
  }
  EXPECT_EQ(kill_server(SIGTERM), os::Exit{}) << "it ends in order: " << said();
  EXPECT_EQ(raised_threads(os_->current_process()), 0);
}

TEST_F(ServeTest, SurvivesFloods) {
  serve();
  const auto fast = run_fast();
  ASSERT_TRUE(fast && fast->runs_on(10)) << said();
  const os::ForkedProcess flood([&] {
    std::vector<os::Connection> kept;
    for (;;) {
      Result<os::Connection> connection = os::Connection::connect(path("socket"));
      if (!connection) {
        kept.clear();
        continue;
      }
      for (int i = 0; i < 100; ++i) static_cast<void>(connection->send("{\"hello\": 1}"));
      kept.push_back(std::move(*connection));
    }
    return 0;
  });
  for (int second = 0; second < 3; ++second) {
    std::this_thread::sleep_for(seconds{1});
    EXPECT_TRUE(fast->runs_on(10, seconds{2})) << "nodes are paced all the same";
  }
  EXPECT_FALSE(server_->wait().has_value()) << said();
}

TEST_F(ServeTest, KeepsNothingOfProgramsThatCameAndWent) {
  serve();
  ASSERT_TRUE(dial().ok());
  const auto open_files = [&] {
    const std::filesystem::directory_iterator files("/proc/" + std::to_string(static_cast<int>(server_->process())) +
                                                    "/fd");
    return std::distance(files, {});
  };
  std::this_thread::sleep_for(milliseconds{200});
  const auto before = open_files();
  for (int i = 0; i < 300; ++i) {
    Result<os::Connection> connection = dial();
    ASSERT_TRUE(connection.ok());
    if (i % 2 == 0) ask(*connection, hello());
  }
  EXPECT_TRUE(eventually([&] { return open_files() <= before; })) << before << " before, " << open_files() << " now";
}

// Neither server nor guardian is left to give threads back.
TEST_F(ServeTest, KilledWithItsGuardianProgramsRestoreTheirThreadsThemselves) {
  CATAN_REQUIRE_REAL_TIME(*os_);
  serve();
  os::ChildProcess& map = play({"map"});
  const auto fast = run_fast();
  ASSERT_TRUE(fast && fast->runs_on(50)) << said();
  ASSERT_TRUE(raises(map.process())) << said();
  const pid_t guardian = guardian_of_server();
  ASSERT_NE(guardian, 0);
  const os::CpuSet before = *os_->affinity(os_->current_thread());
  ::kill(guardian, SIGKILL);
  kill_server(SIGKILL);
  EXPECT_TRUE(eventually([&] { return raised_threads(os_->current_process()) + raised_threads(map.process()) == 0; },
                         seconds{2}));
  EXPECT_TRUE(fast->runs_on(10));
  for (const os::ThreadId thread : *os_->threads(map.process())) EXPECT_EQ(*os_->affinity(thread), before);
  serve();
  EXPECT_TRUE(raises(map.process())) << said();
}

TEST_F(ServeTest, StoppedProgramsGoOnByThemselvesUntilItGoesOn) {
  serve();
  os::ChildProcess& map = play({"map"});
  const auto fast = run_fast();
  ASSERT_TRUE(fast && fast->runs_on(50)) << said();
  for (int round = 0; round < 3; ++round) {
    ASSERT_TRUE(server_->signal(SIGSTOP).ok());
    EXPECT_TRUE(eventually([&] { return !fast->client().served(); }));
    EXPECT_TRUE(eventually([&] { return raised_threads(os_->current_process()) + raised_threads(map.process()) == 0; },
                           seconds{5}));
    EXPECT_TRUE(fast->runs_on(20)) << "they pace themselves";
    ASSERT_TRUE(server_->signal(SIGCONT).ok());
    EXPECT_TRUE(eventually([&] { return fast->client().served(); }));
    EXPECT_TRUE(fast->runs_on(20)) << said();
  }
  ASSERT_TRUE(server_->signal(SIGSTOP).ok());
  EXPECT_TRUE(eventually([&] { return !fast->client().served(); }));
  kill_server(SIGKILL);
  EXPECT_TRUE(fast->runs_on(20)) << "killed while it was stopped";
}

TEST_F(ServeTest, StoppedAndGoingOnItRaisesThreadsOfProgramsAgain) {
  CATAN_REQUIRE_REAL_TIME(*os_);
  serve();
  const os::ProcessId map = play({"map"}).process();
  const auto fast = run_fast();
  ASSERT_TRUE(fast && raises(map)) << said();
  for (int round = 0; round < 3; ++round) {
    ASSERT_TRUE(server_->signal(SIGSTOP).ok());
    ASSERT_TRUE(eventually([&] { return raised_threads(map) == 0; }));
    ASSERT_TRUE(server_->signal(SIGCONT).ok());
    EXPECT_TRUE(raises(map)) << said();
  }
}

// It was told so ten times a second, and had the subchain's head triggered in the new server's memory.
TEST_F(ServeTest, WhoIsRefusedByTheNextServerStaysByItselfAndLeavesItAlone) {
  serve();
  std::atomic<int> refusals{0};
  const auto fast = run_here({{"eye", milliseconds{1}}, {"hand", milliseconds{1}}}, [&](const std::string& text) {
    refusals += text.find("nodes go on without it") != std::string::npos;
  });
  ASSERT_TRUE(fast && fast->runs_on(10)) << said();
  kill_server(SIGKILL);
  ASSERT_TRUE(eventually([&] { return !fast->client().served(); }));
  {
    // The server is reached where the program looks for it only once another has the node hand.
    serve("aside");
    Result<os::Connection> connection = dial("aside");
    ASSERT_TRUE(connection.ok());
    ask(*connection, hello());
    const std::string joined = ask(
        *connection,
        runtime::to_text(runtime::Request{
            .kind = runtime::Request::Kind::kJoin, .node = "hand", .thread = static_cast<std::int32_t>(::getpid())}));
    ASSERT_THAT(joined, HasSubstr("done"));
    std::filesystem::rename(path("aside"), path("socket"));
    EXPECT_TRUE(eventually([&] { return refusals > 0; }));
    EXPECT_TRUE(fast->runs_on(20)) << "it goes on by itself";
    std::this_thread::sleep_for(seconds{1});
    EXPECT_EQ(refusals, 1) << "said once";
    EXPECT_FALSE(fast->client().served());
    // Each time it has eye until hand is refused. In a second and more, at 100 ms, 200 ms, 400 ms, ...
    EXPECT_LE(times_said("node eye is gone"), 6) << said();
  }
  EXPECT_TRUE(eventually([&] { return fast->client().served(); })) << "the node is free again";
  EXPECT_TRUE(fast->runs_on(20)) << said();
}

// For two seconds each time, while it waited for the answer.
TEST_F(ServeTest, WhoWaitsForAServerThatDoesNotAnswerGoesOnByItself) {
  serve();
  const auto fast = run_fast();
  ASSERT_TRUE(fast && fast->runs_on(10)) << said();
  kill_server(SIGKILL);
  ASSERT_TRUE(eventually([&] { return !fast->client().served(); }));
  {
    const Result<os::Listener> silent = os::Listener::open(path("socket"), 0600);
    ASSERT_TRUE(silent.ok()) << silent.error().message();
    const auto until = std::chrono::steady_clock::now() + milliseconds{2500};
    while (std::chrono::steady_clock::now() < until) ASSERT_TRUE(fast->runs_on(4, seconds{1}));
  }
  serve();
  EXPECT_TRUE(eventually([&] { return fast->client().served(); })) << said();
}

TEST_F(ServeTest, AThreadCanBeNamedWhileThereIsNoServer) {
  serve();
  const auto fast = run_fast();
  ASSERT_TRUE(fast && fast->runs_on(10)) << said();
  kill_server(SIGKILL);
  ASSERT_TRUE(eventually([&] { return !fast->client().served(); }));
  EXPECT_TRUE(fast->client().adopt_this_thread("eye").ok());
  EXPECT_FALSE(fast->client().adopt_this_thread("map").ok()) << "it is not this program's";
  serve();
  EXPECT_TRUE(eventually([&] { return fast->client().served(); })) << said();
}

TEST_F(ServeTest, TheCallbackOfAProgramMayCallItBack) {
  serve();
  std::atomic<Client*> client{nullptr};
  std::vector<std::string> told;
  const auto fast = run_here({{"eye", milliseconds{1}}, {"hand", milliseconds{1}}}, [&](const std::string& text) {
    told.push_back(text);
    if (client == nullptr || text.find("it is gone") == std::string::npos) return;
    EXPECT_FALSE(client.load()->served());
    EXPECT_TRUE(client.load()->adopt_this_thread("eye").ok());
    client.load()->stop();
  });
  ASSERT_TRUE(fast && fast->runs_on(10)) << said();
  client = &fast->client();
  kill_server(SIGKILL);
  EXPECT_TRUE(eventually([&] { return !fast->runs_on(1, milliseconds{500}); })) << "it has stopped";
  fast->client().stop();
  EXPECT_EQ(told.size(), 1U);
}

TEST_F(ServeTest, AFunctionOfANodeMayStopItsProgram) {
  serve();
  Result<Client> client = connect({});
  ASSERT_TRUE(client.ok()) << client.error().message();
  std::atomic<int> runs{0};
  client->node("eye", [&](ctn::Run&) {
    if (++runs == 20) client->stop();
  });
  client->node("hand", [](ctn::Run&) {});
  ASSERT_TRUE(client->start().ok());
  EXPECT_TRUE(eventually([&] { return times_said("node eye is gone") == 1; })) << said();
  EXPECT_EQ(runs, 20) << "it has stopped";
  client->stop();
}

TEST_F(ServeTest, AThreadThatWasNamedWithoutAServerIsRaisedByTheNext) {
  CATAN_REQUIRE_REAL_TIME(*os_);
  serve();
  const auto fast = run_fast();
  ASSERT_TRUE(fast && fast->runs_on(10)) << said();
  kill_server(SIGKILL);
  ASSERT_TRUE(eventually([&] { return !fast->client().served(); }));
  ASSERT_TRUE(fast->client().adopt_this_thread("eye").ok());
  serve();
  EXPECT_TRUE(eventually([&] { return *os_->level(os_->current_thread()) != os::Level::kOrdinary; })) << said();
  kill_server(SIGTERM);
  EXPECT_EQ(*os_->level(os_->current_thread()), os::Level::kOrdinary);
}

// The nodes use nearly all of the CPU on which the thread has to be. Of 5 s it waits for 4.5 and more; half is enough.
TEST_F(ServeTest, TellsOfAThreadThatNoNodeHasAndThatGetsNoCpu) {
  CATAN_REQUIRE_REAL_TIME(*os_);
  if (!os_->ready_time()) GTEST_SKIP() << "this kernel does not tell ready time";
  serve();
  const auto nodes = run_here({{"eye", milliseconds{1}}, {"hand", milliseconds{1}}, {"map", milliseconds{4}}});
  ASSERT_TRUE(nodes);
  std::atomic<bool> stop{false};
  const auto helper = os_->spawn("helper", [&] {
    EXPECT_TRUE(os_->set_affinity(os_->current_thread(), os::CpuSet{os_->online_cpus()->cpus().front()}).ok());
    while (!stop) continue;
  });
  EXPECT_TRUE(eventually([&] { return said().find("ordinary-threads: ") != std::string::npos; }, seconds{30}))
      << said();
  stop = true;
  EXPECT_THAT(said(), HasSubstr("nodes eye, hand, map) that no node has wait for a CPU")) << said();
  EXPECT_THAT(said(), HasSubstr("s helper (thread "));
}

// The server takes all threads of a program of one node for that node's, until it hears of another. Those that the
// program names stay.
TEST_F(ServeTest, LetsGoOfThreadsItFoundWhenTheirProgramRunsAnotherNode) {
  CATAN_REQUIRE_REAL_TIME(*os_);
  for (const bool named : {false, true}) {
    SCOPED_TRACE(named);
    serve();
    const auto eye = run_here({{"eye", milliseconds{1}}});
    ASSERT_TRUE(eye);
    std::atomic<bool> may_attach{false};
    std::atomic<int> runs{0};
    std::thread late([&] {
      eventually([&] { return may_attach.load(); });
      Result<AttachedNode> hand = eye->client().attach("hand");
      EXPECT_TRUE(hand.ok()) << (hand ? "" : hand.error().message());
      ctn::Run run;
      while (hand && hand->wait()) {
        hand->begin(run);
        ++runs;
        hand->end(run);
      }
    });
    const auto raised = [&](os::ThreadId thread) { return *os_->level(thread) != os::Level::kOrdinary; };
    // Placed on the server's CPU; raised only once all of the subchain's nodes are there.
    const os::CpuSet cpus{os_->online_cpus()->cpus().front()};
    EXPECT_TRUE(eventually([&] { return *os_->affinity(os_->current_thread()) == cpus; })) << "it is found";
    if (named) {
      EXPECT_TRUE(eye->client().adopt_this_thread("eye").ok());
    }
    may_attach = true;
    EXPECT_TRUE(eventually([&] { return runs > 50; })) << said();
    EXPECT_EQ(raised(os_->current_thread()), named);
    // All that the program knows of what hand's thread had is what the server made of it.
    ::kill(guardian_of_server(), SIGKILL);
    kill_server(SIGKILL);
    EXPECT_TRUE(eventually([&] { return raised_threads(os_->current_process()) == 0; }, seconds{2}))
        << testing::PrintToString(names_of_raised(os_->current_process()));
    eye->client().stop();
    late.join();
  }
}

// A pipe that nobody reads, and that is full: what is told there is kept for a while, and nobody waits for it.
TEST_F(ServeTest, EndsWhileNobodyReadsWhatItSays) {
  ASSERT_EQ(::mkfifo(path("said").c_str(), 0600), 0);
  const os::Descriptor pipe(::open(path("said").c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC));
  ASSERT_TRUE(pipe.valid());
  const std::string page(4096, '.');
  while (::write(pipe.number(), page.data(), page.size()) > 0) {
  }
  serve();
  ASSERT_TRUE(eventually([&] { return std::filesystem::exists(path("socket")); }));
  Result<Client> client = connect();
  ASSERT_TRUE(client.ok()) << client.error().message();
  {
    CountingNodes map(std::move(*client), *os_, {{"map", milliseconds{1}}});
    EXPECT_TRUE(map.runs_on(5)) << "it schedules";
  }  // which is told: node-left
  ASSERT_TRUE(server_->signal(SIGTERM).ok());
  std::optional<os::Exit> exit;
  EXPECT_TRUE(eventually([&] { return (exit = server_->wait()).has_value(); }));
  EXPECT_EQ(exit, os::Exit{});
}

}  // namespace
}  // namespace ctn::test
