// Trials (src/trial) beside what they are short for: the simulator, on the same schedules at the same costs, and the
// lineage of the record, on the trial's own runs.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <numeric>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "base/mixed.h"
#include "baselines/policies.h"
#include "planner/frames.h"
#include "planner/promised.h"
#include "planner/random_apps.h"
#include "policy/replan.h"
#include "policy/testing/given_places.h"
#include "record/run_metrics.h"
#include "sim/clocks.h"
#include "sim/simulation.h"
#include "trial/trial.h"

namespace ctn {
namespace {

using std::chrono::seconds;

constexpr std::uint64_t kSeed = 7;
constexpr Nanos kMeasured = seconds{60};

// Runs vary: half of them cost two thirds of what is planned with or less.
model::Workload varying(const graph::App& app, const model::CostTable& costs) {
  model::Workload work(app.graph);
  for (std::size_t kind = 0; kind < app.kinds(); ++kind) {
    const model::CostTable there = costs.on(app, kind);
    for (std::size_t node = 0; node < app.graph.nodes().size(); ++node) {
      const NodeId id(node);
      if (app.graph.node(id).external) continue;
      const Millis cost = there[id].single_thread();
      const model::NodeWork law{model::CostProfile::constant(cost), {cost * 0.66}, 0.0, {}};
      app.core_kinds.empty() ? work.set(id, law) : work.set_on(id, kind, law);
    }
  }
  for (std::size_t node = 0; node < app.graph.nodes().size(); ++node) {
    const Millis wait = costs.wait(NodeId(node));
    if (wait > Millis{0}) work.set_wait(NodeId(node), {wait, wait * 0.66});
  }
  return work;
}

planner::RandomCase random_case(std::uint64_t seed, int subchains, int cores) {
  return planner::random_case(seed,
                              {.subchains = subchains,
                               .chains = 4,
                               .queue = seed % 3 == 0,
                               .caps = seed % 2 == 0,
                               .pairs = true,
                               .kinds = seed % 4 == 0},
                              cores);
}

// --- Fixed priorities ---

// The plan that the policy below is to follow.
baselines::RatePlan& given_plan() {
  static baselines::RatePlan plan;
  return plan;
}

Result<baselines::RatePlan> plan_as_given(const graph::App&, const model::CostTable&, const baselines::RateRequest&) {
  return given_plan();
}

// Any core and any period, so that a core has work for 65 % of its time at most, and the shorter the period the higher
// the priority: then each run ends within its period.
baselines::RatePlan random_rates(const planner::RandomCase& of, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto uniform = [&](double low, double high) { return low + (high - low) * fraction_of(random()); };
  const std::size_t count = of.app.graph.subchains().size();
  baselines::RatePlan plan;
  std::vector<double> part(count);
  std::vector<double> sum(static_cast<std::size_t>(of.cores), 0.0);
  for (std::size_t i = 0; i < count; ++i) {
    plan.subchains.push_back({.core = static_cast<int>(random() % static_cast<unsigned>(of.cores))});
    part[i] = uniform(0.1, 1.0);
    sum[static_cast<std::size_t>(plan.subchains[i].core)] += part[i];
  }
  for (std::size_t i = 0; i < count; ++i) {
    baselines::TaskPlan& task = plan.subchains[i];
    const model::CostTable there = of.costs.on(of.app, of.app.kind_of(task.core));
    const Millis cost = there.subchain_total(of.app.graph, SubchainId(i));
    task.period = cost * (sum[static_cast<std::size_t>(task.core)] / (0.65 * part[i])) +
                  there.subchain_wait(of.app.graph, SubchainId(i));
  }
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return plan.subchains[a].period > plan.subchains[b].period; });
  for (std::size_t i = 0; i < count; ++i) plan.subchains[order[i]].priority = static_cast<int>(i) + 1;
  return plan;
}

trial::Schedule schedule_of(const baselines::RatePlan& plan, int cores) {
  trial::Schedule schedule{.cores = cores, .subchains = {}, .frames = {}, .pipelines = {}};
  // The simulator's controllers begin one after the other, and the grids of their triggers with them.
  const sim::MachineCosts machine;
  const Nanos apart = machine.context_switch + machine.dispatch_event;
  for (const baselines::TaskPlan& task : plan.subchains) {
    const auto before = static_cast<Nanos::rep>(schedule.subchains.size());
    schedule.subchains.push_back(
        {.core = task.core, .priority = task.priority, .period = to_nanos(task.period), .phase = before * apart});
  }
  return schedule;
}

struct Both {
  trial::Figures tried;
  sim::Outcome simulated;
};

Both run_both(const planner::RandomCase& of, const trial::Schedule& schedule, sim::Options options) {
  const model::Workload work = varying(of.app, of.costs);
  options.machine.cores = of.cores;
  const sim::ClockChance clocks = options.clocks;
  auto outcome =
      sim::simulate(of.app, std::make_unique<sim::DrawnCosts>(of.app, work, kSeed), std::move(options), kMeasured);
  if (!outcome) throw std::runtime_error(outcome.error().message());
  const trial::Samples samples(of.app, work, Nanos{0}, kSeed);
  const Nanos warm_up = of.app.scheduler.bootstrap + policy::kSettle;
  const trial::Options tried{
      .horizon = kMeasured, .warm_up = warm_up, .p95 = true, .clocks = sim::draw_clocks(of.app.graph, clocks).external};
  return {trial::Trial(of.app, samples).run(schedule, tried), std::move(*outcome)};
}

double deviation(double figure, double of) { return std::abs(figure / of - 1.0); }

// Each response time of which there are some hundred samples, and the objective.
void expect_close(const planner::RandomCase& of, const Both& both, double response, double objective) {
  std::size_t chain = 0;
  for (std::size_t term = 0; term < of.app.objective.size(); ++term) {
    if (of.app.objective[term].metric != graph::Metric::kResponseTime) continue;
    const sim::ChainOutcome& simulated = both.simulated.chains[chain++];
    if (simulated.response_ms.count < 100) continue;
    EXPECT_LT(deviation(both.tried.terms[term].mean_ms, simulated.response_ms.mean), response)
        << simulated.path << ": " << both.tried.terms[term].mean_ms << " ms tried, " << simulated.response_ms.mean
        << " ms simulated";
  }
  ASSERT_TRUE(both.simulated.objective.has_value());
  EXPECT_LT(deviation(both.tried.objective, *both.simulated.objective), objective)
      << both.tried.objective << " tried, " << *both.simulated.objective << " simulated";
  // Of all cores together: threads of a pipeline may be on any of its own.
  double busy = 0.0;
  for (std::size_t core = 0; core < both.tried.busy.size(); ++core) {
    busy += both.tried.busy[core] - both.simulated.cores[core].real_time - both.simulated.cores[core].ordinary;
  }
  EXPECT_NEAR(busy, 0.0, 0.02);
}

class TrialAgreement : public ::testing::TestWithParam<int> {};

TEST_P(TrialAgreement, WithTheSimulatorOnFixedPriorities) {
  const auto seed = static_cast<std::uint64_t>(GetParam());
  const planner::RandomCase of = random_case(seed, 3 + GetParam() % 5, 1 + GetParam() % 3);
  given_plan() = random_rates(of, seed);
  const sim::Options options{.policy = std::make_shared<baselines::RatesPolicy>("given", plan_as_given, of.costs)};
  expect_close(of, run_both(of, schedule_of(given_plan(), of.cores), options), 0.03, 0.02);
}

TEST_P(TrialAgreement, WithTheSimulatorOnWhatThePlannerMakes) {
  const auto seed = static_cast<std::uint64_t>(GetParam());
  const planner::RandomCase of = random_case(seed, 3 + GetParam() % 5, 1 + GetParam() % 4);
  const plan::Plan plan = planner::make_plan_in_frames(of.app, of.costs, {.cores = of.cores}).value();
  sim::Options options{.policy = policy::make_policy("catan").value()};
  options.plans = {{Nanos{0}, plan}};
  expect_close(of, run_both(of, trial::schedule_of(of.app, plan), options), 0.06, 0.03);
}

// Every other node waits for up to two times as long as it computes.
planner::RandomCase with_waits(planner::RandomCase of, std::uint64_t seed) {
  for (std::size_t node = 0; node < of.app.graph.nodes().size(); ++node) {
    const std::uint64_t chance = mixed_of(seed, node);
    if (chance % 2 == 0 || of.app.graph.nodes()[node].external) continue;
    const double part = static_cast<double>(chance % 97) / 48.0;
    of.costs.set_wait(NodeId(node), part * of.costs[NodeId(node)].single_thread());
  }
  return of;
}

TEST_P(TrialAgreement, WithTheSimulatorWhereRunsWait) {
  const auto seed = static_cast<std::uint64_t>(GetParam());
  const planner::RandomCase of = with_waits(random_case(seed, 3 + GetParam() % 5, 1 + GetParam() % 3), seed);
  given_plan() = random_rates(of, seed);
  const sim::Options options{.policy = std::make_shared<baselines::RatesPolicy>("given", plan_as_given, of.costs)};
  expect_close(of, run_both(of, schedule_of(given_plan(), of.cores), options), 0.03, 0.02);
}

TEST_P(TrialAgreement, WithTheSimulatorOnWhatThePlannerMakesWhereRunsWait) {
  const auto seed = static_cast<std::uint64_t>(GetParam());
  const planner::RandomCase of = with_waits(random_case(seed, 3 + GetParam() % 5, 1 + GetParam() % 4), seed);
  const plan::Plan plan = planner::make_plan_in_frames(of.app, of.costs, {.cores = of.cores}).value();
  sim::Options options{.policy = policy::make_policy("catan").value()};
  options.plans = {{Nanos{0}, plan}};
  expect_close(of, run_both(of, trial::schedule_of(of.app, plan), options), 0.06, 0.03);
}

// --- A display ---

// Two chains that end at its ticks, of which one begins at those of a camera.
planner::RandomCase with_display(std::uint64_t seed) {
  graph::AppSpec spec =
      graph::spec_of({"camera", "track", "draw", "warp", "display"}, {"camera track draw warp display", "track warp"});
  for (const char* name : {"camera", "display"}) graph::node(spec, name).external = true;
  graph::node(spec, "camera").period = graph::At<Nanos>{std::chrono::microseconds{33'333}, {}};
  graph::node(spec, "display").period = graph::At<Nanos>{std::chrono::microseconds{8'333}, {}};
  spec.objective = {graph::response("camera track draw warp display", 0.5), graph::response("track warp display", 0.5),
                    graph::response("draw warp display", 1.0)};
  graph::App app = graph::build_app(spec).value();
  model::CostTable costs(app.graph, Millis{1.0});
  costs.set(*app.graph.find_node("track"), model::CostProfile::constant(Millis{6.0}));
  return {.app = std::move(app), .costs = std::move(costs), .cores = 1 + static_cast<int>(seed % 2)};
}

TEST_P(TrialAgreement, WithTheSimulatorOfClocksThatAreNotOurs) {
  const auto seed = static_cast<std::uint64_t>(GetParam());
  const planner::RandomCase of = with_display(seed);
  given_plan() = random_rates(of, seed);
  sim::Options options{.policy = std::make_shared<baselines::RatesPolicy>("given", plan_as_given, of.costs)};
  options.clocks = {.seed = seed, .drift_ppm = 200.0};
  expect_close(of, run_both(of, schedule_of(given_plan(), of.cores), options), 0.03, 0.02);
}

// Both draw at each tick, warp just before it.
TEST(TrialAgreementOfClocks, WithTheSimulatorOnPhasesToADisplay) {
  const planner::RandomCase of = with_display(1);
  trial::Schedule schedule{.cores = 2, .subchains = {}, .frames = {}, .pipelines = {}};
  const NodeId display = *of.app.graph.find_node("display");
  const Nanos tick = *of.app.graph.node(display).period;
  std::vector<policy::SubchainPlace> places;
  const auto add = [&](int core, int priority, Nanos period, Nanos phase, bool to_display) {
    schedule.subchains.push_back({.core = core, .priority = priority, .period = period, .phase = phase});
    places.push_back(policy::place_by_phase(priority - 1, core, period, phase));
    if (!to_display) return;
    schedule.subchains.back().clock = display;
    places.back().pacing.clock = display;
    places.back().pacing.ticks = {static_cast<int>(period / tick), 1};
  };
  add(0, 1, std::chrono::milliseconds{20}, Nanos{0}, false);
  add(1, 1, 2 * tick, std::chrono::milliseconds{4}, true);
  add(1, 2, tick, std::chrono::milliseconds{7}, true);
  sim::Options options{.policy = std::make_shared<policy::GivenPlaces>(places)};
  options.clocks = {.seed = 5, .drift_ppm = 100.0};
  const Both both = run_both(of, schedule, options);
  expect_close(of, both, 0.02, 0.02);
  // draw -> warp -> display: two ticks between outputs, from 4 ms after a tick to the next one.
  EXPECT_NEAR(both.simulated.chains[2].response_ms.mean, to_millis(3 * tick).count() - 4.0, 0.2);
}

INSTANTIATE_TEST_SUITE_P(RandomApps, TrialAgreement, ::testing::Range(0, 16));

// --- Promises ---

// Runs by subchain: from the trigger by time that they go back to, to their end.
class LongestRuns : public trial::Observer {
 public:
  LongestRuns(const graph::App& app, const trial::Schedule& schedule)
      : app_(app), schedule_(schedule), longest_(schedule.subchains.size()), runs_(schedule.subchains.size()) {}
  void ended(const trial::ObservedRun& run) override {
    const std::size_t subchain = app_.graph.node(run.node).subchain->index();
    const trial::Place& place = schedule_.subchains[subchain];
    const Nanos since_first = run.begin.time_since_epoch() - place.phase;
    const TimePoint trigger = TimePoint{} + place.phase + since_first / place.period * place.period;
    longest_[subchain] = std::max(longest_[subchain], run.end - trigger);
    ++runs_[subchain];
  }
  Nanos longest(std::size_t subchain) const { return longest_[subchain]; }
  int runs(std::size_t subchain) const { return runs_[subchain]; }

 private:
  const graph::App& app_;
  const trial::Schedule& schedule_;
  std::vector<Nanos> longest_;
  std::vector<int> runs_;
};

// Rates, phases, costs and waits at random, by time, on one core where scheduling costs nothing: no run takes longer
// than is promised.
TEST(Promises, HoldForRunsThatWait) {
  int compared = 0;
  for (std::uint64_t seed = 1; seed <= 400; ++seed) {
    std::mt19937_64 random(seed);
    const auto uniform = [&](double low, double high) { return low + (high - low) * fraction_of(random()); };
    const planner::RandomCase of = planner::random_case(seed, {.subchains = 3}, 1);
    model::CostTable costs(of.app.graph, Millis{0});
    trial::Schedule schedule{.cores = 1, .subchains = {}, .frames = {}, .pipelines = {}};
    for (std::size_t i = 0; i < of.app.graph.subchains().size(); ++i) {
      const NodeId node = of.app.graph.subchain(SubchainId(i)).head();
      const double cost = uniform(0.5, 3.0);
      const double wait = i < 2 ? uniform(0.5, 6.0) : 0.0;
      costs.set(node, model::CostProfile::constant(Millis{cost}));
      costs.set_wait(node, Millis{wait});
      const Nanos period = to_nanos(Millis{(cost + wait) * uniform(1.0, 2.0) + (i == 2 ? 20.0 : 0.0)});
      schedule.subchains.push_back({.priority = 3 - static_cast<int>(i),
                                    .period = period,
                                    .phase = to_nanos(to_millis(period) * uniform(0.0, 0.999))});
    }
    const trial::Samples samples(of.app, trial::MeasuredRuns{}, costs);
    const std::optional<plan::Plan> plan = planner::plan_of(of.app, samples, costs, schedule, 0.0);
    if (!plan) continue;
    LongestRuns seen(of.app, schedule);
    static_cast<void>(trial::Trial(of.app, samples)
                          .run(schedule, {.horizon = seconds{20},
                                          .warm_up = Nanos{0},
                                          .overheads = trial::Overheads::none(),
                                          .observer = &seen}));
    for (std::size_t i = 0; i < schedule.subchains.size(); ++i) {
      const Millis promised = plan->subchains[i].execution;
      // Beyond its period a run goes back to a trigger before the last.
      if (to_nanos(promised) > schedule.subchains[i].period) continue;
      ASSERT_GT(seen.runs(i), 100);
      EXPECT_LE(to_millis(seen.longest(i)).count(), promised.count() + 1e-3) << "seed " << seed << ", subchain " << i;
      ++compared;
    }
  }
  EXPECT_GT(compared, 600);
}

// --- Lineage ---

// The terms, from the runs that a trial reports.
template <class Sum>
class Measured : public trial::Observer {
 public:
  Measured(const graph::App& app, record::Interval interval) : metrics_(app, interval) {}
  void ended(const trial::ObservedRun& run) override {
    record::Run recorded;
    recorded.node = run.node;
    recorded.number = run.number;
    recorded.begin = run.begin;
    recorded.end = run.end;
    recorded.emitted = run.emitted;
    for (const auto& [predecessor, first, last] : run.consumed) recorded.consumed.push_back({predecessor, first, last});
    metrics_.add(recorded);
  }
  void set_clock(NodeId node, const Ticks& ticks) { metrics_.set_clock(node, ticks); }
  const record::RunMetrics<Sum>& metrics() const { return metrics_; }

 private:
  record::RunMetrics<Sum> metrics_;
};

struct Total {
  void add(Nanos value) {
    total += static_cast<double>(value.count());
    ++count;
  }
  double total = 0.0;
  std::size_t count = 0;
};

struct Longest {
  void add(Nanos value) {
    longest = std::max(longest, value);
    ++count;
  }
  Nanos longest{0};
  int count = 0;
};

// What a schedule comes to in so long, where scheduling costs nothing.
std::unique_ptr<Measured<Longest>> longest_in(const graph::App& app, const trial::Samples& samples,
                                              const trial::Schedule& schedule, Nanos horizon) {
  const Nanos warm_up = seconds{1};
  auto seen =
      std::make_unique<Measured<Longest>>(app, record::Interval{TimePoint{warm_up}, TimePoint{warm_up + horizon}});
  static_cast<void>(
      trial::Trial(app, samples)
          .run(
              schedule,
              {.horizon = horizon, .warm_up = warm_up, .overheads = trial::Overheads::none(), .observer = seen.get()}));
  return seen;
}

// Whole multiples of one period, phases and costs at random, on one or two cores where scheduling costs nothing: no
// response takes longer than is promised, which is less than a period for each input that keeps in step.
TEST(Promises, HoldForChainsThatKeepInStep) {
  int compared = 0;
  int in_step = 0;
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    std::mt19937_64 random(seed);
    const auto uniform = [&](double low, double high) { return low + (high - low) * fraction_of(random()); };
    const planner::RandomCase of = planner::random_case(seed, {.subchains = 4}, 1 + static_cast<int>(seed % 2));
    model::CostTable costs(of.app.graph, Millis{0});
    trial::Schedule schedule{.cores = of.cores, .subchains = {}, .frames = {}, .pipelines = {}};
    for (std::size_t i = 0; i < of.app.graph.subchains().size(); ++i) {
      for (const NodeId node : of.app.graph.subchain(SubchainId(i)).nodes) {
        costs.set(node, model::CostProfile::constant(Millis{uniform(0.2, 1.5)}));
      }
      const Nanos period = std::chrono::milliseconds{12} * static_cast<int>(1 + random() % 3);
      schedule.subchains.push_back({.core = static_cast<int>(random() % static_cast<unsigned>(of.cores)),
                                    .priority = 9 - static_cast<int>(i),
                                    .period = period,
                                    .phase = to_nanos(to_millis(period) * uniform(0.0, 0.999))});
    }
    const trial::Samples samples(of.app, trial::MeasuredRuns{}, costs);
    const std::optional<plan::Plan> plan = planner::plan_of(of.app, samples, costs, schedule, 0.0);
    if (!plan) continue;
    const auto seen = longest_in(of.app, samples, schedule, seconds{10});
    for (std::size_t chain = 0; chain < plan->chains.size(); ++chain) {
      const plan::ChainPlan& promised = plan->chains[chain];
      const Longest& found = seen->metrics().chains()[chain].response;
      if (found.count < 100) continue;
      EXPECT_LE(to_millis(found.longest).count(), promised.response.count() + 1e-3) << "seed " << seed;
      ++compared;
      Millis apart{0};
      for (const graph::ChainElement& element : of.app.graph.chain_elements(promised.path)) {
        const plan::SubchainPlan& planned = plan->subchains[element.subchain->index()];
        apart += planned.period + planned.execution;
      }
      apart -= plan->subchains[of.app.graph.chain_elements(promised.path).front().subchain->index()].period;
      if (promised.latency < apart - Millis{1.0}) ++in_step;
    }
  }
  EXPECT_GT(compared, 300);
  EXPECT_GT(in_step, 100) << "or nothing was tested";
}

// Everybody but the first is triggered by each so-many-th output of a predecessor: what follows takes the output that
// triggers it, so that no response takes longer than is promised, which is less than a period for each such input.
TEST(Promises, HoldForChainsOfFollowers) {
  int compared = 0;
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    std::mt19937_64 random(seed);
    const auto uniform = [&](double low, double high) { return low + (high - low) * fraction_of(random()); };
    const planner::RandomCase of = planner::random_case(seed, {.subchains = 4}, 1 + static_cast<int>(seed % 2));
    const graph::Graph& graph = of.app.graph;
    model::CostTable costs(graph, Millis{0});
    trial::Schedule schedule{.cores = of.cores, .subchains = {}, .frames = {}, .pipelines = {}};
    for (std::size_t i = 0; i < graph.subchains().size(); ++i) {
      for (const NodeId node : graph.subchain(SubchainId(i)).nodes) {
        costs.set(node, model::CostProfile::constant(Millis{uniform(0.2, 1.5)}));
      }
      trial::Place place{.core = static_cast<int>(random() % static_cast<unsigned>(of.cores)),
                         .priority = 9 - static_cast<int>(i),
                         .period = std::chrono::milliseconds{20}};
      for (const NodeId predecessor : graph.node(graph.subchain(SubchainId(i)).head()).predecessors) {
        const auto leader = graph.node(predecessor).subchain;
        if (!leader || leader->index() >= i) continue;
        place.after = plan::After{*leader, 1 + static_cast<int>(random() % 3)};
        place.period = place.after->every * schedule.subchains[leader->index()].period * 9 / 10;
      }
      schedule.subchains.push_back(place);
    }
    const trial::Samples samples(of.app, trial::MeasuredRuns{}, costs);
    const std::optional<plan::Plan> plan = planner::plan_of(of.app, samples, costs, schedule, 0.0);
    if (!plan) continue;
    const auto seen = longest_in(of.app, samples, schedule, seconds{30});
    for (std::size_t chain = 0; chain < plan->chains.size(); ++chain) {
      const plan::ChainPlan& promised = plan->chains[chain];
      const Longest& found = seen->metrics().chains()[chain].response;
      if (found.count < 30) continue;
      EXPECT_LE(to_millis(found.longest).count(), promised.response.count() + 1e-3) << "seed " << seed;
      ++compared;
    }
  }
  EXPECT_GT(compared, 300) << "or nothing was tested";
}

// Everything that a chain can meet: followers, batches in the middle and one after the other, an external node between
// two of ours, outputs that are left out, nodes that run at any rate, clocks of others at either end.
graph::App tangled() {
  graph::AppSpec spec =
      graph::spec_of({"u", "v", "a", "b", "x", "c", "q", "d", "r", "e", "w", "s", "z"},
                     {"u v a b c q d r e", "a q", "v d", "b x d", "b x r", "c w", "s a", "s q", "e z", "q z", "b z"});
  graph::node(spec, "u").unscheduled = true;
  graph::node(spec, "u").period = graph::At<Nanos>{std::chrono::milliseconds{5}, {}};
  graph::node(spec, "v").unscheduled = true;
  for (const char* name : {"x", "s", "z"}) graph::node(spec, name).external = true;
  graph::node(spec, "s").period = graph::At<Nanos>{std::chrono::milliseconds{23}, {}};
  graph::node(spec, "z").period = graph::At<Nanos>{std::chrono::milliseconds{7}, {}};
  graph::node(spec, "q").input = graph::InputKind::kQueue;
  graph::node(spec, "r").input = graph::InputKind::kQueue;
  graph::node(spec, "w").input = graph::InputKind::kQueue;  // which may find its queues empty, and is known to
  graph::node(spec, "c").output_period = graph::At<Nanos>{std::chrono::milliseconds{17}, {}};
  graph::node(spec, "v").output_period = graph::At<Nanos>{std::chrono::milliseconds{11}, {}};
  spec.subchains = {graph::subchain("ab", "a b"), graph::subchain("de", "d")};
  for (const char* path : {"u v a b c q d r e", "a q d", "v d r e", "b x d", "b x r e", "q d", "a b c", "u v a", "q",
                           "s a b c", "s a b z", "s a q z", "s q d r e z", "a q d r e z", "b z", "s q z"}) {
    spec.objective.push_back(graph::response(path, 1.0));
  }
  for (const char* node : {"a", "c", "q", "e", "w"}) spec.objective.push_back(graph::period(node, 1.0));
  Result<graph::App> app = graph::build_app(spec);
  if (!app) throw std::runtime_error(app.error().message());
  return *std::move(app);
}

trial::Schedule random_schedule(const graph::App& app, int cores, std::mt19937_64& random) {
  trial::Schedule schedule{.cores = cores, .subchains = {}, .frames = {}, .pipelines = {}};
  const std::size_t count = app.graph.subchains().size();
  const auto micros = [&](unsigned low, unsigned high) {
    return Nanos{std::chrono::microseconds{low + random() % (high - low)}};
  };
  for (std::size_t i = 0; i < count; ++i) {
    trial::Place& place = schedule.subchains.emplace_back();
    place.core = static_cast<int>(random() % static_cast<unsigned>(cores));
    place.priority = static_cast<int>(i) + 1;
    place.period = micros(2'000, 40'000);
    switch (random() % 4) {
      case 0:
        place.pause = micros(0, 5'000);
        break;
      case 1:
        if (i > 0) place.after = plan::After{SubchainId(random() % i), 1 + static_cast<int>(random() % 3)};
        break;
      default:
        place.phase = micros(0, 2'000);
    }
    if (random() % 4 == 0) place.budget = micros(500, 4'000);
  }
  return schedule;
}

class TrialLineage : public ::testing::TestWithParam<int> {};

TEST_P(TrialLineage, IsThatOfTheRecord) {
  std::mt19937_64 random(static_cast<std::uint64_t>(GetParam()));
  const graph::App app = tangled();
  model::CostTable costs(app.graph, Millis{0});
  for (std::size_t node = 0; node < app.graph.nodes().size(); ++node) {
    const bool small = app.graph.nodes()[node].unscheduled;
    costs.set(NodeId(node),
              model::CostProfile::constant(Millis{(small ? 0.05 : 1.0) * (0.5 + static_cast<double>(random() % 8))}));
  }
  const trial::Samples samples(app, varying(app, costs), Nanos{0}, kSeed);
  const trial::Schedule schedule = random_schedule(app, 1 + GetParam() % 3, random);
  const TimePoint warm_from = TimePoint{} + seconds{1};
  const Nanos horizon = seconds{20};
  Measured<Total> measured(app, {warm_from, warm_from + horizon});
  const std::vector<Ticks> clocks =
      sim::draw_clocks(app.graph, {.seed = static_cast<std::uint64_t>(GetParam()), .drift_ppm = 100.0}).external;
  for (std::size_t node = 0; node < clocks.size(); ++node) {
    if (clocks[node].period > Nanos{0}) measured.set_clock(NodeId(node), clocks[node]);
  }
  // Without overheads, controllers hold no core between what a run takes and what the record takes it to have taken.
  const trial::Figures figures = trial::Trial(app, samples)
                                     .run(schedule, {.horizon = horizon,
                                                     .warm_up = warm_from - TimePoint{},
                                                     .overheads = trial::Overheads::none(),
                                                     .clocks = clocks,
                                                     .observer = &measured});
  std::size_t chain = 0;
  std::size_t samples_seen = 0;
  for (std::size_t term = 0; term < app.objective.size(); ++term) {
    const graph::Term& of = app.objective[term];
    const bool is_chain = of.metric == graph::Metric::kResponseTime;
    const Total& sum =
        is_chain ? measured.metrics().chains()[chain++].response : measured.metrics().node(of.path.front()).period;
    EXPECT_EQ(figures.terms[term].count, sum.count) << app.graph.path_name(of.path);
    if (sum.count < trial::kFewestSamples) continue;
    EXPECT_NEAR(figures.terms[term].mean_ms, sum.total / static_cast<double>(sum.count) / 1e6, 1e-9)
        << app.graph.path_name(of.path);
    samples_seen += sum.count;
  }
  EXPECT_GT(samples_seen, 1000U);
}

INSTANTIATE_TEST_SUITE_P(RandomSchedules, TrialLineage, ::testing::Range(0, 40));

}  // namespace
}  // namespace ctn
