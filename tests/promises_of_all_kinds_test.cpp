// Promises of apps of kinds that are seldom: unscheduled nodes in exclusive groups, runs that wait on several cores,
// queue nodes in frames, outputs that come less often than runs. At constant costs no response of a chain takes longer
// than is promised.
#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <optional>
#include <random>
#include <vector>

#include "base/mixed.h"
#include "graph/build.h"
#include "graph/testing/spec_text.h"
#include "longest_in_trials.h"
#include "model/formulas.h"
#include "paper/paper.h"
#include "plan/predict.h"
#include "plan/validate.h"
#include "planner/pipelines.h"
#include "planner/promised.h"
#include "planner/testing/random_apps.h"
#include "trial/schedule.h"

namespace ctn {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

// How many chains have so many responses in the horizon; none of these takes longer than is promised.
int held_chains(const planner::RandomCase& of, const trial::Samples& samples, const plan::Plan& plan,
                const trial::Schedule& schedule, Nanos horizon, int min_count, std::uint64_t seed) {
  const auto seen = longest_in(of.app, samples, schedule, horizon);
  int compared = 0;
  for (std::size_t chain = 0; chain < plan.chains.size(); ++chain) {
    const Longest& found = seen->metrics().chains()[chain].response;
    if (found.count < min_count) continue;
    EXPECT_LE(to_millis(found.longest).count(), plan.chains[chain].response.count() + 1e-3)
        << "seed " << seed << ": " << of.app.graph.path_name(plan.chains[chain].path);
    ++compared;
  }
  return compared;
}

// Unscheduled nodes have the first three cores to themselves, since what load they are is in no promise. All subchains
// are in their exclusive group, on one core, or one is, and each has a core of its own.
TEST(PromisesOfAllKinds, HoldWhereUnscheduledNodesAreInExclusiveGroups) {
  int compared = 0;
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    const planner::RandomCase of =
        planner::random_case(seed, {.subchains = 3, .waits = seed % 3 == 0, .exclusive = true, .drivers = 2}, 6);
    std::mt19937_64 random(seed);
    const auto uniform = [&](double low, double high) { return low + (high - low) * fraction_of(random()); };
    trial::Schedule schedule{.cores = 6, .subchains = {}, .frames = {}, .pipelines = {}};
    const bool together = of.app.joined_by_exclusion().back().size() > 1;
    for (int i = 0; i < 3; ++i) {
      const Nanos period = to_nanos(Millis{uniform(20.0, 100.0)});
      schedule.subchains.push_back({.core = together ? 3 : 3 + i,
                                    .priority = 3 - i,
                                    .period = period,
                                    .phase = to_nanos(to_millis(period) * uniform(0.0, 0.999))});
    }
    const trial::Samples samples = constant(of.app, of.costs);
    const auto plan = planner::plan_of(of.app, samples, of.costs, schedule, 0.0);
    if (!plan) continue;
    compared += held_chains(of, samples, *plan, schedule, seconds{60}, 100, seed);
  }
  EXPECT_GT(compared, 500) << "or nothing was tested";
}

// Drivers come often, and have no cores of their own: they are above all subchains, wherever these are.
TEST(PromisesOfAllKinds, HoldBesideUnscheduledNodesOnTheSameCores) {
  int compared = 0;
  for (std::uint64_t seed = 1; seed <= 400; ++seed) {
    const int cores = 1 + static_cast<int>(seed % 3);
    planner::RandomLimits limits{.subchains = 3, .pairs = true, .waits = seed % 4 == 0};
    limits.exclusive = seed % 5 < 2;
    limits.drivers = 1 + static_cast<int>(seed % 2);
    limits.driver_periods = seed % 11 < 8 ? 3.0 : 20.0;
    limits.output_periods = seed % 7 == 0;
    const planner::RandomCase of = planner::random_case(seed, limits, cores);
    std::mt19937_64 random(seed);
    const auto uniform = [&](double low, double high) { return low + (high - low) * fraction_of(random()); };
    trial::Schedule schedule{.cores = cores, .subchains = {}, .frames = {}, .pipelines = {}};
    const bool together = limits.exclusive && of.app.joined_by_exclusion().back().size() > 1;
    for (int i = 0; i < 3; ++i) {
      const Nanos period = to_nanos(Millis{uniform(20.0, 100.0)});
      trial::Place place{.core = together ? 0 : i % cores,
                         .priority = 3 - i,
                         .period = period,
                         .phase = to_nanos(to_millis(period) * uniform(0.0, 0.999))};
      for (const NodeId predecessor : of.app.graph.node(of.app.graph.subchain(SubchainId(i)).head()).predecessors) {
        const graph::Node& given = of.app.graph.node(predecessor);
        if (!given.unscheduled || random() % 2 == 0) continue;
        place.after = plan::After{predecessor, 1 + static_cast<int>(random() % 2)};
        place.period = place.after->every * given.outputs_apart() * static_cast<int>(1 + random() % 9) / 10;
        place.phase = Nanos{0};
      }
      schedule.subchains.push_back(place);
    }
    const trial::Samples samples = constant(of.app, of.costs);
    const auto plan = planner::plan_of(of.app, samples, of.costs, schedule, 0.0);
    if (!plan) continue;
    compared += held_chains(of, samples, *plan, schedule, seconds{60}, 100, seed);
  }
  EXPECT_GT(compared, 500) << "or nothing was tested";
}

TEST(PromisesOfAllKinds, HoldOnSeveralCoresWithThreadsAndWaits) {
  int compared = 0;
  int overlapping = 0;
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    const int cores = 2 + static_cast<int>(seed % 4);
    const planner::RandomCase of =
        planner::random_case(seed, {.subchains = 2, .pairs = true, .waits = true, .threads = true}, cores + 1);
    const trial::Samples samples = constant(of.app, of.costs);
    const planner::Pipelines pipelines(of.app, samples, of.costs, 0.0);
    std::vector<int> own;
    for (int core = 0; core < cores; ++core) own.push_back(core);
    const std::optional<trial::Pipeline> pipeline = pipelines.on(SubchainId(0), own);
    ASSERT_TRUE(pipeline);
    overlapping += pipeline->pacing.max_in_flight > 1 ? 1 : 0;
    trial::Schedule schedule{.cores = cores + 1, .subchains = {}, .frames = {}, .pipelines = {*pipeline}};
    schedule.subchains.push_back({.form = trial::Form::kPipeline, .core = 0});
    schedule.subchains.push_back({.core = cores, .period = milliseconds{7 + static_cast<int>(seed % 13)}});
    const auto plan = planner::plan_of(of.app, samples, of.costs, schedule, 0.0);
    if (!plan) continue;
    compared += held_chains(of, samples, *plan, schedule, seconds{20}, 100, seed);
  }
  EXPECT_GT(compared, 200) << "or nothing was tested";
  EXPECT_GT(overlapping, 50) << "or nothing was tested";
}

// By the paper's planner, which makes all plans in frames.
TEST(PromisesOfAllKinds, HoldForQueueNodesInFrames) {
  int compared = 0;
  int bursts = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    planner::RandomLimits limits{.subchains = 3, .min_cost = 0.5, .max_cost = 30.0, .queue = true};
    // In elastic frames, a rate cap may defer a run by a tenth of its period.
    limits.caps = seed % 6 == 0;
    limits.pairs = true;
    limits.waits = seed % 5 == 0;
    const planner::RandomCase of = planner::random_case(seed, limits, 1);
    const graph::App app = seed % 2 == 0 ? paper::as_in_the_paper(of.app) : of.app;
    const Result<plan::Plan> plan = paper::make_plan(app, of.costs, {.cores = 1, .slack = 0.0});
    ASSERT_TRUE(plan);
    bursts += plan->subchains[0].share > 1.0 ? 1 : 0;
    // Slots have whole nanoseconds: a run that fills its slots to the last of them may need one more.
    model::CostTable costs = of.costs;
    for (const graph::Subchain& subchain : app.graph.subchains()) {
      for (const NodeId node : subchain.nodes) costs.set(node, costs[node].times(1.0 - 1e-5));
    }
    const trial::Schedule schedule = trial::schedule_of(app, *plan);
    compared += held_chains(of, constant(app, costs), *plan, schedule, seconds{60}, 30, seed);
  }
  EXPECT_GT(compared, 300) << "or nothing was tested";
  EXPECT_GT(bursts, 20) << "or nothing was tested";
}

// Each by its own time, or triggered by each so-many-th output of a predecessor.
TEST(PromisesOfAllKinds, HoldWhereOutputsComeLessOftenThanRuns) {
  int compared = 0;
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    const int cores = 1 + static_cast<int>(seed % 2);
    // Drivers have cores of their own.
    const int drivers = seed % 3 == 0 ? 3 : 0;
    planner::RandomLimits limits{.subchains = 3, .max_cost = 4.0, .pairs = true, .drivers = drivers > 0 ? 2 : 0};
    limits.output_periods = true;
    const planner::RandomCase of = planner::random_case(seed, limits, drivers + cores);
    const graph::Graph& graph = of.app.graph;
    std::mt19937_64 random(seed);
    const auto uniform = [&](double low, double high) { return low + (high - low) * fraction_of(random()); };
    trial::Schedule schedule{.cores = drivers + cores, .subchains = {}, .frames = {}, .pipelines = {}};
    for (std::size_t i = 0; i < graph.subchains().size(); ++i) {
      const Nanos period = to_nanos(Millis{uniform(15.0, 60.0)});
      trial::Place place{.core = drivers + static_cast<int>(random() % static_cast<unsigned>(cores)),
                         .priority = 1 + static_cast<int>(random() % 100),
                         .period = period,
                         .phase = to_nanos(to_millis(period) * uniform(0.0, 0.999))};
      for (const NodeId predecessor : graph.node(graph.subchain(SubchainId(i)).head()).predecessors) {
        const graph::Node& given = graph.node(predecessor);
        if ((!given.unscheduled && (!given.subchain || given.subchain->index() >= i)) || random() % 2 == 0) continue;
        const int every = 1 + static_cast<int>(random() % 3);
        place.after = given.unscheduled ? plan::After{predecessor, every} : plan::After{*given.subchain, every};
        const Nanos apart =
            given.unscheduled ? given.outputs_apart() : schedule.subchains[given.subchain->index()].period;
        place.period = every * apart * 9 / 10;
        place.phase = Nanos{0};
      }
      schedule.subchains.push_back(place);
    }
    const trial::Samples samples = constant(of.app, of.costs);
    const auto plan = planner::plan_of(of.app, samples, of.costs, schedule, 0.0);
    if (!plan) continue;
    compared += held_chains(of, samples, *plan, schedule, seconds{60}, 30, seed);
  }
  EXPECT_GT(compared, 300) << "or nothing was tested";
}

TEST(PromisesOfAllKinds, HoldInFramesWhereOutputsComeLessOftenThanRuns) {
  int compared = 0;
  for (std::uint64_t seed = 1; seed <= 80; ++seed) {
    planner::RandomLimits limits{.subchains = 3, .min_cost = 0.5, .max_cost = 30.0, .pairs = true};
    limits.output_periods = true;
    limits.waits = seed % 5 == 0;
    const planner::RandomCase of = planner::random_case(seed, limits, 1);
    const Result<plan::Plan> plan = paper::make_plan(of.app, of.costs, {.cores = 1, .slack = 0.0});
    ASSERT_TRUE(plan);
    model::CostTable costs = of.costs;
    for (const graph::Subchain& subchain : of.app.graph.subchains()) {
      for (const NodeId node : subchain.nodes) costs.set(node, costs[node].times(1.0 - 1e-5));
    }
    compared +=
        held_chains(of, constant(of.app, costs), *plan, trial::schedule_of(of.app, *plan), seconds{60}, 30, seed);
  }
  EXPECT_GT(compared, 100) << "or nothing was tested";
}

// Runs each 20 ms for 2, of which only those count that end at 22 ms or more after what the last one was due.
TEST(PromisesOfAllKinds, AnOutputWaitsForARunAfterItsPeriod) {
  graph::AppSpec spec = graph::spec_of({"lidar", "base"}, {"lidar base"});
  node(spec, "lidar").output_period = graph::At<Nanos>{milliseconds{22}, {}};
  node(spec, "base").external = true;
  spec.objective = {graph::response("lidar base", 1.0)};
  const graph::App app = graph::build_app(spec).value();
  const model::CostTable costs(app.graph, Millis{2});
  const trial::Samples samples = constant(app, costs);
  const trial::Schedule schedule{
      .cores = 1, .subchains = {{.period = milliseconds{20}}}, .frames = {}, .pipelines = {}};
  const auto plan = planner::plan_of(app, samples, costs, schedule, 0.0);
  ASSERT_TRUE(plan);
  EXPECT_EQ(plan->chains[0].response, Millis{2 + 22 + 20 + 2});
  const Nanos seen = longest_in(app, samples, schedule, seconds{60})->metrics().chains()[0].response.longest;
  EXPECT_EQ(seen, milliseconds{42}) << "not 24";
}

// A driver that runs for 8 ms each 32, and must not do so while 24 ms of a map are under way.
TEST(PromisesOfAllKinds, ADriverWaitsForTheRunThatHasItsGroup) {
  graph::AppSpec spec = graph::spec_of({"driver", "map", "base"}, {"driver base", "map base"});
  node(spec, "driver").unscheduled = true;
  node(spec, "driver").period = graph::At<Nanos>{milliseconds{32}, {}};
  node(spec, "base").external = true;
  spec.objective = {graph::response("driver base", 1.0), graph::response("map base", 1.0)};
  spec.exclusive = {{{"group", {}}, graph::split("driver map")}};
  const graph::App app = graph::build_app(spec).value();
  model::CostTable costs(app.graph, Millis{8});
  costs.set(*app.graph.find_node("map"), model::CostProfile::constant(Millis{24}));
  const trial::Samples samples = constant(app, costs);
  const trial::Schedule schedule{
      .cores = 2, .subchains = {{.core = 1, .period = milliseconds{100}}}, .frames = {}, .pipelines = {}};
  const auto plan = planner::plan_of(app, samples, costs, schedule, 0.0);
  ASSERT_TRUE(plan);
  EXPECT_EQ(plan->chains[0].response, Millis{32 + 24 + 8});
  const Nanos seen = longest_in(app, samples, schedule, seconds{60})->metrics().chains()[0].response.longest;
  EXPECT_LE(seen, milliseconds{64});
  EXPECT_GT(seen, milliseconds{62}) << "not 40";
}

// It takes 6 of each 10 ms of the core.
TEST(PromisesOfAllKinds, ADriverTakesTheCoreOfWhatIsScheduled) {
  graph::AppSpec spec = graph::spec_of({"driver", "map", "base"}, {"driver map base"});
  node(spec, "driver").unscheduled = true;
  node(spec, "driver").period = graph::At<Nanos>{milliseconds{10}, {}};
  node(spec, "base").external = true;
  spec.objective = {graph::response("map base", 1.0)};
  const graph::App app = graph::build_app(spec).value();
  model::CostTable costs(app.graph, Millis{10});
  costs.set(*app.graph.find_node("driver"), model::CostProfile::constant(Millis{6}));
  const trial::Samples samples = constant(app, costs);
  const trial::Schedule schedule{
      .cores = 1, .subchains = {{.period = milliseconds{37}}}, .frames = {}, .pipelines = {}};
  const auto plan = planner::plan_of(app, samples, costs, schedule, 0.0);
  ASSERT_TRUE(plan);
  EXPECT_EQ(plan->subchains[0].execution, Millis{10 + 3 * 6});
  const Nanos seen = longest_in(app, samples, schedule, seconds{60})->metrics().chains()[0].response.longest;
  EXPECT_GT(seen, milliseconds{37 + 22});
  EXPECT_LE(to_millis(seen), plan->chains[0].response) << "not 47";
  costs.set(*app.graph.find_node("driver"), model::CostProfile::constant(Millis{10}));
  EXPECT_FALSE(planner::plan_of(app, samples, costs, schedule, 0.0)) << "it leaves nothing";
}

// Of two drivers on one core neither pre-empts the other.
TEST(PromisesOfAllKinds, ADriverWaitsForAnotherWhereThereIsNoCoreForEach) {
  graph::AppSpec spec = graph::spec_of({"fast", "slow", "map", "base"}, {"fast base", "slow base", "map base"});
  const auto drive = [&](const char* name, Nanos period) {
    node(spec, name).unscheduled = true;
    node(spec, name).period = graph::At<Nanos>{period, {}};
  };
  drive("fast", milliseconds{10});
  drive("slow", milliseconds{31});
  node(spec, "base").external = true;
  spec.objective = {graph::response("fast base", 1.0), graph::response("map base", 1.0)};
  const graph::App app = graph::build_app(spec).value();
  model::CostTable costs(app.graph, Millis{1});
  costs.set(*app.graph.find_node("slow"), model::CostProfile::constant(Millis{7}));
  const trial::Samples samples = constant(app, costs);
  const auto response_of_fast = [&](int cores) {
    const trial::Schedule schedule{
        .cores = cores, .subchains = {{.period = milliseconds{50}}}, .frames = {}, .pipelines = {}};
    const auto plan = planner::plan_of(app, samples, costs, schedule, 0.0);
    const Nanos seen = longest_in(app, samples, schedule, seconds{60})->metrics().chains()[0].response.longest;
    EXPECT_LE(to_millis(seen), plan.value().chains[0].response);
    return plan->chains[0].response;
  };
  EXPECT_EQ(response_of_fast(1), Millis{10 + 7 + 1});
  EXPECT_EQ(response_of_fast(2), Millis{10 + 1});
}

// In a frame of 8128 ms it has 128 runs, one right after the other, and then none.
TEST(PromisesOfAllKinds, AReaderOfBurstsMayNotRespondForLong) {
  graph::AppSpec spec = graph::spec_of({"slow", "log", "base"}, {"log base", "slow base"});
  node(spec, "log").input = graph::InputKind::kQueue;
  node(spec, "base").external = true;
  spec.objective = {graph::response("log base", 1.0)};
  spec.scheduler.frames = graph::FrameMode::kFixed;
  const graph::App app = graph::build_app(spec).value();
  model::CostTable costs(app.graph, Millis{8000});
  costs.set(*app.graph.find_node("log"), model::CostProfile::constant(Millis{1}));
  plan::Plan plan;
  plan.planner = "by hand";
  const Millis frame{8128};
  plan.subchains = {{{0}, frame, frame, 1, 1.0, Millis{8000}},
                    {{0}, frame / 128, frame + Millis{1 - 128}, {}, 128.0, Millis{128}}};
  plan.cores.resize(1);
  plan.cores[0].frame = frame;
  plan.cores[0].frames = graph::FrameMode::kFixed;
  plan.cores[0].slots = {{SubchainId(1), Millis{0}, Millis{128}, {}, 0},
                         {SubchainId(0), Millis{128}, Millis{8000}, 1, 0}};
  plan::fill_predictions(plan, app, costs);
  const Status valid = plan::validate(plan, app, costs, 1);
  ASSERT_TRUE(valid) << valid.error().message();
  const auto seen = longest_in(app, constant(app, costs), trial::schedule_of(app, plan), seconds{100});
  const Longest& log = seen->metrics().chains()[0].response;
  EXPECT_GT(log.longest, seconds{8});
  EXPECT_LE(to_millis(log.longest), plan.chains[0].response) << "not 127 ms";
}

// Two nodes of two threads each, on two cores: 1 ms of work and 3 ms of waits, 2 ms and 1 ms. Were there a second run
// meanwhile, one that comes back might find its cores taken.
TEST(PromisesOfAllKinds, RunsOverlapNoMoreThanThereAreCoresForTheirThreads) {
  graph::AppSpec spec = graph::spec_of({"a", "b", "base"}, {"a b base"});
  node(spec, "a").max_threads = node(spec, "b").max_threads = graph::At<int>{2, {}};
  node(spec, "base").external = true;
  spec.subchains = {graph::subchain("ab", "a b")};
  spec.objective = {graph::response("a b base", 1.0)};
  const graph::App app = graph::build_app(spec).value();
  model::CostTable costs(app.graph, Millis{2});
  costs.set_wait(NodeId(0), Millis{3});
  costs.set(NodeId(1), model::CostProfile::constant(Millis{4}));
  costs.set_wait(NodeId(1), Millis{1});
  const model::OwnedCores owned = model::owned_cores_with(app.graph, SubchainId(0), costs, 2, 2, 0.0);
  EXPECT_EQ(owned.execution, Millis{7});
  EXPECT_EQ(owned.period, Millis{7}) << "not 4, which is what a takes";
  const trial::Samples samples = constant(app, costs);
  const auto longest = [&](const dispatch::Pacing& pacing) {
    const trial::Schedule schedule{.cores = 2,
                                   .subchains = {{.form = trial::Form::kPipeline}},
                                   .frames = {},
                                   .pipelines = {{SubchainId(0), {0, 1}, 2, pacing}}};
    return to_millis(longest_in(app, samples, schedule, seconds{10})->metrics().chains()[0].response.longest);
  };
  EXPECT_LE(longest(dispatch::pacing_of_owned(owned.period, owned.execution, Nanos{0})), Millis{7 + 7});
}

}  // namespace
}  // namespace ctn
