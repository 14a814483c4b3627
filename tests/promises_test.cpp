// What is promised of schedules (plan/promise.h) beside trials of them: nothing takes longer.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <numeric>
#include <optional>
#include <random>
#include <utility>
#include <vector>

#include "base/mixed.h"
#include "longest_in_trials.h"
#include "planner/promised.h"
#include "planner/testing/random_apps.h"
#include "trial/trial.h"

namespace ctn {
namespace {

using std::chrono::seconds;

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
    watch(of.app, samples, schedule, {.horizon = seconds{20}, .warm_up = Nanos{0}, .observer = &seen});
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

// The same where runs of some do not overlap: on one core, where one that is raised keeps those between from it, and on
// two, where one waits for what another core does.
TEST(Promises, HoldForRunsOfExclusiveGroups) {
  int compared = 0;
  for (std::uint64_t seed = 1; seed <= 600; ++seed) {
    std::mt19937_64 random(seed);
    const auto uniform = [&](double low, double high) { return low + (high - low) * fraction_of(random()); };
    const int cores = seed % 3 == 0 ? 2 : 1;
    const planner::RandomCase of = planner::random_case(seed, {.subchains = 4, .exclusive = true}, cores);
    model::CostTable costs(of.app.graph, Millis{0});
    trial::Schedule schedule{.cores = cores, .subchains = {}, .frames = {}, .pipelines = {}};
    for (std::size_t i = 0; i < of.app.graph.subchains().size(); ++i) {
      const NodeId node = of.app.graph.subchain(SubchainId(i)).head();
      const double cost = uniform(0.5, 3.0);
      const double wait = seed % 2 == 0 && i == 1 ? uniform(0.5, 4.0) : 0.0;
      costs.set(node, model::CostProfile::constant(Millis{cost}));
      costs.set_wait(node, Millis{wait});
      const Nanos period = to_nanos(Millis{10.0 + 10.0 * static_cast<double>(i) + uniform(0.0, 10.0)});
      schedule.subchains.push_back({.core = static_cast<int>(i) % cores,
                                    .priority = 4 - static_cast<int>(i),
                                    .period = period,
                                    .phase = to_nanos(to_millis(period) * uniform(0.0, 0.999))});
    }
    const trial::Samples samples(of.app, trial::MeasuredRuns{}, costs);
    const std::optional<plan::Plan> plan = planner::plan_of(of.app, samples, costs, schedule, 0.0);
    if (!plan) continue;
    LongestRuns seen(of.app, schedule);
    watch(of.app, samples, schedule, {.horizon = seconds{20}, .warm_up = Nanos{0}, .observer = &seen});
    for (std::size_t i = 0; i < schedule.subchains.size(); ++i) {
      const Millis promised = plan->subchains[i].execution;
      if (to_nanos(promised) > schedule.subchains[i].period) continue;
      ASSERT_GT(seen.runs(i), 100);
      EXPECT_LE(to_millis(seen.longest(i)).count(), promised.count() + 1e-3) << "seed " << seed << ", subchain " << i;
      ++compared;
    }
  }
  EXPECT_GT(compared, 800);
}

struct Compared {
  std::optional<plan::Plan> plan;   // none: no plan can be made of the schedule
  std::vector<std::size_t> chains;  // of it
};

// No response of a chain that has so many in so long takes longer than is promised.
Compared expect_held(const graph::App& app, const trial::Samples& samples, const model::CostTable& costs,
                     const trial::Schedule& schedule, Nanos horizon, int min_count, std::uint64_t seed) {
  Compared compared{planner::plan_of(app, samples, costs, schedule, 0.0), {}};
  if (!compared.plan) return compared;
  const auto seen = longest_in(app, samples, schedule, horizon);
  for (std::size_t chain = 0; chain < compared.plan->chains.size(); ++chain) {
    const Longest& found = seen->metrics().chains()[chain].response;
    if (found.count < min_count) continue;
    EXPECT_LE(to_millis(found.longest).count(), compared.plan->chains[chain].response.count() + 1e-3)
        << "seed " << seed;
    compared.chains.push_back(chain);
  }
  return compared;
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
    const Compared held = expect_held(of.app, constant(of.app, costs), costs, schedule, seconds{10}, 100, seed);
    compared += static_cast<int>(held.chains.size());
    for (const std::size_t chain : held.chains) {
      const plan::ChainPlan& promised = held.plan->chains[chain];
      Millis apart{0};
      for (const graph::ChainElement& element : of.app.graph.chain_elements(promised.path)) {
        const plan::SubchainPlan& planned = held.plan->subchains[element.subchain->index()];
        apart += planned.period + planned.execution;
      }
      apart -= held.plan->subchains[of.app.graph.chain_elements(promised.path).front().subchain->index()].period;
      if (promised.latency < apart - Millis{1.0}) ++in_step;
    }
  }
  EXPECT_GT(compared, 300);
  EXPECT_GT(in_step, 100) << "or nothing was tested";
}

// Each but the first, and but some that come at their own pace, is triggered by each so-many-th output of a
// predecessor: what follows takes the output that triggers it, so that no response takes longer than is promised, which
// is less than a period for each such input.
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
      if (i > 0 && random() % 3 == 0) {
        place.after.reset();
        place.period = to_nanos(Millis{uniform(8.0, 40.0)});
      }
      schedule.subchains.push_back(place);
    }
    compared += static_cast<int>(
        expect_held(of.app, constant(of.app, costs), costs, schedule, seconds{30}, 30, seed).chains.size());
  }
  EXPECT_GT(compared, 300) << "or nothing was tested";
}

// The first waits for a pause after each run, below all others; these are triggered by each so-many-th output of their
// predecessor. Of a run of theirs the first one's runs from one trigger to the next meet one: no response takes longer
// than is promised by that.
TEST(Promises, HoldForFollowersAboveALeaderThatWaitsForPauses) {
  int compared = 0;
  int shorter = 0;
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    std::mt19937_64 random(seed);
    const auto uniform = [&](double low, double high) { return low + (high - low) * fraction_of(random()); };
    const planner::RandomCase of = planner::random_case(seed, {.subchains = 4}, 1);
    const graph::Graph& graph = of.app.graph;
    model::CostTable costs(graph, Millis{0});
    trial::Schedule schedule{.cores = 1, .subchains = {}, .frames = {}, .pipelines = {}};
    for (std::size_t i = 0; i < graph.subchains().size(); ++i) {
      for (const NodeId node : graph.subchain(SubchainId(i)).nodes) {
        costs.set(node, model::CostProfile::constant(Millis{uniform(0.2, 6.0)}));
      }
      trial::Place place{.core = 0, .priority = 1 + static_cast<int>(i)};
      place.period = to_nanos(Millis{uniform(0.2, 2.0)});
      for (const NodeId predecessor : graph.node(graph.subchain(SubchainId(i)).head()).predecessors) {
        const auto leader = graph.node(predecessor).subchain;
        if (!leader || leader->index() >= i) continue;
        place.after = plan::After{*leader, 1 + static_cast<int>(random() % 4)};
      }
      if (!place.after) place.pause = to_nanos(Millis{uniform(0.1, 15.0)});
      schedule.subchains.push_back(place);
    }
    const Compared held = expect_held(of.app, constant(of.app, costs), costs, schedule, seconds{30}, 30, seed);
    compared += static_cast<int>(held.chains.size());
    if (!held.plan) continue;
    for (std::size_t i = 0; i < schedule.subchains.size(); ++i) {
      const trial::Place& place = schedule.subchains[i];
      if (!place.after) continue;
      const Millis led_by = held.plan->subchains[place.after->subchain()->index()].period;
      if (held.plan->subchains[i].period < place.after->every * led_by - Millis{1.0}) ++shorter;
    }
  }
  EXPECT_GT(compared, 300) << "or nothing was tested";
  EXPECT_GT(shorter, 100) << "or nothing was tested";
}

// Of those that follow others: from the output that triggers a run, or the end of their run before if that is later, to
// its end. Right of whoever is not kept back by a period.
class LongestFollowers : public trial::Observer {
 public:
  LongestFollowers(const graph::App& app, const trial::Schedule& schedule)
      : app_(app), schedule_(schedule), followers_(schedule.subchains.size()) {}
  void ended(const trial::ObservedRun& run) override {
    const SubchainId subchain = *app_.graph.node(run.node).subchain;
    if (run.node != app_.graph.subchain(subchain).tail()) return;
    Follower& own = followers_[subchain.index()];
    if (own.triggered) {
      own.longest.add(run.end - *own.triggered);
      own.triggered = std::exchange(own.due, false) ? std::optional(run.end) : std::nullopt;
    }
    for (std::size_t i = 0; i < followers_.size(); ++i) {
      const std::optional<plan::After>& after = schedule_.subchains[i].after;
      if (after && *after->subchain() == subchain) hear(followers_[i], after->every, run.end);
    }
  }
  const Longest& longest(std::size_t subchain) const { return followers_[subchain].longest; }

 private:
  struct Follower {
    int outputs = 0;  // since the last that triggers
    bool due = false;
    std::optional<TimePoint> triggered{};  // of the run under way
    Longest longest{};
  };
  static void hear(Follower& follower, int every, TimePoint output) {
    if (++follower.outputs < every) return;
    follower.outputs = 0;
    follower.due = follower.triggered.has_value();
    if (!follower.triggered) follower.triggered = output;
  }

  const graph::App& app_;
  const trial::Schedule& schedule_;
  std::vector<Follower> followers_;
};

// The first leads from below all others, each of which follows one before it, and may be kept back by a period; runs
// take what is planned, or less.
struct TurnsCase {
  explicit TurnsCase(std::uint64_t seed) : of(planner::random_case(seed, {.subchains = 5}, 1)) {
    std::mt19937_64 random(seed);
    const auto uniform = [&](double low, double high) { return low + (high - low) * fraction_of(random()); };
    const graph::Graph& graph = of.app.graph;
    runs.assign(graph.nodes().size(), std::vector<std::vector<model::RunTime>>(1));
    for (std::size_t node = 0; node < graph.nodes().size(); ++node) {
      if (!graph.nodes()[node].subchain) continue;
      const double cost = uniform(0.2, 3.0);
      round += cost;
      costs.set(NodeId(node), model::CostProfile::constant(Millis{cost}));
      for (int run = 0; run < 50; ++run) {
        runs[node][0].push_back({to_nanos(Millis{cost * uniform(0.2, 1.0)}), Nanos{0}});
      }
    }
    std::vector<int> priorities(graph.subchains().size() - 1);
    std::iota(priorities.begin(), priorities.end(), 2);
    std::shuffle(priorities.begin(), priorities.end(), random);
    trial::Place& leader = schedule.subchains.emplace_back(trial::Place{.priority = 1});
    leader.period = to_nanos(Millis{round * uniform(0.3, 1.5)});
    full = to_millis(leader.period).count() < round;
    if (random() % 2 == 0) {
      leader.pause = to_nanos(Millis{uniform(0.05, 2.0)});
      leader.period = std::chrono::microseconds{100};
    }
    for (std::size_t i = 1; i < graph.subchains().size(); ++i) {
      trial::Place& place = schedule.subchains.emplace_back(trial::Place{.priority = priorities[i - 1]});
      place.after = plan::After{SubchainId(random() % i), 1 + static_cast<int>(random() % 2)};
      place.period = std::chrono::microseconds{100};
      if (random() % 3 == 0) place.period = to_nanos(Millis{round * uniform(0.5, 2.0)});
    }
  }

  planner::RandomCase of;
  model::CostTable costs{of.app.graph, Millis{0}};
  trial::MeasuredRuns runs{};
  trial::Schedule schedule{.cores = 1, .subchains = {}, .frames = {}, .pipelines = {}};
  double round = 0.0;  // ms: a run of each
  bool full = false;   // the leader's period is shorter
};

// No run takes longer than is promised, however full the core is.
TEST(Promises, HoldForThoseThatTakeTurns) {
  int compared = 0;
  int full = 0;
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    const TurnsCase turns(seed);
    const trial::Schedule& schedule = turns.schedule;
    full += turns.full ? 1 : 0;
    const trial::Samples samples(turns.of.app, turns.runs, turns.costs);
    const std::optional<plan::Plan> plan = planner::plan_of(turns.of.app, samples, turns.costs, schedule, 0.0);
    ASSERT_TRUE(plan) << "seed " << seed;
    LongestFollowers seen(turns.of.app, schedule);
    watch(turns.of.app, samples, schedule, {.horizon = seconds{30}, .warm_up = Nanos{0}, .observer = &seen});
    for (std::size_t i = 1; i < schedule.subchains.size(); ++i) {
      if (schedule.subchains[i].period > std::chrono::microseconds{100} || seen.longest(i).count < 30) continue;
      EXPECT_LE(to_millis(seen.longest(i).longest).count(), plan->subchains[i].execution.count() + 1e-3)
          << "seed " << seed << ", subchain " << i;
      ++compared;
    }
  }
  EXPECT_GT(compared, 400) << "or nothing was tested";
  EXPECT_GT(full, 100);
}

// Nor does a response, whether an element follows the one before it in the chain or another.
TEST(Promises, HoldForChainsOfThoseThatTakeTurns) {
  int compared = 0;
  for (std::uint64_t seed = 1; seed <= 150; ++seed) {
    const TurnsCase turns(seed);
    for (const trial::MeasuredRuns& runs : {trial::MeasuredRuns{}, turns.runs}) {
      const trial::Samples samples(turns.of.app, runs, turns.costs);
      compared += static_cast<int>(
          expect_held(turns.of.app, samples, turns.costs, turns.schedule, seconds{20}, 30, seed).chains.size());
    }
  }
  EXPECT_GT(compared, 300) << "or nothing was tested";
}

}  // namespace
}  // namespace ctn
