// In virtual time, with the fake OS: programs that are not there, whose threads are this one's.
#include "runtime/registry.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "config/app_file.h"
#include "os/fake/fake_os.h"

namespace ctn::runtime {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class CountingOs : public os::FakeOs {
 public:
  using FakeOs::FakeOs;
  Result<std::vector<os::ThreadId>> threads(os::ProcessId process) override {
    ++reads;
    return FakeOs::threads(process);
  }

  int reads = 0;  // of which threads there are
};

// Two nodes of one program, which this process is, on CPU 0.
class RegistryTest : public ::testing::Test {
 protected:
  explicit RegistryTest(int cpus) : fake(os::fake_topology(cpus)) {}

  void schedule(const std::string& policy) {
    SchedulerOptions options;
    options.policy = *policy::make_policy(policy);
    scheduler = *Scheduler::create(app, fake, std::move(options), os::CpuSet{0}, memory.region());
    const Status ready = scheduler->prepare();
    EXPECT_TRUE(ready.ok()) << ready.error().message();
    registry = std::make_unique<Registry>(fake, *scheduler);
    connect();
  }
  // From now on it speaks by another connection, if it had one.
  void connect() {
    program = registry->enter(fake.current_process());
    EXPECT_EQ(say({.kind = Request::Kind::kHello, .thread = number(fake.current_thread())}), "");
  }

  static std::int32_t number(os::ThreadId thread) { return static_cast<std::int32_t>(thread); }
  std::string say(const Request& request) {
    const Status done = parse_reply(registry->handle(program, fake.current_process(), to_text(request)).text);
    return done ? "" : done.error().message();
  }
  std::string join(const std::string& node, os::ThreadId thread) {
    return say({.kind = Request::Kind::kJoin, .node = node, .thread = number(thread)});
  }

  CountingOs fake;
  graph::App app = *config::parse_app(R"(catan: 1
app: two
nodes: { light: {}, heavy: {} }
objective: [ { period: light, weight: 0.1 }, { period: heavy, weight: 1 } ]
)",
                                      "app.yaml");
  LocalRegion memory{app.graph, 1};
  std::unique_ptr<Scheduler> scheduler;
  std::unique_ptr<Registry> registry;
  Registry::ProgramId program{};
  std::vector<std::unique_ptr<os::Thread>> threads;
};

class WhoControls : public RegistryTest {
 protected:
  WhoControls() : RegistryTest(1) { schedule("catan"); }
};

TEST_F(WhoControls, IsToldWhichAppIsScheduledAndOthersAreNot) {
  const std::string asked = to_text(Request{.kind = Request::Kind::kApp});
  const auto ask = [&](bool may_control) {
    const Registry::ProgramId asking = registry->enter(fake.current_process(), may_control);
    return parse_app_reply(registry->handle(asking, fake.current_process(), asked).text);
  };
  const Result<std::string> told = ask(true);
  ASSERT_TRUE(told.ok()) << told.error().message();
  EXPECT_EQ(*told, "two");
  EXPECT_EQ(ask(false).error().kind(), ErrorKind::kCaller);
}

class SharedThreads : public RegistryTest {
 protected:
  SharedThreads() : RegistryTest(1) {
    schedule("catan");
    for (os::ThreadId* const id : {&light, &heavy, &network}) {
      threads.push_back(fake.spawn("thread", [this, id] {
        *id = fake.current_thread();
        fake.sleep_until(TimePoint{std::chrono::hours{1}});
      }));
    }
    fake.sleep_until(fake.now() + std::chrono::milliseconds{1});
  }

  std::string leave(const std::string& node) { return say({.kind = Request::Kind::kLeave, .node = node}); }
  std::string share(os::ThreadId thread) {
    return say({.kind = Request::Kind::kAdd, .node = "", .thread = number(thread)});
  }
  std::vector<os::ThreadId> threads_of(const std::string& node) {
    return scheduler->threads(*app.graph.find_node(node));
  }

  os::ThreadId light{};
  os::ThreadId heavy{};
  os::ThreadId network{};
};

TEST_F(SharedThreads, WorkForTheNodeThatWeighsMostOfThoseThatAreThere) {
  EXPECT_EQ(share(network), "");
  EXPECT_EQ(join("light", light), "");
  EXPECT_THAT(threads_of("light"), ElementsAre(light, network));
  EXPECT_EQ(join("heavy", heavy), "");
  EXPECT_THAT(threads_of("light"), ElementsAre(light));
  EXPECT_THAT(threads_of("heavy"), ElementsAre(heavy, network));
  EXPECT_EQ(leave("heavy"), "");
  EXPECT_THAT(threads_of("heavy"), IsEmpty());
  EXPECT_THAT(threads_of("light"), ElementsAre(light, network));
  EXPECT_EQ(leave("light"), "");
  EXPECT_THAT(threads_of("light"), IsEmpty());
}

TEST_F(SharedThreads, AreTakenOverWheneverTheyAreNamedAndOnce) {
  EXPECT_EQ(join("light", light), "");
  EXPECT_EQ(join("heavy", heavy), "");
  EXPECT_EQ(share(network), "");
  EXPECT_EQ(share(network), "");
  EXPECT_THAT(threads_of("heavy"), ElementsAre(heavy, network));
}

TEST_F(SharedThreads, GetBackWhatTheyHadWithTheLastNode) {
  const os::CpuSet before = *fake.affinity(network);
  EXPECT_EQ(share(network), "");
  EXPECT_EQ(*fake.level(network), os::Level::kOrdinary);
  EXPECT_EQ(join("heavy", heavy), "");
  EXPECT_TRUE(fake.set_level(network, os::Level::kActive).ok());  // as the controller does
  registry->leave(program, "it has ended");
  EXPECT_EQ(*fake.level(network), os::Level::kOrdinary);
  EXPECT_EQ(*fake.affinity(network), before);
}

TEST_F(SharedThreads, AreTheProgramsOwn) {
  EXPECT_THAT(share(os::ThreadId{99999}), HasSubstr("is not one of process"));
  EXPECT_THAT(share(fake.current_thread()), HasSubstr("serves the connection"));
}

// Or the one that releases it gives it back what it had, and the other's controller raises it again, for good.
TEST_F(SharedThreads, WorkForOneNodeAtATime) {
  EXPECT_EQ(join("light", light), "");
  EXPECT_THAT(share(light), HasSubstr("works for one node already"));
  EXPECT_EQ(share(network), "");
  EXPECT_EQ(share(heavy), "");
  EXPECT_EQ(join("heavy", heavy), "");
  EXPECT_THAT(threads_of("light"), ElementsAre(light));
  EXPECT_THAT(threads_of("heavy"), ElementsAre(heavy, network)) << "its own is shared no more";
  EXPECT_EQ(say({.kind = Request::Kind::kAdd, .node = "light", .thread = number(network)}), "");
  EXPECT_THAT(threads_of("light"), ElementsAre(light, network)) << "nor is one that is named for a node";
  EXPECT_THAT(threads_of("heavy"), ElementsAre(heavy));
  EXPECT_EQ(leave("heavy"), "");
  EXPECT_THAT(threads_of("light"), ElementsAre(light, network));
}

TEST_F(SharedThreads, OfAnotherConnectionOfTheProcessAreAsMuchOneNodes) {
  EXPECT_EQ(join("light", light), "");
  EXPECT_EQ(share(network), "");
  const Registry::ProgramId first = program;
  program = registry->enter(fake.current_process());
  EXPECT_EQ(say({.kind = Request::Kind::kHello, .thread = number(fake.current_thread())}), "");
  EXPECT_THAT(share(light), HasSubstr("works for one node already"));
  EXPECT_EQ(join("heavy", heavy), "");
  EXPECT_THAT(share(network), HasSubstr("works for one node already"));
  EXPECT_THAT(threads_of("heavy"), ElementsAre(heavy));
  program = first;
  EXPECT_EQ(leave("light"), "");
  EXPECT_THAT(threads_of("light"), IsEmpty());
}

// As above: each connection looks for threads, and runs one node.
TEST_F(SharedThreads, OfAnotherConnectionOfTheProcessAreNotFoundForIts) {
  EXPECT_EQ(join("light", light), "");
  for (int search = 0; search < 2; ++search) registry->find_threads();
  EXPECT_THAT(threads_of("light"), ElementsAre(light, heavy, network)) << "it runs one node";
  const Registry::ProgramId first = program;
  program = registry->enter(fake.current_process());
  EXPECT_EQ(say({.kind = Request::Kind::kHello, .thread = number(fake.current_thread())}), "");
  EXPECT_EQ(join("heavy", heavy), "");
  for (int search = 0; search < 3; ++search) registry->find_threads();
  EXPECT_THAT(threads_of("light"), ElementsAre(light));
  EXPECT_THAT(threads_of("heavy"), ElementsAre(heavy));
  EXPECT_THAT(say({.kind = Request::Kind::kAdd, .node = "heavy", .thread = number(light)}),
              HasSubstr("works for node light"));
  registry->leave(first, "it has ended");
  for (int search = 0; search < 2; ++search) registry->find_threads();
  EXPECT_THAT(threads_of("heavy"), ElementsAre(heavy, light, network));
}

TEST_F(SharedThreads, AThreadIsOneNodes) {
  EXPECT_EQ(join("light", light), "");
  EXPECT_THAT(join("heavy", light), HasSubstr("works for node light"));
  EXPECT_THAT(threads_of("heavy"), IsEmpty());
  EXPECT_EQ(join("heavy", heavy), "");
}

TEST_F(SharedThreads, AreLookedForOnceForEachRequest) {
  const auto reads_of = [&](const auto& request) {
    const int before = fake.reads;
    request();
    return fake.reads - before;
  };
  EXPECT_EQ(reads_of([&] { EXPECT_EQ(share(network), ""); }), 1);
  EXPECT_EQ(reads_of([&] { EXPECT_EQ(join("light", light), ""); }), 1);
  EXPECT_EQ(reads_of([&] { EXPECT_EQ(join("heavy", heavy), ""); }), 1);
  EXPECT_EQ(reads_of([&] { EXPECT_EQ(leave("heavy"), ""); }), 1);
  EXPECT_EQ(reads_of([&] { registry->find_threads(); }), 1);
}

TEST_F(SharedThreads, MayHaveBeenFoundBefore) {
  EXPECT_EQ(join("heavy", heavy), "");
  registry->find_threads();
  registry->find_threads();
  EXPECT_THAT(threads_of("heavy"), ElementsAre(heavy, light, network));
  EXPECT_EQ(share(network), "");
  registry->find_threads();
  EXPECT_EQ(join("light", light), "");
  EXPECT_THAT(threads_of("light"), ElementsAre(light));
  EXPECT_THAT(threads_of("heavy"), ElementsAre(heavy, network));
}

TEST_F(SharedThreads, AreForgottenWhenTheyEndAlsoWhileNoNodeIsThere) {
  os::ThreadId brief{};
  const auto thread = fake.spawn("brief", [&] {
    brief = fake.current_thread();
    fake.sleep_until(fake.now() + std::chrono::milliseconds{2});
  });
  fake.sleep_until(fake.now() + std::chrono::milliseconds{1});
  EXPECT_EQ(share(brief), "");
  thread->join();
  EXPECT_EQ(join("heavy", heavy), "");
  EXPECT_THAT(threads_of("heavy"), ElementsAre(heavy));
}

// A program of two nodes on CPU 0, one of which works most of the time, and a thread of its own there.
class OrdinaryThreadsOfPrograms : public RegistryTest {
 protected:
  OrdinaryThreadsOfPrograms() : RegistryTest(2) {
    fake.share_cpus(true);
    EXPECT_TRUE(fake.set_affinity(fake.current_thread(), os::CpuSet{1}).ok());
  }

  // It works for so much of each 10 ms.
  os::ThreadId spawn(const std::string& name, Nanos work) {
    os::ThreadId id{};
    threads.push_back(fake.spawn(name, [this, work, &id] {
      id = fake.current_thread();
      EXPECT_TRUE(fake.set_affinity(id, os::CpuSet{0}).ok());
      for (TimePoint next = fake.now(); !stop; fake.sleep_until(next)) {
        fake.burn(work);
        next = std::max(next + std::chrono::milliseconds{10}, fake.now());
      }
    }));
    fake.sleep_until(fake.now() + std::chrono::milliseconds{1});
    return id;
  }
  // Its controller raises it.
  void join_and_raise(const std::string& node, os::ThreadId thread) {
    EXPECT_EQ(join(node, thread), "");
    EXPECT_TRUE(fake.set_level(thread, os::Level::kActive).ok());
  }
  std::vector<std::string> told_in_a_minute() {
    const std::size_t before = scheduler->snapshot().notices.size();
    for (int look = 0; look < 12; ++look) {
      fake.sleep_until(fake.now() + OrdinaryThreads::kPeriod);
      registry->look_at_ordinary_threads(fake.now());
    }
    std::vector<std::string> notices = scheduler->snapshot().notices;
    notices.erase(notices.begin(), notices.begin() + static_cast<std::ptrdiff_t>(before));
    return notices;
  }
  void end() {
    stop = true;
    threads.clear();
  }

  bool stop = false;
};

TEST_F(OrdinaryThreadsOfPrograms, ThatWaitMostOfTheTimeAreToldOfOnce) {
  schedule("catan");
  join_and_raise("heavy", spawn("heavy", std::chrono::milliseconds{9}));
  EXPECT_EQ(join("light", spawn("light", Nanos{0})), "");
  spawn("helper", std::chrono::milliseconds{2});
  const std::vector<std::string> told = told_in_a_minute();
  end();
  ASSERT_EQ(told.size(), 1U);
  EXPECT_THAT(told.front(),
              AllOf(HasSubstr("ordinary-threads: threads of program main (process 1000, nodes light, heavy)"),
                    HasSubstr("Of the last 5.0 s helper (thread 4) waited for 4.5 s and ran for 0.5 s")));
}

TEST_F(OrdinaryThreadsOfPrograms, OfAProcessThatConnectedTwiceAreToldOfOnce) {
  schedule("catan");
  join_and_raise("heavy", spawn("heavy", std::chrono::milliseconds{9}));
  connect();
  EXPECT_EQ(join("light", spawn("light", Nanos{0})), "");
  spawn("helper", std::chrono::milliseconds{2});
  EXPECT_EQ(told_in_a_minute().size(), 1U);
  end();
}

TEST_F(OrdinaryThreadsOfPrograms, ThatGetWhatTheyNeedAreNotToldOf) {
  schedule("catan");
  EXPECT_EQ(join("heavy", spawn("heavy", std::chrono::milliseconds{5})), "");
  EXPECT_EQ(join("light", spawn("light", Nanos{0})), "");
  spawn("helper", std::chrono::milliseconds{2});
  EXPECT_THAT(told_in_a_minute(), IsEmpty());
  end();
}

TEST_F(OrdinaryThreadsOfPrograms, DoNotCountWhileANodeHasThem) {
  schedule("catan");
  join_and_raise("heavy", spawn("heavy", std::chrono::milliseconds{9}));
  EXPECT_EQ(join("light", spawn("light", Nanos{0})), "");
  const os::ThreadId helper = spawn("helper", std::chrono::milliseconds{2});
  EXPECT_EQ(say({.kind = Request::Kind::kAdd, .node = "light", .thread = number(helper)}), "");
  EXPECT_THAT(told_in_a_minute(), IsEmpty());
  end();
}

// There threads of nodes are ordinary ones, too: who has to wait does not wait for Catan's sake.
TEST_F(OrdinaryThreadsOfPrograms, AreLeftAloneWhereNodesDoNotGoBeforeThem) {
  schedule("rate:100Hz");
  EXPECT_EQ(join("heavy", spawn("heavy", std::chrono::milliseconds{9})), "");
  EXPECT_EQ(join("light", spawn("light", Nanos{0})), "");
  spawn("helper", std::chrono::milliseconds{9});
  EXPECT_THAT(told_in_a_minute(), IsEmpty());
  end();
}

}  // namespace
}  // namespace ctn::runtime
