// Closed loops in virtual time through the public API, each worked by hand.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "catan/simulation.h"

namespace ctn {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;

// A point that is pushed: x' = u.
class Point {
 public:
  double at(nanoseconds now) {
    x_ += push_ * std::chrono::duration<double>(now - since_).count();
    since_ = now;
    return x_;
  }
  void push(nanoseconds now, double u) {
    at(now);
    push_ = u;
  }

 private:
  double x_ = 1.0;
  double push_ = 0.0;
  nanoseconds since_{0};
};

// look 2, think 6, push 2: every 20 ms, so a push comes 10 ms after the look that it goes back to.
const char* const kLoop = R"(
catan: 1
app: loop
nodes: { look: { fallback_rate: 50Hz }, think: {}, push: {} }
edges: [ look -> think -> push ]
subchains: { loop: [look, think, push] }
objective: [ { response_time: [look, think, push], weight: 1 } ]
scheduler: { slack: 0%, bootstrap: 1s }
)";
const char* const kCosts = "look: 2ms\nthink: 6ms\npush: 2ms\n";

class SimulationApi : public ::testing::Test {
 protected:
  SimulationApi() {
    write(app_, kLoop);
    write(costs_, kCosts);
  }
  ~SimulationApi() override {
    static_cast<void>(std::remove(app_.c_str()));
    static_cast<void>(std::remove(costs_.c_str()));
  }
  static void write(const std::string& path, const std::string& text) { std::ofstream(path) << text; }

  SimulationOptions options(const std::string& policy = "default") const {
    SimulationOptions options;
    options.costs = costs_;
    options.policy = policy;
    options.ideal = true;
    return options;
  }
  Result<Simulation> open(const std::string& policy = "default") const {
    return Simulation::open(app_, options(policy));
  }

  // Steers `point` to 0 with so much gain, and notes where it was at each look, and when.
  void steer(Simulation& simulation, double gain) {
    auto& seen = simulation.channel<double>("look", "think");
    auto& wanted = simulation.channel<double>("think", "push");
    simulation.node("look", [&](ctn::Run& run) {
      looked_.push_back(simulation.now());
      seen.write(run, point_.at(simulation.now()));
      positions_.push_back(point_.at(simulation.now()));
    });
    simulation.node("think", [&, gain](ctn::Run& run) {
      if (const double* x = seen.read(run)) wanted.write(run, -gain * *x);
    });
    simulation.node("push", [&](ctn::Run& run) {
      if (const double* u = wanted.read(run)) command_ = *u;
    });
    simulation.on_effect("push", [&](ctn::Run&) {
      pushed_.push_back(simulation.now());
      point_.push(simulation.now(), command_);
    });
  }

  std::string app_ = ::testing::TempDir() + "simulation_api_" + std::to_string(getpid()) + ".yaml";
  std::string costs_ = ::testing::TempDir() + "simulation_api_" + std::to_string(getpid()) + ".costs.yaml";
  Point point_;
  double command_ = 0.0;
  std::vector<double> positions_;
  std::vector<nanoseconds> looked_;
  std::vector<nanoseconds> pushed_;
};

// Between two looks the push before acts for 10 ms, the new one for 10 ms more:
// x[k+1] = x[k] - 0.01 g x[k-1] - 0.01 g x[k].
TEST_F(SimulationApi, AControllerSteersAPointWithTheDelayOfItsCosts) {
  auto simulation = open();
  ASSERT_TRUE(simulation.ok()) << simulation.error().message();
  constexpr double kGain = 20.0;
  steer(*simulation, kGain);
  ASSERT_TRUE(simulation->run_for(seconds{2}).ok());
  ASSERT_GE(positions_.size(), 99U);
  double before = 0.0;  // nothing is pushed before the first look
  double x = 1.0;
  for (std::size_t k = 0; k < positions_.size(); ++k) {
    ASSERT_NEAR(positions_[k], x, 1e-9) << "look " << k;
    const double next = x - 0.01 * kGain * before - 0.01 * kGain * x;
    before = x;
    x = next;
  }
  EXPECT_LT(std::abs(x), 1e-3) << "it gets there";
  for (std::size_t k = 0; k < pushed_.size(); ++k) EXPECT_EQ(pushed_[k] - looked_[k], milliseconds{10});
}

// The same controller on a machine about half as fast, where the delay is 19 ms, is too late for its gain:
// x[k+1] = x[k] - 0.019 g x[k-1] - 0.001 g x[k], whose poles have 0.019 g = 1.14 as the square of their size.
TEST_F(SimulationApi, AGainThatIsGoodOnOneMachineIsTooMuchForASlowerOne) {
  constexpr double kGain = 60.0;
  SimulationOptions slow = options();
  slow.slowdown = 1.9;
  for (const bool slower : {false, true}) {
    auto simulation = Simulation::open(app_, slower ? slow : options());
    ASSERT_TRUE(simulation.ok()) << simulation.error().message();
    point_ = Point();
    positions_.clear();
    looked_.clear();
    pushed_.clear();
    steer(*simulation, kGain);
    ASSERT_TRUE(simulation->run_for(seconds{1}).ok());
    EXPECT_EQ(pushed_.front() - looked_.front(), milliseconds{slower ? 19 : 10});
    if (slower) {
      EXPECT_GT(*std::max_element(positions_.begin(), positions_.end()), 5.0);
    } else {
      EXPECT_LT(std::abs(positions_.back()), 0.01);
    }
  }
}

TEST_F(SimulationApi, ASnapshotTellsWhatASessionWould) {
  write(app_, std::string(kLoop).replace(std::string(kLoop).find("bootstrap"), 0, "schedule: frames, "));
  auto simulation = open("catan");
  ASSERT_TRUE(simulation.ok()) << simulation.error().message();
  steer(*simulation, 1.0);
  EXPECT_FALSE(simulation->snapshot().warmed_up);
  ASSERT_TRUE(simulation->run_for(simulation->warm_from()).ok());
  ASSERT_TRUE(simulation->run_for(seconds{10}).ok());
  const Snapshot snapshot = simulation->snapshot();
  EXPECT_EQ(snapshot.policy, "catan");
  EXPECT_TRUE(snapshot.real_time);
  EXPECT_TRUE(snapshot.warmed_up);
  EXPECT_NEAR(snapshot.source_hz, 100.0, 0.01);
  EXPECT_GE(snapshot.plans, 2U);
  ASSERT_EQ(snapshot.chains.size(), 1U);
  EXPECT_EQ(snapshot.chains[0].path, (std::vector<std::string>{"look", "think", "push"}));
  EXPECT_NEAR(snapshot.chains[0].response_ms.mean, 20.0, 0.001) << "one after the other, 10 ms each";
  EXPECT_NEAR(*snapshot.chains[0].predicted_response_ms, 20.0, 0.001);
  ASSERT_EQ(snapshot.nodes.size(), 3U);
  EXPECT_NEAR(snapshot.nodes[1].compute_ms.mean, 6.0, 1e-9);
  EXPECT_NEAR(snapshot.nodes[1].rate_hz, 100.0, 0.2);
  EXPECT_EQ(simulation->now(), simulation->warm_from() + seconds{10});
}

// One core, all of it but the slack: L = 5 + 10, p = L / 0.94, response time = L + p, of each output alike.
TEST_F(SimulationApi, WhatIsPredictedIsWhatHappens) {
  write(app_, R"(
catan: 1
app: pair
nodes: { sense: { fallback_rate: 20Hz }, act: {} }
edges: [ sense -> act ]
subchains: { pair: [sense, act] }
objective: [ { response_time: [sense, act], weight: 1 } ]
scheduler: { bootstrap: 500ms, replan: 200ms, slack: 6%, schedule: frames }
)");
  write(costs_, "sense: 5ms\nact: 10ms\n");
  auto simulation = open("catan");
  ASSERT_TRUE(simulation.ok()) << simulation.error().message();
  ASSERT_TRUE(simulation->run_for(simulation->warm_from()).ok());
  ASSERT_TRUE(simulation->run_for(seconds{10}).ok());
  const ChainSnapshot chain = simulation->snapshot().chains[0];
  constexpr double kExact = 1e-5;  // times are whole nanoseconds
  ASSERT_TRUE(chain.predicted_response_ms);
  EXPECT_NEAR(*chain.predicted_response_ms, 15.0 + 15.0 / 0.94, kExact);
  EXPECT_NEAR(chain.response_ms.mean, *chain.predicted_response_ms, kExact);
  EXPECT_NEAR(chain.response_ms.max, *chain.predicted_response_ms, kExact);
  EXPECT_NEAR(chain.period_ms.max, 15.0 / 0.94, kExact);
  EXPECT_NEAR(chain.latency_ms.max, 15.0, kExact);
  EXPECT_NEAR(static_cast<double>(chain.response_ms.count), 10000.0 * 0.94 / 15.0, 2.0);
}

TEST_F(SimulationApi, ManyShortCallsComeToTheSameAsALongOne) {
  std::vector<std::vector<nanoseconds>> pushes;
  for (const nanoseconds step : {nanoseconds{milliseconds{3}}, nanoseconds{seconds{3}}}) {
    auto simulation = open("catan");
    ASSERT_TRUE(simulation.ok());
    pushed_.clear();
    steer(*simulation, 1.0);
    while (simulation->now() < seconds{3}) ASSERT_TRUE(simulation->run_for(step).ok());
    pushes.push_back(pushed_);
  }
  EXPECT_EQ(pushes[0], pushes[1]);
}

TEST_F(SimulationApi, SnapshotsSayWhatThoseOfASessionSay) {
  std::string text = kLoop;
  text.replace(text.find("think: {}"), 9, "think: { min_rate: 5Hz }");
  text.replace(text.find("weight: 1"), 9, "weight: 2, max: 400ms");
  write(app_, text);
  auto simulation = open("catan");
  ASSERT_TRUE(simulation.ok()) << simulation.error().message();
  const Snapshot before = simulation->snapshot();
  EXPECT_FALSE(before.warmed_up);
  EXPECT_TRUE(before.chains[0].predicted_response_ms.has_value()) << "by the plan of the bootstrap";
  ASSERT_TRUE(simulation->run_for(seconds{4}).ok());
  const Snapshot snapshot = simulation->snapshot();
  EXPECT_TRUE(snapshot.warmed_up);
  EXPECT_EQ(snapshot.cpus, std::vector<int>{0});
  ASSERT_EQ(snapshot.objective.size(), 1U);
  EXPECT_EQ(snapshot.objective[0].term, "look -> think -> push");
  EXPECT_EQ(snapshot.objective[0].weight, 2.0);
  EXPECT_EQ(snapshot.objective[0].max_ms, 400.0);
  EXPECT_FALSE(snapshot.nodes[0].min_rate_hz);
  EXPECT_EQ(snapshot.nodes[1].min_rate_hz, 5.0);
}

// A node without a function takes its time, and response times go through it.
TEST_F(SimulationApi, NodesNeedNoFunction) {
  auto simulation = open();
  ASSERT_TRUE(simulation.ok());
  std::uint64_t pushes = 0;
  simulation->on_effect("push", [&](ctn::Run& run) { pushes = run.number(); });
  ASSERT_TRUE(simulation->run_for(seconds{4}).ok());
  EXPECT_NEAR(simulation->snapshot().chains[0].response_ms.mean, 30.0, 0.001);
  EXPECT_NEAR(static_cast<double>(pushes), 200.0, 1.0);
}

// What the app file binds them to counts only where programs of ROS run them: there think would wait for look.
TEST_F(SimulationApi, FunctionsAreCalledAtEachTriggerWhateverHasCome) {
  write(app_, R"(
catan: 1
app: bound
nodes:
  look: { fallback_rate: 5Hz }
  think: { fallback_rate: 50Hz, ros: { node: /thinker, topic: /seen } }
edges: [ look -> think ]
objective: [ { response_time: [look, think], weight: 1 } ]
scheduler: { slack: 0%, bootstrap: 1s }
)");
  write(costs_, "look: 2ms\nthink: 2ms\n");
  auto simulation = open();
  ASSERT_TRUE(simulation.ok()) << simulation.error().message();
  int thoughts = 0;
  simulation->node("think", [&](ctn::Run&) { ++thoughts; });
  ASSERT_TRUE(simulation->run_for(seconds{4}).ok());
  EXPECT_NEAR(thoughts, 200, 2);
}

// Guards: what waited in a queue that was read by a function was counted as never read, and as lost after 4096 values.
TEST_F(SimulationApi, AQueueThatIsReadLosesNothing) {
  std::string text = kLoop;
  text.replace(text.find("think: {}"), 9, "think: { input: queue }");
  write(app_, text);
  auto simulation = open();
  ASSERT_TRUE(simulation.ok()) << simulation.error().message();
  auto& values = simulation->queue<int>("look", "think");
  int taken = 0;
  simulation->node("look", [&](ctn::Run& run) {
    for (int i = 0; i < 100; ++i) values.write(run, i);
  });
  simulation->node("think", [&](ctn::Run& run) {
    while (values.take(run)) ++taken;
  });
  ASSERT_TRUE(simulation->run_for(seconds{100}).ok());
  EXPECT_GE(taken, 499'000);
  EXPECT_TRUE(simulation->snapshot().notices.empty());
}

// Run k of think is worth k ms, of look 2 and of push 2: what the file says of push alone.
TEST_F(SimulationApi, RunsThatAreChargedCostThatAndNeedNoCostFile) {
  write(costs_, "push: 2ms\n");
  for (const double slowdown : {1.0, 1.5}) {
    SimulationOptions chosen = options();
    chosen.slowdown = slowdown;
    auto simulation = Simulation::open(app_, chosen);
    ASSERT_TRUE(simulation.ok()) << simulation.error().message();
    std::vector<nanoseconds> looks;
    std::vector<nanoseconds> pushes;
    simulation->node("look", [&](ctn::Run& run) {
      looks.push_back(simulation->now());
      run.charge(milliseconds{2});
    });
    simulation->node("think", [&](ctn::Run& run) { run.charge(milliseconds{1} * run.number()); });
    simulation->on_effect("push", [&](ctn::Run&) { pushes.push_back(simulation->now()); });
    ASSERT_TRUE(simulation->run_for(milliseconds{100}).ok());
    ASSERT_GE(pushes.size(), 4U);
    for (std::size_t k = 0; k < 4; ++k) {
      EXPECT_EQ(pushes[k] - looks[k],
                nanoseconds{static_cast<std::int64_t>(slowdown * 1e6 * (5.0 + 1.0 * static_cast<double>(k)))});
    }
  }
  SimulationOptions without = options();
  without.costs.clear();
  auto simulation = Simulation::open(app_, without);
  ASSERT_TRUE(simulation.ok()) << simulation.error().message();
  for (const char* const node : {"look", "think", "push"}) {
    simulation->node(node, [](ctn::Run& run) { run.charge(milliseconds{3}); });
  }
  ASSERT_TRUE(simulation->run_for(seconds{4}).ok());
  EXPECT_NEAR(simulation->snapshot().chains[0].latency_ms.mean, 9.0, 1e-9);
}

// think is charged k ms, the others' costs are in the file: each times what is said of all, times what of it alone.
TEST_F(SimulationApi, NodesAreSlowedEachByItself) {
  write(costs_, "look: 2ms\npush: 2ms\n");
  SimulationOptions chosen = options();
  chosen.slowdown = 1.5;
  chosen.slowdowns = {{"think", 0.5}, {"push", 3.0}};
  auto simulation = Simulation::open(app_, chosen);
  ASSERT_TRUE(simulation.ok()) << simulation.error().message();
  std::vector<nanoseconds> looks;
  std::vector<nanoseconds> pushes;
  simulation->node("look", [&](ctn::Run&) { looks.push_back(simulation->now()); });
  simulation->node("think", [&](ctn::Run& run) {
    run.charge(milliseconds{1});
    run.charge(milliseconds{1} * (run.number() - 1));
    EXPECT_EQ(run.charged(), milliseconds{1} * run.number()) << "what is charged is not what it costs";
  });
  simulation->on_effect("push", [&](ctn::Run&) { pushes.push_back(simulation->now()); });
  ASSERT_TRUE(simulation->run_for(milliseconds{200}).ok());
  ASSERT_GE(pushes.size(), 4U);
  for (std::size_t k = 0; k < 4; ++k) {
    EXPECT_EQ(pushes[k] - looks[k],
              nanoseconds{static_cast<std::int64_t>(1e6 * (3.0 + 0.75 * static_cast<double>(k + 1) + 9.0))});
  }
}

TEST_F(SimulationApi, NodesOfWhichNothingSaysWhatTheyCostAreNamed) {
  write(costs_, "look: 2ms\n");
  auto simulation = open();
  ASSERT_TRUE(simulation.ok()) << simulation.error().message();
  const Status without_functions = simulation->run_for(seconds{1});
  ASSERT_FALSE(without_functions.ok());
  EXPECT_EQ(without_functions.error().problems().size(), 2U) << without_functions.error().message();
  EXPECT_EQ(simulation->now(), nanoseconds{0});
  simulation->node("think", [](ctn::Run&) {});
  simulation->node("push", [](ctn::Run& run) { run.charge(milliseconds{1}); });
  for (int call = 0; call < 2; ++call) {
    const Status uncharged = simulation->run_for(seconds{1});
    ASSERT_FALSE(uncharged.ok());
    EXPECT_EQ(uncharged.error().kind(), ErrorKind::kCaller);
    EXPECT_NE(uncharged.error().message().find("node think"), std::string::npos) << uncharged.error().message();
    EXPECT_EQ(simulation->now(), nanoseconds{milliseconds{2}}) << "its first run begins then";
  }
}

TEST_F(SimulationApi, MistakesAreToldAllAtOnce) {
  auto simulation = open();
  ASSERT_TRUE(simulation.ok());
  simulation->node("nobody", [](ctn::Run&) {});
  simulation->node("look", [](ctn::Run&) {});
  simulation->node("look", [](ctn::Run&) {});
  simulation->on_effect("push", nullptr);
  simulation->channel<int>("look", "push");
  simulation->queue<int>("look", "think");
  const Status ran = simulation->run_for(seconds{1});
  ASSERT_FALSE(ran.ok());
  EXPECT_EQ(ran.error().kind(), ErrorKind::kCaller);
  EXPECT_EQ(ran.error().problems().size(), 5U) << ran.error().message();
  EXPECT_EQ(simulation->now(), nanoseconds{0});
}

TEST_F(SimulationApi, AChannelIsOnlyForItsTwoNodes) {
  auto simulation = open();
  ASSERT_TRUE(simulation.ok());
  auto& seen = simulation->channel<double>("look", "think");
  simulation->node("look", [&](ctn::Run& run) { seen.write(run, 1.0); });
  bool misled = false;
  simulation->node("think", [&](ctn::Run& run) {
    const double* x = seen.read(run);
    misled = misled || (x != nullptr && *x != 1.0);
  });
  simulation->node("push", [&](ctn::Run& run) { seen.write(run, 2.0); });
  const Status ran = simulation->run_for(seconds{1});
  EXPECT_FALSE(misled);
  ASSERT_FALSE(ran.ok());
  EXPECT_EQ(ran.error().kind(), ErrorKind::kCaller);
  EXPECT_THAT(ran.error().message(),
              testing::HasSubstr("node push writes to channel look -> think, which is not its own"));
}

TEST_F(SimulationApi, TimeGoesOnlyForwardAndOnlyFromOutside) {
  auto simulation = open();
  ASSERT_TRUE(simulation.ok());
  EXPECT_FALSE(simulation->run_for(nanoseconds{-1}).ok());
  bool refused = false;
  simulation->node("look", [&](ctn::Run&) { refused = !simulation->run_for(seconds{1}).ok(); });
  ASSERT_TRUE(simulation->run_for(seconds{1}).ok());
  EXPECT_TRUE(refused);
  simulation->node("think", [](ctn::Run&) {});
  EXPECT_FALSE(simulation->run_for(seconds{1}).ok()) << "too late for another function";
}

// The sensor's samples are taken 2 ms after each begin of look, the display ticks 3 ms after: what look has at 8 ms is
// of 2 ms, and is shown at 11 ms.
TEST_F(SimulationApi, ClocksTickAsTheyAreSaidTo) {
  write(app_, R"(
catan: 1
app: clocks
nodes: { sensor: { unscheduled: true, period: 7ms }, look: { fallback_rate: 125Hz }, display: { external: true, period: 7ms } }
edges: [ sensor -> look -> display ]
objective: [ { response_time: [sensor, look, display], weight: 1 } ]
scheduler: { slack: 0%, bootstrap: 1s }
)");
  write(costs_, "sensor: 0ms\nlook: 2ms\n");
  SimulationOptions chosen = options();
  chosen.clocks = {{"display", milliseconds{3}, milliseconds{8}}, {"sensor", milliseconds{2}, milliseconds{8}}};
  auto simulation = Simulation::open(app_, chosen);
  ASSERT_TRUE(simulation.ok()) << simulation.error().message();
  std::vector<nanoseconds> samples;
  simulation->node("sensor", [&](ctn::Run&) { samples.push_back(simulation->now()); });
  ASSERT_TRUE(simulation->run_for(seconds{4}).ok());
  ASSERT_GT(samples.size(), 3U);
  for (std::size_t k = 0; k < samples.size(); ++k) {
    ASSERT_EQ(samples[k], milliseconds{2} + k * milliseconds{8}) << "sample " << k;
  }
  const ChainSnapshot chain = simulation->snapshot().chains[0];
  EXPECT_NEAR(chain.latency_ms.mean, 9.0, 1e-9);
  EXPECT_NEAR(chain.response_ms.mean, 17.0, 1e-9);
}

TEST_F(SimulationApi, OpenRefusesClocksThatCannotBe) {
  write(app_, R"(
catan: 1
app: clocks
nodes: { sensor: { unscheduled: true, period: 7ms }, look: { fallback_rate: 125Hz }, motor: { external: true } }
edges: [ sensor -> look -> motor ]
objective: [ { response_time: [sensor, look, motor], weight: 1 } ]
)");
  write(costs_, "sensor: 0ms\nlook: 2ms\n");
  SimulationOptions chosen = options();
  const SimulatedClock sensor{"sensor", milliseconds{2}, milliseconds{8}};
  chosen.clocks = {{"motor", {}, milliseconds{8}}, {"nobody", {}, milliseconds{8}}, sensor, sensor};
  const auto refused = Simulation::open(app_, chosen);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().kind(), ErrorKind::kCaller);
  EXPECT_EQ(refused.error().problems().size(), 3U) << refused.error().message();
  for (const SimulatedClock& wrong :
       {SimulatedClock{"sensor", milliseconds{-1}, milliseconds{8}}, SimulatedClock{"sensor", {}, nanoseconds{0}}}) {
    chosen.clocks = {wrong};
    EXPECT_FALSE(Simulation::open(app_, chosen).ok());
  }
}

TEST_F(SimulationApi, OpenRefusesWhatCannotBe) {
  const auto refused = [&](auto change) {
    SimulationOptions changed = options();
    change(changed);
    const auto simulation = Simulation::open(app_, changed);
    return !simulation.ok() && simulation.error().kind() == ErrorKind::kCaller;
  };
  EXPECT_TRUE(refused([](SimulationOptions& o) { o.costs = "no_such_file.yaml"; }));
  EXPECT_TRUE(refused([](SimulationOptions& o) { o.policy = "fastest"; }));
  EXPECT_TRUE(refused([](SimulationOptions& o) { o.cores = -1; }));
  EXPECT_TRUE(refused([](SimulationOptions& o) { o.cores = 1000; }));
  EXPECT_TRUE(refused([](SimulationOptions& o) { o.slowdown = 0.0; }));
  EXPECT_TRUE(refused([](SimulationOptions& o) { o.slowdown = std::nan(""); }));
  EXPECT_TRUE(refused([](SimulationOptions& o) { o.slowdowns = {{"think", -1.0}}; }));
  EXPECT_TRUE(refused([](SimulationOptions& o) { o.slowdowns = {{"nothing", 1.0}}; }));
  EXPECT_FALSE(refused([](SimulationOptions&) {}));
}

}  // namespace
}  // namespace ctn
