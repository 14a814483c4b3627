// The whole runtime in virtual time: real threads, real channels, the fake operating system. Every figure is exact.
#include "runtime/engine.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <set>

#include "base/testing/times.h"
#include "config/testing/apps.h"
#include "os/fake/fake_os.h"
#include "os/fake/faulty_os.h"

namespace ctn::runtime {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

template <class T>
Channel<T>& channel(Engine& engine, const char* from, const char* to) {
  return static_cast<Channel<T>&>(
      engine.wiring().open_channel(from, to, false, typeid(Channel<T>), make_channel<Channel<T>>));
}

EngineOptions options(const std::string& policy, int cpus) {
  std::vector<int> set;
  for (int cpu = 0; cpu < cpus; ++cpu) set.push_back(cpu);
  return {.policy = *policy::make_policy(policy), .cpus = os::CpuSet(set), .record = {}, .note = {}, .on_notice = {}};
}

// The tracker with nodes that burn fixed times and pass the number of the frame on.
class TrackerTest : public ::testing::Test {
 protected:
  void open(const std::string& policy, int cpus, os::Os& system, const graph::App& app = tracker_app()) {
    EngineOptions chosen = options(policy, cpus);
    chosen.on_notice = on_notice;
    Result<std::unique_ptr<Engine>> made = Engine::create(app, system, std::move(chosen));
    ASSERT_TRUE(made.ok()) << made.error().message();
    engine = std::move(*made);
    const char* names[] = {"camera", "detect", "plan", "motor"};
    for (int index = 0; index < 4; ++index) {
      Channel<int>* in = index > 0 ? &channel<int>(*engine, names[index - 1], names[index]) : nullptr;
      Channel<int>* out = index < 3 ? &channel<int>(*engine, names[index], names[index + 1]) : nullptr;
      engine->wiring().set_body(names[index], [this, in, out, index](ctn::Run& run) {
        const int* input = in != nullptr ? in->read(run) : nullptr;
        taken[static_cast<std::size_t>(index)].push_back({fake.now(), input != nullptr ? *input : 0});
        fake.burn(costs[static_cast<std::size_t>(index)](run.number()));
        if (out != nullptr) out->write(run, input != nullptr ? *input : static_cast<int>(run.number()));
      });
    }
  }

  Snapshot run_for(Nanos duration) {
    const Status started = engine->start();
    EXPECT_TRUE(started.ok()) << started.error().message();
    fake.sleep_until(fake.now() + duration);
    Snapshot snapshot = engine->snapshot();
    EXPECT_TRUE(engine->stop().ok());
    return snapshot;
  }

  static std::function<Nanos(std::uint64_t)> always(Nanos cost) {
    return [cost](std::uint64_t) { return cost; };
  }

  // When each run of a node began, and the number of the frame that it took.
  struct Taken {
    TimePoint at;
    int frame;
  };

  os::FakeOs fake{os::fake_topology(2)};
  std::array<std::vector<Taken>, 4> taken;  // each written by its node's thread alone
  std::vector<std::function<Nanos(std::uint64_t)>> costs{always(milliseconds{25}), always(milliseconds{57}),
                                                         always(milliseconds{1}), always(Nanos{0})};
  std::function<void(const std::string&)> on_notice;
  std::unique_ptr<Engine> engine;  // after `fake`: it goes first
};

TEST_F(TrackerTest, OnOneCoreRunsAsPlannedToTheNanosecond) {
  open("catan", 1, fake, in_frames(tracker_app()));
  const Snapshot snapshot = run_for(seconds{10});
  ASSERT_EQ(snapshot.chains.size(), 1U);
  const ChainSnapshot& chain = snapshot.chains[0];
  // L = 25 + 57 + 1, p = L / 0.94, response time = L + p.
  EXPECT_NEAR(chain.latency_ms.mean, 83.0, 1e-9);
  EXPECT_NEAR(chain.period_ms.mean, 83.0 / 0.94, 1e-5);
  EXPECT_NEAR(chain.response_ms.mean, 83.0 + 83.0 / 0.94, 1e-5);
  EXPECT_NEAR(chain.response_ms.max, chain.response_ms.mean, 1e-5);
  ASSERT_TRUE(chain.predicted_response_ms.has_value());
  EXPECT_NEAR(*chain.predicted_response_ms, chain.response_ms.mean, 1e-5);
  EXPECT_NEAR(snapshot.source_hz, 1000.0 * 0.94 / 83.0, 1e-6);
  EXPECT_TRUE(snapshot.real_time);
  EXPECT_TRUE(snapshot.notices.empty());
}

TEST_F(TrackerTest, OnTwoCoresOverlapsRunsAsPlanned) {
  open("catan", 2, fake, in_frames(tracker_app()));
  const Snapshot snapshot = run_for(seconds{10});
  const ChainSnapshot& chain = snapshot.chains[0];
  EXPECT_NEAR(chain.period_ms.mean, 57.0 / 0.94, 1e-5) << "the slowest node's, and idle time for ordinary threads";
  EXPECT_NEAR(chain.latency_ms.mean, 83.0, 1e-9);
  EXPECT_NEAR(*chain.predicted_response_ms, 83.0 + 57.0 / 0.94, 1e-5);
  EXPECT_NEAR(snapshot.source_hz, 940.0 / 57.0, 1e-6);
}

TEST_F(TrackerTest, FollowsACostThatGrows) {
  // detect: 57 ms at first, 114 ms from its 40th run on.
  costs[1] = [](std::uint64_t run) { return run < 40 ? milliseconds{57} : milliseconds{114}; };
  open("catan", 1, fake);
  const Snapshot snapshot = run_for(seconds{30});
  EXPECT_GT(snapshot.plans, 2U);
  EXPECT_NEAR(snapshot.chains[0].response_ms.p99, 140.0 + 140.0 / 0.94, 1.0);
  EXPECT_LT(snapshot.source_hz, 1000.0 / 88.0);
}

TEST_F(TrackerTest, DoesNotSwapPlansForNoise) {
  // Up to 1 ms around 57.
  costs[1] = [](std::uint64_t run) { return Nanos{57000000} + Nanos{static_cast<Nanos::rep>(run * 7919 % 1000000)}; };
  open("catan", 1, fake);
  const Snapshot snapshot = run_for(seconds{60});
  EXPECT_EQ(snapshot.plans, 2U) << "the bootstrap's and the measured one";
}

TEST_F(TrackerTest, HandSetRateTriggersWhateverTheRunsDo) {
  open("rate:10", 1, fake);
  const Snapshot snapshot = run_for(seconds{10});
  EXPECT_NEAR(snapshot.chains[0].period_ms.mean, 100.0, 1e-9);
  EXPECT_NEAR(snapshot.chains[0].response_ms.mean, 183.0, 1e-9);
  EXPECT_FALSE(snapshot.chains[0].predicted_response_ms.has_value());
  EXPECT_EQ(snapshot.source_hz, 10.0);
  EXPECT_FALSE(snapshot.real_time);
}

TEST_F(TrackerTest, DefaultTakesTheFallbackRateAndOrdinaryScheduling) {
  open("default", 2, fake);
  const Snapshot snapshot = run_for(seconds{5});
  EXPECT_NEAR(snapshot.source_hz, 30.0, 1e-6);
  for (const os::FakeOs::Change& change : fake.changes()) {
    EXPECT_TRUE(!change.level || *change.level == os::Level::kOrdinary);
  }
}

// The camera at 30 Hz, detect takes 57 ms: it never waits, and each of its runs takes the newest frame.
TEST_F(TrackerTest, DropsFramesThatComeTooFast) {
  open("default", 2, fake);
  const Snapshot snapshot = run_for(seconds{10});
  const std::vector<Taken>& camera = taken[0];
  const std::vector<Taken>& detect = taken[1];
  ASSERT_GT(detect.size(), 150U);
  for (std::size_t run = 0; run < detect.size(); ++run) {
    SCOPED_TRACE(run);
    EXPECT_EQ(detect[run].at, detect[0].at + run * milliseconds{57});
    std::size_t whole = 0;  // frames that were by then; one that is done in that very moment may count or not
    while (whole < camera.size() && camera[whole].at + milliseconds{25} < detect[run].at) ++whole;
    EXPECT_GE(detect[run].frame, static_cast<int>(whole));
    EXPECT_LE(camera[static_cast<std::size_t>(detect[run].frame) - 1].at + milliseconds{25}, detect[run].at);
  }
  const ChainSnapshot& chain = snapshot.chains[0];
  EXPECT_NEAR(chain.period_ms.mean, 57.0, 1e-6);
  EXPECT_NEAR(chain.period_ms.max, 57.0, 1e-6);
  EXPECT_LE(chain.latency_ms.max, 83.0 + 1000.0 / 30.0 + 1e-6) << "no frame is older than the next";
  // By its period and that of the frames (a third of a millisecond divides both), it finds them at every age alike.
  EXPECT_NEAR(chain.latency_ms.mean, 83.0 + 0.5 * 1000.0 / 30.0, 1.0);
}

TEST_F(TrackerTest, GivesLevelsWhileItRunsAndTakesThemBack) {
  open("catan", 1, fake);
  ASSERT_TRUE(engine->start().ok());
  fake.sleep_until(at(seconds{1}));
  int active = 0;
  int controllers = 0;
  const std::vector<os::ThreadId> threads = *fake.threads(fake.current_process());
  for (const os::ThreadId thread : threads) {
    active += *fake.level(thread) == os::Level::kActive ? 1 : 0;
    controllers += *fake.level(thread) == os::Level::kDispatcher ? 1 : 0;
  }
  EXPECT_EQ(active, 4);
  EXPECT_EQ(controllers, 1);
  ASSERT_TRUE(engine->stop().ok());
  std::map<os::ThreadId, os::Level> last;
  for (const os::FakeOs::Change& change : fake.changes()) {
    if (change.level) last[change.thread] = *change.level;
  }
  for (const auto& [thread, level] : last) EXPECT_EQ(level, os::Level::kOrdinary);
}

TEST_F(TrackerTest, AThreadThatIsAdoptedBeforeTheStartIsPlacedAtTheStart) {
  open("catan", 1, fake);
  const os::ThreadId self = fake.current_thread();
  ASSERT_TRUE(engine->adopt_this_thread("detect").ok());
  EXPECT_EQ(*fake.level(self), os::Level::kOrdinary);
  ASSERT_TRUE(engine->start().ok());
  fake.sleep_until(fake.now() + seconds{1});
  EXPECT_EQ(*fake.affinity(self), os::CpuSet{0});
  EXPECT_NE(*fake.level(self), os::Level::kOrdinary);
  ASSERT_TRUE(engine->stop().ok());
  EXPECT_EQ(*fake.level(self), os::Level::kOrdinary);
}

TEST_F(TrackerTest, WithoutThePermissionGoesOnWithRatesOnlyAndSaysSo) {
  fake.set_real_time_facts(
      {.permitted = false, .why_not = "no CAP_SYS_NICE", .reserved = 0.05, .reserved_by = "fair server"});
  open("catan", 1, fake, in_frames(tracker_app()));
  const Snapshot snapshot = run_for(seconds{10});
  EXPECT_FALSE(snapshot.real_time);
  ASSERT_EQ(snapshot.notices.size(), 1U);
  EXPECT_EQ(snapshot.notices[0], "rates-only: no CAP_SYS_NICE");
  EXPECT_NEAR(snapshot.chains[0].response_ms.mean, 83.0 + 83.0 / 0.94, 1e-5) << "the rates are planned all the same";
}

TEST_F(TrackerTest, SaysSoWhereWhatRunsWaitCannotBeMeasured) {
  fake.set_tells_ready_time(false);
  open("catan", 1, fake, in_frames(tracker_app()));
  const Snapshot snapshot = run_for(seconds{5});
  ASSERT_EQ(snapshot.notices.size(), 1U);
  EXPECT_TRUE(snapshot.notices[0].starts_with("waits-unknown: ")) << snapshot.notices[0];
}

TEST_F(TrackerTest, KeepsCpusReadyWhileItRunsAndOnlyWithRealTimeLevels) {
  open("catan", 1, fake);
  ASSERT_TRUE(engine->start().ok());
  EXPECT_EQ(fake.ready_cpus_held(), 1);
  ASSERT_TRUE(engine->stop().ok());
  EXPECT_EQ(fake.ready_cpus_held(), 0);
  open("default", 1, fake);
  ASSERT_TRUE(engine->start().ok());
  EXPECT_EQ(fake.ready_cpus_held(), 0);
}

TEST_F(TrackerTest, GoesOnAndSaysSoWhereCpusCannotBeKeptReady) {
  os::FaultyOs faulty(fake);
  open("catan", 1, faulty);
  faulty.fail_next(os::Call::kKeepCpusReady, 1, os::refused());
  const Snapshot snapshot = run_for(seconds{5});
  EXPECT_TRUE(snapshot.real_time);
  ASSERT_EQ(snapshot.notices.size(), 1U);
  EXPECT_TRUE(snapshot.notices[0].starts_with("idle-cpus: "));
  engine.reset();  // before `faulty`
}

TEST_F(TrackerTest, ARefusalHalfWayLowersWhatWasRaised) {
  os::FaultyOs faulty(fake);
  open("catan", 1, faulty);
  faulty.fail_next(os::Call::kSetLevel, 1, os::refused());
  const Snapshot snapshot = run_for(seconds{5});
  EXPECT_FALSE(snapshot.real_time);
  ASSERT_EQ(snapshot.notices.size(), 1U);
  EXPECT_TRUE(snapshot.notices[0].starts_with("rates-only: "));
  engine.reset();  // before `faulty`
}

// Guards: the thread waited for its own end.
TEST_F(TrackerTest, AFunctionThatItCallsCannotStopIt) {
  Status by_node = Done{};
  Status by_notice = Done{};
  costs[3] = [&](std::uint64_t) {
    by_node = engine->stop();
    return Nanos{0};
  };
  on_notice = [&](const std::string&) { by_notice = engine->stop(); };
  os::FaultyOs faulty(fake);
  open("catan", 1, faulty);
  faulty.fail_next(os::Call::kSetLevel, 1, os::refused());
  EXPECT_GT(run_for(seconds{5}).chains[0].response_ms.count, 10U) << "it goes on";
  ASSERT_FALSE(by_node.ok());
  EXPECT_EQ(by_node.error().kind(), ErrorKind::kCaller);
  ASSERT_FALSE(by_notice.ok());
  EXPECT_EQ(by_notice.error().message(), by_node.error().message());
  engine.reset();  // before `faulty`
}

TEST_F(TrackerTest, AHangingRunLosesItsLevelUntilItEnds) {
  costs[1] = [](std::uint64_t run) { return run == 60 ? Nanos{seconds{4}} : Nanos{milliseconds{57}}; };
  open("catan", 1, fake, in_frames(tracker_app()));
  const Snapshot snapshot = run_for(seconds{20});
  ASSERT_EQ(snapshot.notices.size(), 2U);
  EXPECT_TRUE(snapshot.notices[0].starts_with("watchdog: a run of subchain track hangs"));
  EXPECT_TRUE(snapshot.notices[1].starts_with("watchdog: the run of subchain track that hung has ended"));
  std::vector<os::Level> levels;
  for (const os::FakeOs::Change& change : fake.changes()) {
    if (change.level && change.at > at(seconds{4}) && change.at < at(seconds{19})) levels.push_back(*change.level);
  }
  ASSERT_EQ(levels.size(), 8U) << "four threads down and up again";
  EXPECT_EQ(levels.front(), os::Level::kOrdinary);
  EXPECT_EQ(levels.back(), os::Level::kActive);
}

TEST_F(TrackerTest, MistakesInTheWiringAreToldAllAtOnce) {
  Result<std::unique_ptr<Engine>> made = Engine::create(tracker_app(), fake, options("catan", 1));
  ASSERT_TRUE(made.ok());
  engine = std::move(*made);
  engine->wiring().set_body("camra", [](ctn::Run&) {});
  channel<int>(*engine, "camera", "plan");
  channel<int>(*engine, "camera", "detect");
  channel<double>(*engine, "camera", "detect");
  const Status started = engine->start();
  ASSERT_FALSE(started.ok());
  EXPECT_EQ(started.error().problems().size(), 7U) << started.error().message();  // and four nodes without a function
}

TEST_F(TrackerTest, ChannelsAreOnlyForTheirTwoNodesAndOthersAreTold) {
  Result<std::unique_ptr<Engine>> made = Engine::create(tracker_app(), fake, options("default", 1));
  ASSERT_TRUE(made.ok());
  engine = std::move(*made);
  Channel<int>& frames = channel<int>(*engine, "camera", "detect");
  Channel<int>& results = channel<int>(*engine, "detect", "plan");
  int read_by_others = 0;
  std::vector<int> seen;  // by the consumers
  engine->wiring().set_body("camera", [&](ctn::Run& run) {
    frames.write(run, 1);
    if (frames.read(run) != nullptr) ++read_by_others;
  });
  engine->wiring().set_body("detect", [&](ctn::Run& run) {
    if (const int* frame = frames.read(run)) seen.push_back(*frame);
    results.write(run, 2);
  });
  engine->wiring().set_body("plan", [&](ctn::Run& run) {
    if (const int* result = results.read(run)) seen.push_back(*result);
    frames.write(run, -1);  // told of no more than the camera's read
  });
  engine->wiring().set_body("motor", [&](ctn::Run& run) { results.write(run, -1); });
  const Snapshot snapshot = run_for(seconds{3});
  EXPECT_EQ(read_by_others, 0);
  ASSERT_GT(seen.size(), 100U);
  EXPECT_EQ(std::count(seen.begin(), seen.end(), -1), 0);
  EXPECT_THAT(snapshot.notices,
              testing::UnorderedElementsAre(
                  "channel-misuse: node camera reads from channel camera -> detect, which is not its own, and gets "
                  "nothing; only detect may read there",
                  "channel-misuse: node motor writes to channel detect -> plan, which is not its own, and nothing is "
                  "written; only detect may write there"));
}

TEST_F(TrackerTest, WhatIsWiredAfterTheStartChangesNothingAndIsTold) {
  open("catan", 1, fake);
  const Channel<int>* const frames = &channel<int>(*engine, "camera", "detect");
  ASSERT_TRUE(engine->start().ok());
  int strange_runs = 0;
  engine->wiring().set_body("camera", [&](ctn::Run&) { ++strange_runs; });
  channel<double>(*engine, "camera", "detect");
  channel<double>(*engine, "camera", "detect");  // told of once
  EXPECT_EQ(&channel<int>(*engine, "camera", "detect"), frames) << "what is there already may be asked for";
  fake.sleep_until(fake.now() + seconds{2});
  const Snapshot snapshot = engine->snapshot();
  const Status stopped = engine->stop();
  EXPECT_EQ(strange_runs, 0);
  EXPECT_GT(taken[0].size(), 10U);
  EXPECT_THAT(snapshot.notices,
              testing::ElementsAre(testing::StartsWith("too-late: node(\"camera\"): "),
                                   testing::StartsWith("too-late: channel(\"camera\", \"detect\"): ")));
  ASSERT_FALSE(stopped.ok());
  EXPECT_EQ(stopped.error().kind(), ErrorKind::kCaller);
  EXPECT_EQ(stopped.error().problems().size(), 2U) << stopped.error().message();
}

TEST_F(TrackerTest, WhereNoThreadCanBeMadeTheStartFailsAndNothingStays) {
  os::FaultyOs faulty(fake);
  on_notice = [](const std::string&) {};  // one thread more
  for (int made = 0;; ++made) {
    SCOPED_TRACE(made);
    open("catan", 1, faulty);
    if (made > 0) faulty.pass_next(os::Call::kSpawn, made);
    faulty.fail_next(os::Call::kSpawn, 1);
    const Status started = engine->start();
    if (started) {
      EXPECT_GE(made, 7) << "four nodes, a controller, housekeeping, notices";
      break;
    }
    EXPECT_EQ(started.error().kind(), ErrorKind::kEnvironment);
    EXPECT_THAT(started.error().message(), testing::HasSubstr("ulimit -u"));
    EXPECT_EQ(fake.threads(fake.current_process())->size(), 1U) << "this one";
    EXPECT_TRUE(engine->stop().ok());
  }
  EXPECT_TRUE(engine->stop().ok());
  engine.reset();  // it goes before `faulty`
}

TEST_F(TrackerTest, ACpuThatIsNotThereIsTheCallersMistake) {
  const auto made = Engine::create(tracker_app(), fake, options("catan", 3));
  ASSERT_FALSE(made.ok());
  EXPECT_EQ(made.error().kind(), ErrorKind::kCaller);
  EXPECT_EQ(made.error().message(), "CPU 2 is not online; choose from 0-1");
}

TEST_F(TrackerTest, SameInputsSameBytes) {
  std::set<double> means;
  for (int repetition = 0; repetition < 2; ++repetition) {
    os::FakeOs again;
    Result<std::unique_ptr<Engine>> made = Engine::create(tracker_app(), again, options("catan", 1));
    ASSERT_TRUE(made.ok());
    for (const char* name : {"camera", "detect", "plan", "motor"}) {
      (*made)->wiring().set_body(
          name, [&again](ctn::Run& run) { again.burn(milliseconds{1 + static_cast<int>(run.number() % 7)}); });
    }
    ASSERT_TRUE((*made)->start().ok());
    again.sleep_until(at(seconds{10}));
    means.insert((*made)->snapshot().chains[0].response_ms.mean);
    ASSERT_TRUE((*made)->stop().ok());
  }
  EXPECT_EQ(means.size(), 1U);
}

}  // namespace
}  // namespace ctn::runtime
