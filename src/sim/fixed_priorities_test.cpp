// Subchains with fixed priorities on one core, each worked by hand, on a machine where scheduling costs nothing.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "config/testing/apps.h"
#include "graph/build.h"
#include "graph/testing/spec_text.h"
#include "policy/testing/given_places.h"
#include "record/reader.h"
#include "sim/json.h"
#include "sim/simulation.h"

namespace ctn::sim {
namespace {

using policy::place_after;
using policy::place_by_phase;
using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::seconds;
using testing::ElementsAre;

constexpr Nanos kPriorityRun = seconds{2};

// a leads, b follows, c is by itself.
graph::App three_priorities() {
  return parse(R"(
catan: 1
app: priorities
nodes: { a: {}, b: {}, c: {} }
edges: [ a -> b ]
objective:
  - { response_time: [a], weight: 1 }
  - { response_time: [b], weight: 1 }
  - { response_time: [c], weight: 1 }
scheduler: { bootstrap: 100ms }
)");
}

SubchainId subchain_of(const graph::App& app, const char* name) { return *app.graph.find_subchain(name); }

// By NodeId; every `long_every`-th run of a takes `long_run`.
class PriorityCosts : public RunCosts {
 public:
  PriorityCosts(std::vector<Nanos> costs, std::uint64_t long_every, Nanos long_run)
      : costs_(std::move(costs)), long_every_(long_every), long_run_(long_run) {}
  int threads_used(NodeId /*node*/, int /*most*/) const override { return 1; }
  model::RunDraw draw(NodeId node, std::uint64_t number, Nanos /*since_start*/, int /*threads*/,
                      std::size_t /*kind*/) override {
    if (node.index() == 0 && long_every_ > 0 && number % long_every_ == 0) return {.cpu = long_run_};
    return {.cpu = costs_[node.index()]};
  }

 private:
  std::vector<Nanos> costs_;
  std::uint64_t long_every_;
  Nanos long_run_;
};

struct Recorded {
  Outcome outcome;
  std::vector<std::vector<record::Trigger>> triggers;  // by subchain
  std::vector<std::vector<TimePoint>> ends;            // by node
  std::vector<record::Overrun> overruns;

  // From when it was due until its run had ended, at most.
  Nanos longest(std::size_t subchain) const {
    Nanos longest{0};
    for (std::size_t k = 0; k < ends[subchain].size(); ++k) {
      longest = std::max(longest, ends[subchain][k] - triggers[subchain][k].due);
    }
    return longest;
  }
};

Recorded run_priorities(const graph::App& app, std::vector<policy::SubchainPlace> places,
                        std::unique_ptr<RunCosts> costs) {
  const std::string path = testing::TempDir() + fmt::format("simulated_priorities_{}.catan", ::getpid());
  std::remove(path.c_str());
  Options options{.policy = std::make_shared<policy::GivenPlaces>(std::move(places))};
  options.machine.costs = MachineCosts::none();
  options.machine.limit.reset();
  options.recording = {.path = path, .note = {}};
  Recorded recorded;
  recorded.outcome = *simulate(app, std::move(costs), options, kPriorityRun);
  const Result<record::Reader> reader = record::Reader::open(path);
  EXPECT_TRUE(reader.ok()) << (reader ? "" : reader.error().message());
  recorded.triggers.resize(app.graph.subchains().size());
  recorded.ends.resize(app.graph.nodes().size());
  EXPECT_TRUE(reader
                  ->each_trigger([&](const record::Trigger& trigger) {
                    recorded.triggers[trigger.subchain.index()].push_back(trigger);
                  })
                  .ok());
  EXPECT_TRUE(
      reader->each_run([&](const record::Run& run) { recorded.ends[run.node.index()].push_back(run.end); }).ok());
  EXPECT_TRUE(reader->each_overrun([&](const record::Overrun& overrun) { recorded.overruns.push_back(overrun); }).ok());
  std::remove(path.c_str());
  return recorded;
}

std::vector<double> first_due_times(const std::vector<record::Trigger>& triggers) {
  std::vector<double> times;
  for (const record::Trigger& trigger : triggers) {
    EXPECT_EQ(trigger.sent, trigger.due) << "nothing delays it here";
    if (times.size() < 4) times.push_back(to_millis(trigger.due - TimePoint{}).count());
  }
  return times;
}

// a: 3 of every 10 ms; b: 4 ms after every second output of a; c: 6 of every 20 ms, from 5 on, below both.
TEST(FixedPriorities, TriggersComeAtTheirPhasesAndWithOutputs) {
  const graph::App app = three_priorities();
  const SubchainId a = subchain_of(app, "a");
  const Recorded run =
      run_priorities(app,
                     {place_by_phase(2, 0, milliseconds{10}, Nanos{0}), place_after(1, 0, a, 2, milliseconds{20}),
                      place_by_phase(0, 0, milliseconds{20}, milliseconds{5})},
                     std::make_unique<PriorityCosts>(
                         std::vector<Nanos>{milliseconds{3}, milliseconds{4}, milliseconds{6}}, 0, Nanos{}));
  EXPECT_THAT(first_due_times(run.triggers[0]), ElementsAre(0, 10, 20, 30));
  EXPECT_THAT(first_due_times(run.triggers[1]), ElementsAre(13, 33, 53, 73));
  EXPECT_THAT(first_due_times(run.triggers[2]), ElementsAre(5, 25, 45, 65));
  EXPECT_EQ(run.longest(0), milliseconds{3});
  EXPECT_EQ(run.longest(1), milliseconds{4});
  EXPECT_EQ(run.longest(2), milliseconds{13}) << "5 to 10 and, after a and b, from 17 to 18";
  EXPECT_EQ(run.outcome.budget_overruns, 0U);
  EXPECT_EQ(to_json({{1, run.outcome}}, 1).find("budget_overruns"), std::string::npos);
}

graph::App exclusive_priorities() {
  return parse(R"(
catan: 1
app: exclusive
nodes: { a: {}, b: {}, c: {} }
exclusive: { spinner: [a, c] }
objective:
  - { response_time: [a], weight: 1 }
  - { response_time: [b], weight: 1 }
  - { response_time: [c], weight: 1 }
scheduler: { bootstrap: 100ms }
)");
}

// c is under way when a wants to run: it goes on at a's level, above b, and a comes after it. c: 0 to 5 (it is
// pre-empted by b for none of that), a: 5 to 7, b: 1 to 11.
TEST(FixedPriorities, RunsOfAnExclusiveGroupDoNotOverlapAndOneThatIsWaitedForIsRaised) {
  const graph::App app = exclusive_priorities();
  const Recorded run = run_priorities(
      app,
      {place_by_phase(2, 0, milliseconds{20}, milliseconds{2}), place_by_phase(1, 0, milliseconds{20}, milliseconds{1}),
       place_by_phase(0, 0, milliseconds{20}, Nanos{0})},
      std::make_unique<PriorityCosts>(std::vector<Nanos>{milliseconds{2}, milliseconds{5}, milliseconds{4}}, 0,
                                      Nanos{}));
  EXPECT_EQ(run.longest(2), milliseconds{5}) << "b had one of it, before a came";
  EXPECT_EQ(run.longest(0), milliseconds{5}) << "3 for c";
  EXPECT_EQ(run.longest(1), milliseconds{10});
}

TEST(FixedPriorities, RunsOfAnExclusiveGroupDoNotOverlapOnTwoCores) {
  const graph::App app = exclusive_priorities();
  const Recorded run = run_priorities(
      app,
      {place_by_phase(2, 0, milliseconds{10}, milliseconds{1}), place_by_phase(1, 0, milliseconds{20}, Nanos{0}),
       place_by_phase(1, 1, milliseconds{10}, Nanos{0})},
      std::make_unique<PriorityCosts>(std::vector<Nanos>{milliseconds{2}, microseconds{1}, milliseconds{4}}, 0,
                                      Nanos{}));
  EXPECT_EQ(run.longest(2), milliseconds{4});
  EXPECT_EQ(run.longest(0), milliseconds{5}) << "from 1 to 4 it waits";
}

// c has 8 of every 20 ms below a, which has 3 of every 10 ms and now and then takes 9.
TEST(FixedPriorities, ALowerOneIsProtectedByTheBudgetOfAHigherOne) {
  const graph::App app = three_priorities();
  const auto longest = [&](Nanos budget, std::uint64_t& overruns) {
    const Recorded run =
        run_priorities(app,
                       {place_by_phase(2, 0, milliseconds{10}, Nanos{0}, budget),
                        place_after(0, 0, subchain_of(app, "a"), 1000, milliseconds{20}),
                        place_by_phase(1, 0, milliseconds{20}, Nanos{0})},
                       std::make_unique<PriorityCosts>(
                           std::vector<Nanos>{milliseconds{3}, microseconds{1}, milliseconds{8}}, 5, milliseconds{9}));
    overruns = run.overruns.size();
    for (const record::Overrun& overrun : run.overruns) {
      EXPECT_EQ(overrun.subchain, subchain_of(app, "a"));
      EXPECT_EQ(overrun.cpu, budget + dispatch::kBudgetGrain);
      EXPECT_EQ(overrun.number % 5, 0U) << "only runs that exceed it are demoted";
    }
    return run.longest(2);
  };
  std::uint64_t overruns = 0;
  const Nanos promised = 2 * (milliseconds{3} + dispatch::kBudgetGrain) + milliseconds{8};
  EXPECT_LE(longest(milliseconds{3}, overruns), promised);
  EXPECT_GE(overruns, 35U) << "a fifth of 200 runs, or nearly: those that it delays come later";
  EXPECT_GT(longest(Nanos{0}, overruns), promised) << "without a budget the promise would be broken";
  EXPECT_EQ(overruns, 0U);
}

// The leader gives no output after its 20th run.
TEST(FixedPriorities, AFollowerOfASilentLeaderIsTriggeredAllTheSame) {
  const graph::App app = three_priorities();
  Options options{.policy = std::make_shared<policy::GivenPlaces>(
                      std::vector<policy::SubchainPlace>{place_by_phase(2, 0, milliseconds{10}, Nanos{0}),
                                                         place_after(1, 0, subchain_of(app, "a"), 1, milliseconds{10}),
                                                         place_by_phase(0, 0, milliseconds{20}, milliseconds{5})})};
  options.machine.costs = MachineCosts::none();
  auto made = Simulation::create(app,
                                 std::make_unique<PriorityCosts>(
                                     std::vector<Nanos>{milliseconds{3}, milliseconds{4}, milliseconds{6}}, 0, Nanos{}),
                                 options);
  ASSERT_TRUE(made.ok()) << made.error().message();
  Simulation& simulation = **made;
  std::vector<TimePoint> began;
  simulation.set_body(*app.graph.find_node("a"), [](ctn::Run& run) {
    if (run.number() > 20) run.skip_output();
  });
  simulation.set_body(*app.graph.find_node("b"), [&](ctn::Run&) { began.push_back(simulation.now()); });
  simulation.run_for(seconds{4});
  ASSERT_EQ(began.size(), 20U + 281U);
  EXPECT_EQ(began[19] - TimePoint{}, milliseconds{193});
  EXPECT_EQ(began[20] - began[19], seconds{1}) << "a second later, and then every period";
  EXPECT_EQ(began[21] - began[20], milliseconds{10});
}

// A sensor whose clock is slow by as much as 1000 ppm slides through all phases of a subchain that reads it by time, in
// seconds.
TEST(FixedPriorities, WhoIsTriggeredByArrivalFollowsAClockThatDrifts) {
  graph::AppSpec spec = graph::spec_of({"sensor", "read"}, {"sensor read"});
  graph::node(spec, "sensor").unscheduled = true;
  graph::node(spec, "sensor").period = graph::At<Nanos>{milliseconds{5}, {}};
  spec.objective = {graph::response("sensor read", 1.0)};
  const graph::App app = graph::build_app(spec).value();
  const auto response = [&](const policy::SubchainPlace& place) {
    Options options{.policy = std::make_shared<policy::GivenPlaces>(std::vector<policy::SubchainPlace>{place})};
    options.machine.costs = MachineCosts::none();
    options.clocks = {.seed = 3, .drift_ppm = 1000.0};
    auto outcome = simulate(
        app, std::make_unique<PriorityCosts>(std::vector<Nanos>{microseconds{100}, milliseconds{1}}, 0, Nanos{0}),
        options, seconds{30});
    EXPECT_TRUE(outcome.ok());
    return outcome->chains.front().response_ms;
  };
  const Nanos period = draw_clocks(app.graph, {.seed = 3, .drift_ppm = 1000.0}).timers.front().period;
  ASSERT_GT(std::abs((period - Nanos{milliseconds{5}}).count()), 1000) << "a clock that is off";
  const double at_once = to_millis(period).count() + 0.1 + 1.0;
  const Summary arrival = response(policy::place_after(0, 0, NodeId(std::size_t{0}), 1, milliseconds{5}));
  EXPECT_NEAR(arrival.mean, at_once, 1e-6);
  EXPECT_NEAR(arrival.max, at_once, 1e-6);
  const Summary by_time = response(policy::place_by_phase(0, 0, milliseconds{5}, Nanos{0}));
  EXPECT_GT(by_time.mean, at_once + 1.0);
  EXPECT_GT(by_time.max, at_once + 4.5);
}

}  // namespace
}  // namespace ctn::sim
