// In virtual time, with a server that does what the test says.
#include "runtime/server_watch.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/run_access.h"
#include "config/testing/apps.h"
#include "os/fake/fake_os.h"
#include "runtime/notice_thread.h"

namespace ctn::runtime {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr const char* kWatchedApp =
    "catan: 1\napp: two\nnodes: { eye: {}, map: {} }\nedges: []\n"
    "objective: [ { period: eye, weight: 1 }, { period: map, weight: 1 } ]\n";

// What the server schedules.
struct Watched {
  const char* text = kWatchedApp;
  bool cut = false;  // by a policy with rates set by hand

  graph::App app() const {
    graph::App app = parse(text);
    return cut ? graph::cut_at_fallback_rates(app) : app;
  }
};

class VirtualServer : public ServerLink {
 public:
  struct Heard {
    Nanos at;
    std::string what;
    friend bool operator==(const Heard&, const Heard&) = default;
  };

  VirtualServer(os::FakeOs& fake, Watched of) : watched(of), fake_(fake) { start(); }

  // A new server, with a region of its own.
  void start() {
    there = true;
    const graph::App app = watched.app();
    memory_.emplace(*os::SharedMemory::create("watch-test", Region::size_for(app.graph, 1, watched.text)));
    region_.emplace(Region::create(app.graph, 1, watched.text, memory_->bytes(), watched.cut));
    region_->heartbeat().max_heartbeat_gap = Nanos{milliseconds{100}}.count();
  }
  os::SharedMemory shared() const {
    return *os::SharedMemory::open(os::Descriptor{::dup(memory_->descriptor().number())});
  }
  Region& region() { return *region_; }

  std::unique_ptr<Conversation> converse() override { return std::make_unique<Talk>(*this); }
  bool wait(TimePoint deadline) override {
    fake_.sleep_until(deadline);
    return std::exchange(gone, false);
  }
  void hang_up() override { hear("hang up"); }

  Watched watched;  // from the next start() on
  bool there = false;
  bool gone = false;    // for the next wait()
  std::string refused;  // a node, or "hello"
  bool refuses_shared = false;
  std::function<void(const std::string&)> on_join = [](const std::string&) {};
  std::vector<Heard> heard;
  int conversations = 0;

 private:
  class Talk : public Conversation {
   public:
    explicit Talk(VirtualServer& server) : server_(server) { EXPECT_EQ(++server.conversations, 1); }
    ~Talk() override { --server_.conversations; }

    Result<os::SharedMemory> dial(os::ThreadId /*service*/, const Meanwhile& /*meanwhile*/) override {
      server_.hear("hello");
      if (!server_.there) return Error::environment("nobody is there", "");
      if (server_.refused == "hello") return Error::caller("not you", "");
      return server_.shared();
    }
    Status call(const Request& request, const Meanwhile& /*meanwhile*/) override {
      const bool share = request.kind == Request::Kind::kAdd && request.node.empty();
      server_.hear(share ? "share" : (request.kind == Request::Kind::kLeave ? "leave " : "join ") + request.node);
      if (!server_.there) return Error::environment("nobody is there", "");
      if (share && server_.refuses_shared) return Error::caller("there is no node ''", "");
      if (server_.refused == request.node && !share) return Error::caller("another runs it", "");
      server_.on_join(request.node);
      return Done{};
    }

   private:
    VirtualServer& server_;
  };

  void hear(const std::string& what) { heard.push_back({fake_.now().time_since_epoch(), what}); }

  os::FakeOs& fake_;
  std::optional<os::SharedMemory> memory_;
  std::optional<Region> region_;
};

class ServerWatchTest : public ::testing::Test {
 protected:
  using Heard = std::vector<VirtualServer::Heard>;

  explicit ServerWatchTest(Watched of = {}) : watched(of) {
    notices.start();
    for (const NodeId node : {eye, map}) {
      threads.push_back(fake.spawn("node", [this, node] {
        ids[node] = fake.current_thread();
        NodePort& port = *wiring.port(node);
        for (ctn::Run run; port.wait_for_trigger(); port.end(run)) {
          port.begin(run);
          ++runs[node];
        }
      }));
    }
    fake.sleep_until(fake.now());
    for (const NodeId node : {eye, map}) registered.add(node, ids[node]);
    server.region().signal(SubchainId(0)).period = Nanos{milliseconds{20}}.count();
    server.region().signal(SubchainId(1)).period = Nanos{milliseconds{50}}.count();
  }
  ~ServerWatchTest() override {
    watch.leave();
    for (const auto& thread : threads) thread->join();
  }

  ServedRegions first_region() {
    ServedRegions made(app, watched.text);
    EXPECT_TRUE(made.add(server.shared()).ok());
    return made;
  }
  ServerWatch::Program program() {
    return {.os = fake,
            .app = app,
            .link = server,
            .wiring = wiring,
            .registered = registered,
            .notices = notices.notices(),
            .served = served,
            .stopping = [this] { return stopping; }};
  }

  // Turns when they are due. The server's heart beats all the time, or not at all.
  void pass(Nanos duration) {
    const TimePoint until = fake.now() + duration;
    while (next <= until) {
      fake.sleep_until(next);
      if (beats) server.region().heartbeat().beats.fetch_add(1);
      next = watch.step(fake.now(), false);
    }
    fake.sleep_until(until);
  }
  void lose() {
    server.there = false;
    next = watch.step(fake.now(), true);
  }
  os::Level level(NodeId node) { return *fake.level(ids.at(node)); }
  void raise(NodeId node) { ASSERT_TRUE(fake.set_level(ids.at(node), os::Level::kActive).ok()); }

  static constexpr const char* kGone = "server: it is gone; nodes go on at the rates that were planned last";
  static constexpr const char* kSilent =
      "server: it does nothing any more; nodes go on at the rates that were planned last";
  static constexpr const char* kBack = "server: there is one again, and it schedules the nodes";

  const Watched watched;
  os::FakeOs fake;
  graph::App app = parse(watched.text);
  NodeId eye = *app.graph.find_node("eye");
  NodeId map = *app.graph.find_node("map");
  VirtualServer server{fake, watched};
  ServedRegions regions = first_region();
  Wiring wiring{regions.newest_app(), fake, regions.newest()};
  ClientNodes registered{fake};
  std::vector<std::pair<Nanos, std::string>> told;
  std::function<void(const std::string&)> on_notice = [](const std::string&) {};
  NoticeThread notices{fake,
                       [this](const std::string& text) {
                         told.emplace_back(fake.now().time_since_epoch(), text);
                         on_notice(text);
                       },
                       false};
  std::atomic<bool> served{false};
  bool stopping = false;
  ServerWatch watch{program(), std::move(regions)};
  std::map<NodeId, os::ThreadId> ids;
  std::map<NodeId, int> runs;
  std::vector<std::unique_ptr<os::Thread>> threads;
  bool beats = true;
  TimePoint next{};
};

TEST_F(ServerWatchTest, AServerWithAHeartbeatIsLeftAlone) {
  pass(seconds{10});
  EXPECT_TRUE(served);
  EXPECT_TRUE(told.empty());
  EXPECT_TRUE(server.heard.empty());
  EXPECT_TRUE(runs.empty());
}

TEST_F(ServerWatchTest, AServerThatIsStoppedCountsAsGoneUntilItGoesOn) {
  pass(seconds{1});
  beats = false;
  raise(eye);
  pass(milliseconds{99});
  EXPECT_TRUE(served);
  pass(milliseconds{1});
  EXPECT_FALSE(served) << "two looks in 100 ms without a beat";
  EXPECT_EQ(level(eye), os::Level::kOrdinary);
  pass(milliseconds{200});
  EXPECT_EQ(runs[eye], 11) << "at once, and every 20 ms";
  EXPECT_EQ(runs[map], 5);
  EXPECT_TRUE(server.heard.empty()) << "it would not answer";
  pass(milliseconds{5});
  beats = true;
  pass(milliseconds{5});
  EXPECT_TRUE(served);
  const Nanos back = milliseconds{1310};
  EXPECT_EQ(server.heard, (Heard{{back, "hang up"}, {back, "hello"}, {back, "join eye"}, {back, "join map"}}));
  EXPECT_EQ(told, (std::vector<std::pair<Nanos, std::string>>{{milliseconds{1100}, kSilent}, {back, kBack}}));
}

TEST_F(ServerWatchTest, TheNextServerIsTriedTenTimesASecondAndGetsAllNodes) {
  pass(seconds{1});
  lose();
  EXPECT_FALSE(served);
  pass(milliseconds{250});
  EXPECT_EQ(runs[eye], 13);
  server.start();
  server.region().node(eye).word = 1;
  pass(milliseconds{50});
  EXPECT_TRUE(served);
  EXPECT_EQ(runs[eye], 16) << "15 by itself, and one that was triggered in the new region";
  Heard expected;
  for (const int at : {1000, 1100, 1200}) {
    expected.push_back({milliseconds{at}, "hello"});
    expected.push_back({milliseconds{at}, "hang up"});
  }
  for (const char* what : {"hello", "join eye", "join map"}) expected.push_back({milliseconds{1300}, what});
  EXPECT_EQ(server.heard, expected);
  EXPECT_EQ(told, (std::vector<std::pair<Nanos, std::string>>{{seconds{1}, kGone}, {milliseconds{1300}, kBack}}));
}

TEST_F(ServerWatchTest, EachServerIsToldOnceOfThreadsThatWorkForAll) {
  pass(seconds{1});
  ASSERT_TRUE(registered.share(fake.current_thread()).ok());
  pass(seconds{1});
  EXPECT_EQ(server.heard, (Heard{{milliseconds{1050}, "share"}})) << "at the next step";
  server.heard.clear();
  server.start();
  next = watch.step(fake.now(), true);
  EXPECT_TRUE(served);
  const Nanos at = milliseconds{2000};
  EXPECT_EQ(server.heard, (Heard{{at, "hello"}, {at, "join eye"}, {at, "join map"}, {at, "share"}}));
  pass(seconds{1});
  EXPECT_EQ(server.heard.size(), 4U);
}

TEST_F(ServerWatchTest, AServerThatDoesNotKnowOfSharedThreadsSchedulesTheNodes) {
  ASSERT_TRUE(registered.share(fake.current_thread()).ok());
  server.refuses_shared = true;
  pass(milliseconds{100});
  EXPECT_TRUE(served);
  server.start();
  next = watch.step(fake.now(), true);
  EXPECT_TRUE(served);
}

constexpr const char* kRow =
    "catan: 1\napp: two\nnodes: { eye: { fallback_rate: 50Hz }, map: { fallback_rate: 20Hz } }\nedges: [ eye -> map ]\n"
    "subchains: { row: [eye, map] }\nobjective: [ { period: eye, weight: 1 } ]\n";

class CutSubchainTest : public ServerWatchTest {
 protected:
  CutSubchainTest() : ServerWatchTest({.text = kRow, .cut = true}) {}
};

TEST_F(CutSubchainTest, GoesOnAtTheRatesOfItsNodesUntilAServerHasItWhole) {
  pass(seconds{1});
  lose();
  pass(milliseconds{250});
  EXPECT_EQ(runs[eye], 13) << "every 20 ms";
  EXPECT_EQ(runs[map], 6) << "every 50 ms, and not after each of these";
  server.watched.cut = false;
  server.start();
  server.region().node(eye).word = 1;
  pass(milliseconds{50});
  EXPECT_TRUE(served);
  EXPECT_EQ(runs[eye], 16) << "15 by itself, and one that was triggered in the new region";
  EXPECT_EQ(runs[map], 7) << "triggered by that one";
}

TEST_F(ServerWatchTest, AServerThatRefusesTheProgramIsTriedMoreAndMoreSeldomAndToldOnce) {
  server.refused = "hello";
  next = watch.step(fake.now(), true);
  pass(seconds{60});
  std::vector<Nanos> tried;
  for (const auto& [at, what] : server.heard) {
    if (what == "hello") tried.push_back(at);
  }
  ASSERT_GT(tried.size(), 8U);
  for (std::size_t i = 1; i < tried.size(); ++i) {
    EXPECT_EQ(tried[i] - tried[i - 1],
              std::min<Nanos>(milliseconds{100} * (1 << std::min<std::size_t>(i - 1, 10)), seconds{5}));
  }
  ASSERT_EQ(told.size(), 2U);
  EXPECT_EQ(told[1].second, "server: there is one, but nodes go on without it: not you");
}

TEST_F(ServerWatchTest, AServerThatRefusesOneNodeGetsNone) {
  pass(seconds{1});
  lose();
  server.start();
  server.refused = "map";
  server.on_join = [&](const std::string&) { raise(eye); };
  pass(milliseconds{100});
  EXPECT_FALSE(served);
  EXPECT_EQ(level(eye), os::Level::kOrdinary) << "it was raised before the other was refused";
  EXPECT_EQ(server.region().node(eye).word, 0U);
  const int before = runs[eye];
  pass(milliseconds{100});
  EXPECT_EQ(runs[eye], before + 5) << "nodes go on where they are";
  server.refused.clear();
  pass(seconds{1});
  EXPECT_TRUE(served);
}

// Guards: a call of a server that is stopped may take effect after threads were restored, and that was not checked
// again.
TEST_F(ServerWatchTest, AThreadThatIsRaisedAfterItsServerWentAwayIsRestored) {
  pass(seconds{1});
  lose();
  for (int times = 0; times < 3; ++times) {
    pass(milliseconds{15});
    raise(map);
    pass(milliseconds{5});
    EXPECT_EQ(level(map), os::Level::kOrdinary);
  }
  pass(ServerWatch::kLongestCall);
  raise(map);
  pass(seconds{1});
  EXPECT_EQ(level(map), os::Level::kActive) << "no call of the server takes as long: it was not the server";
}

// Guards: a stopped server's answer was waited for.
TEST_F(ServerWatchTest, WhoLeavesDoesNotAskAServerThatDoesNothing) {
  beats = false;
  pass(seconds{1});
  ASSERT_FALSE(served);
  raise(eye);
  server.there = false;  // as it is for a program that has hung up
  server.heard.clear();
  watch.leave();
  ASSERT_FALSE(server.heard.empty());
  EXPECT_EQ(server.heard.front().what, "hang up");
  EXPECT_EQ(level(eye), os::Level::kOrdinary);
}

TEST_F(ServerWatchTest, WhoLeavesRestoresThreadsThatNoServerRestores) {
  raise(eye);
  watch.leave();
  EXPECT_EQ(level(eye), os::Level::kActive) << "the server restores it";
  server.there = false;
  watch.leave();
  EXPECT_EQ(level(eye), os::Level::kOrdinary);
  EXPECT_FALSE(served);
}

// A user's callback may do whatever a user may: no lock is held when it is called.
TEST_F(ServerWatchTest, TheCallbackMayCallBack) {
  on_notice = [&](const std::string& text) {
    EXPECT_FALSE(served);
    EXPECT_EQ(server.converse()->call({.kind = Request::Kind::kAdd, .node = "eye"}).ok(), server.there);
    registered.add_thread(eye, fake.current_thread());
    EXPECT_EQ(registered.all().front().others, std::vector<os::ThreadId>{fake.current_thread()});
    notices.notices().add({fake.now(), "test", "it has heard: " + text});
    stopping = true;
    on_notice = [](const std::string&) {};
  };
  server.gone = true;
  server.there = false;
  watch.run();
  notices.stop();
  ASSERT_EQ(told.size(), 2U);
  EXPECT_EQ(told[1].second, std::string("test: it has heard: ") + kGone);
}

// Guards: the callback was called by the thread that watches, and while it blocked nodes were not triggered.
TEST_F(ServerWatchTest, NodesAreTriggeredWhileTheCallbackBlocks) {
  std::atomic<std::uint32_t> may_return{0};
  on_notice = [&](const std::string&) { fake.wait(may_return, 0, kNever); };
  server.gone = true;
  server.there = false;
  const auto watching = fake.spawn("link", [&] { watch.run(); });
  fake.sleep_until(fake.now() + milliseconds{210});
  server.start();
  fake.sleep_until(fake.now() + milliseconds{100});
  EXPECT_EQ(told.size(), 1U);
  EXPECT_GE(runs[eye], 11) << "at once, and every 20 ms";
  EXPECT_TRUE(served) << "and the next server gets them";
  stopping = true;
  fake.sleep_until(fake.now() + milliseconds{200});
  watching->join();
  may_return.store(1);
  fake.wake(may_return);
  notices.stop();
  ASSERT_EQ(told.size(), 2U) << "in order, before it stops";
  EXPECT_EQ(told[0].second, kGone);
  EXPECT_EQ(told[1].second, kBack);
}

}  // namespace
}  // namespace ctn::runtime
