// The paper's planner over random apps, against brute force: all allocations for stage I, all whole numbers for stage
// II, both by the formulas of the model module.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "base/numbers.h"
#include "model/evaluate.h"
#include "model/formulas.h"
#include "paper/equal_shares.h"
#include "paper/paper.h"
#include "paper/problem.h"
#include "paper/stage_one.h"
#include "paper/stage_two.h"
#include "plan/json.h"
#include "plan/limits.h"
#include "plan/validate.h"
#include "planner/testing/brute_force.h"
#include "planner/testing/random_apps.h"

namespace ctn::paper {
namespace {

using planner::BruteForce;
using planner::random_case;
using planner::RandomCase;
using planner::RandomLimits;

constexpr std::size_t kSteps = 4'000'000;

// Exact rates, where they may be missed, come first, then bounds.
struct Value {
  double exact = kInfinity;
  double factor = kInfinity;
  double objective = kInfinity;

  void take(const Value& other) {
    const auto same = [](double a, double b) { return std::abs(a - b) <= 1e-9 * b; };
    if (!same(other.exact, exact)) {
      if (other.exact < exact) *this = other;
    } else if (same(other.factor, factor) ? other.objective < objective : other.factor < factor) {
      *this = other;
    }
  }
};

Value value_of(const RandomCase& any, const std::vector<model::SubchainTiming>& timings) {
  Value value{1.0, 1.0, 0.0};
  for (const graph::Term& term : any.app.objective) {
    const double ms = term.metric == graph::Metric::kPeriod
                          ? model::evaluate_period(any.app.graph, term.path.front(), timings).count()
                          : model::evaluate_chain(any.app.graph, term.path, any.costs, timings).response.count();
    value.objective += term.weight * ms;
    if (term.max) value.factor = std::max(value.factor, ms / to_millis(*term.max).count());
  }
  for (const graph::Node& node : any.app.graph.nodes()) {
    if (!node.subchain || !node.min_rate) continue;
    double& factor = node.max_rate && *node.min_rate == *node.max_rate ? value.exact : value.factor;
    factor = std::max(factor, timings[node.subchain->index()].period / node.min_rate->period());
  }
  return value;
}

model::SubchainTiming owned(const RandomCase& any, std::size_t i, const model::CostTable& costs, int cores) {
  const SubchainId id(i);
  const plan::PeriodLimits limits = plan::period_limits(any.app.graph, id);
  model::SubchainTiming best;
  double min = kInfinity;
  for (int q = 1; q <= cores; ++q) {
    const model::OwnedCores found = model::owned_cores_with(any.app.graph, id, costs, cores, q, any.slack);
    const Millis period = std::max(found.period, limits.min);
    if ((period + found.execution).count() >= min) continue;
    min = (period + found.execution).count();
    best = {period, found.execution, {}};
  }
  return best;
}

// Every way to put subchains on cores, with equal shares.
class AllAllocations {
 public:
  explicit AllAllocations(const RandomCase& any)
      : any_(any),
        costs_(model::costs_by_kind(any.app, any.costs)),
        free_(any.app.cores_by_kind(any.cores)),
        group_(any.app.graph.subchains().size()),
        timings_(group_.size()) {}

  Value run() {
    put(0);
    return best_;
  }

 private:
  void put(std::size_t i) {
    if (i == group_.size()) return own(0);
    for (std::size_t g = 0; g < kinds_.size(); ++g) {
      group_[i] = g;
      put(i + 1);
    }
    for (std::size_t kind = 0; kind < free_.size(); ++kind) {
      if (free_[kind] == 0) continue;
      --free_[kind];
      group_[i] = kinds_.size();
      kinds_.push_back(kind);
      put(i + 1);
      kinds_.pop_back();
      ++free_[kind];
    }
  }

  void own(std::size_t i) {
    if (i == group_.size()) return best_.take(value_of(any_, timings_));
    const std::size_t kind = kinds_[group_[i]];
    const auto rivals = std::count(group_.begin(), group_.end(), group_[i]);
    const SubchainId id(i);
    if (rivals > 1) {
      const Millis equal =
          static_cast<double>(rivals) * costs_[kind].subchain_total(any_.app.graph, id) / (1.0 - any_.slack);
      const Millis period = std::max(equal, plan::period_limits(any_.app.graph, id).min);
      timings_[i] = {period, period, {}};
      return own(i + 1);
    }
    const int spare = free_[kind];
    for (int k = 1; k <= 1 + spare; ++k) {
      free_[kind] = spare + 1 - k;
      timings_[i] = owned(any_, i, costs_[kind], k);
      own(i + 1);
    }
    free_[kind] = spare;
  }

  const RandomCase& any_;
  const std::vector<model::CostTable> costs_;
  std::vector<int> free_;  // cores, by kind
  std::vector<std::size_t> group_;
  std::vector<std::size_t> kinds_;  // by group
  std::vector<model::SubchainTiming> timings_;
  Value best_;
};

// Every whole number for an allocation, without queue nodes. Nothing is found where exact rates cannot be met.
class AllNumbers {
 public:
  AllNumbers(const RandomCase& any, const plan::Plan& plan)
      : any_(any), plan_(plan), costs_(model::costs_by_kind(any.app, any.costs)), timings_(plan.subchains.size()) {}

  Value run() {
    core(0);
    return best_;
  }

 private:
  double cost(SubchainId id, std::size_t core) const {
    return costs_[any_.app.kind_of(static_cast<int>(core))].subchain_total(any_.app.graph, id).count();
  }

  void core(std::size_t number) {
    if (number == plan_.cores.size()) {
      for (std::size_t i = 0; i < timings_.size(); ++i) {
        if (plan::shares_core(plan_, plan_.subchains[i])) continue;
        timings_[i] = {plan_.subchains[i].period, plan_.subchains[i].execution, {}};
      }
      return best_.take(value_of(any_, timings_));
    }
    if (plan_.cores[number].slots.empty()) return core(number + 1);
    std::vector<int> every;
    choose(number, every);
  }

  void choose(std::size_t number, std::vector<int>& every) {
    const std::vector<plan::Slot>& slots = plan_.cores[number].slots;
    if (every.size() == slots.size()) return frame(number, every);
    const double slices = cost(slots[every.size()].subchain, number) / to_millis(any_.app.scheduler.min_slice).count();
    const int max = std::max(1, static_cast<int>(std::floor(slices * (1.0 + 1e-12))));
    for (int n = 1; n <= max; ++n) {
      every.push_back(n);
      choose(number, every);
      every.pop_back();
    }
  }

  void frame(std::size_t number, const std::vector<int>& every) {
    const std::vector<plan::Slot>& slots = plan_.cores[number].slots;
    double shortest = 0.0;
    double min = 0.0;
    std::optional<double> exact;
    for (std::size_t m = 0; m < slots.size(); ++m) {
      const plan::PeriodLimits limits = plan::period_limits(any_.app.graph, slots[m].subchain);
      shortest += cost(slots[m].subchain, number) / every[m] / (1.0 - any_.slack);
      min = std::max(min, limits.min.count() / every[m]);
      if (!limits.exact) continue;
      const double given = limits.exact->count() / every[m];
      if (exact && std::abs(*exact - given) > 1e-9 * given) return;
      exact = given;
    }
    shortest = std::max(shortest, min);
    if (exact && shortest > *exact * (1.0 + 1e-9)) return;
    for (std::size_t m = 0; m < slots.size(); ++m) {
      const Millis period{exact.value_or(shortest) * every[m]};
      timings_[slots[m].subchain.index()] = {period, period, {}};
    }
    core(number + 1);
  }

  const RandomCase& any_;
  const plan::Plan& plan_;
  const std::vector<model::CostTable> costs_;
  std::vector<model::SubchainTiming> timings_;
  Value best_;
};

std::optional<plan::Plan> valid_plan(const RandomCase& any, const Request& given = {}) {
  Request request = given;
  request.cores = any.cores;
  request.slack = any.slack;
  const graph::App app = as_in_the_paper(any.app);
  const auto plan = make_plan(app, any.costs, request);
  if (!plan) {
    EXPECT_TRUE(plan::has_exact_rates(any.app.graph)) << plan.error().message();
    return std::nullopt;
  }
  const Status valid = plan::validate(*plan, app, any.costs, any.cores);
  EXPECT_TRUE(valid.ok()) << (valid.ok() ? "" : valid.error().message());
  EXPECT_EQ(plan->planner, "paper");
  for (const plan::CorePlan& core : plan->cores) EXPECT_EQ(core.frames, graph::FrameMode::kFixed);
  return *plan;
}

// Of a plan in which no run waits; what it promises of queue nodes may be more (plan/predict.h).
std::vector<model::SubchainTiming> timings_of_the_paper(const plan::Plan& plan) {
  std::vector<model::SubchainTiming> timings;
  for (const plan::SubchainPlan& planned : plan.subchains) {
    timings.push_back({planned.period, plan::shares_core(plan, planned) ? planned.period : planned.execution, {}});
  }
  return timings;
}

void compare_stage_one(const RandomLimits& limits, std::uint64_t apps) {
  int relaxed = 0;
  for (std::uint64_t seed = 1; seed <= apps; ++seed) {
    SCOPED_TRACE(seed);
    const RandomCase any = random_case(seed, limits, 1 + static_cast<int>(seed % 4));
    const Value best = AllAllocations(any).run();
    const Problem problem = make_problem(any.app, any.costs, any.cores, any.slack);
    const StageOne stage = allocate_cores(problem, kSteps);
    EXPECT_EQ(stage.gap, 0.0);
    EXPECT_NEAR(stage.factor, best.factor, 1e-9 * best.factor);
    EXPECT_NEAR(stage.objective, best.objective, 1e-9 * best.objective);
    EXPECT_NEAR(objective_of(problem.terms, equal_shares(problem, stage.allocation)), stage.objective,
                1e-12 * stage.objective);
    relaxed += best.factor > 1.0 ? 1 : 0;
  }
  EXPECT_TRUE(!limits.bounds || relaxed > 0);
}

TEST(PaperProperty, StageOneIsWhatBruteForceFinds) {
  compare_stage_one({.subchains = 6, .chains = 6, .pairs = true}, 60);
  compare_stage_one({.subchains = 5, .zeros = true}, 40);
}

TEST(PaperProperty, StageOneIsWhatBruteForceFindsWithBoundsAndRates) {
  compare_stage_one({.subchains = 5, .caps = true, .bounds = true, .pairs = true}, 80);
  compare_stage_one({.subchains = 5, .exact = true, .bounds = true}, 60);
}

TEST(PaperProperty, StageOneIsWhatBruteForceFindsOnCoresThatDiffer) {
  compare_stage_one({.subchains = 4, .caps = true, .bounds = true, .pairs = true, .kinds = true}, 60);
}

void compare_stage_two(const RandomLimits& limits, std::uint64_t apps) {
  std::uint64_t shared = 0;
  std::uint64_t relaxed = 0;
  for (std::uint64_t seed = 1; seed <= apps; ++seed) {
    SCOPED_TRACE(seed);
    const RandomCase any = random_case(seed, limits, 1 + static_cast<int>(seed % 3));
    const std::optional<plan::Plan> plan = valid_plan(any);
    if (!plan) continue;
    const Value best = AllNumbers(any, *plan).run();
    EXPECT_EQ(plan->quality, plan::Quality::kOptimal) << plan->gap;
    EXPECT_NEAR(plan->relax_factor, best.factor, 1e-8 * best.factor);
    EXPECT_NEAR(plan->objective, best.objective, 1e-8 * best.objective);
    relaxed += best.factor > 1.0 ? 1 : 0;
    shared += std::any_of(plan->cores.begin(), plan->cores.end(), [](const auto& core) { return !core.slots.empty(); });
  }
  EXPECT_GT(shared, apps / 3) << "else nothing was compared";
  EXPECT_TRUE(!limits.bounds || relaxed > apps / 20) << relaxed;
}

TEST(PaperProperty, StageTwoIsWhatBruteForceFinds) {
  compare_stage_two({.subchains = 5, .max_cost = 7.0}, 150);
  compare_stage_two({.subchains = 3, .min_cost = 2.0, .max_cost = 60.0}, 100);
  compare_stage_two({.subchains = 5, .max_cost = 7.0, .zeros = true, .pairs = true}, 60);
}

TEST(PaperProperty, StageTwoIsWhatBruteForceFindsWithBoundsAndRates) {
  compare_stage_two({.max_cost = 7.0, .caps = true, .pairs = true}, 150);
  compare_stage_two({.max_cost = 7.0, .caps = true, .bounds = true}, 150);
  compare_stage_two({.max_cost = 7.0, .exact = true}, 100);
  compare_stage_two({.max_cost = 7.0, .exact = true, .bounds = true}, 100);
}

TEST(PaperProperty, StageTwoIsWhatBruteForceFindsOnCoresThatDiffer) {
  compare_stage_two({.max_cost = 7.0, .caps = true, .bounds = true, .kinds = true}, 100);
}

// On one core there is just one allocation. The brute force finds free shares by narrowing down, to so many digits.
TEST(PaperProperty, StageTwoIsWhatBruteForceFindsWithAQueue) {
  for (std::uint64_t seed = 1; seed <= 80; ++seed) {
    SCOPED_TRACE(seed);
    const bool bounds = seed % 4 == 0;
    const RandomCase any =
        random_case(seed, {.subchains = 4, .max_cost = 5.0, .queue = true, .caps = seed % 2 == 0, .bounds = bounds}, 1);
    const std::optional<plan::Plan> plan = valid_plan(any);
    ASSERT_TRUE(plan);
    const BruteForce::Best best = BruteForce(any).run();
    const Value found = value_of(any, timings_of_the_paper(*plan));
    EXPECT_NEAR(found.factor, best.factor, 1e-6 * best.factor);
    EXPECT_NEAR(found.objective, best.objective, (bounds ? 1e-5 : 1e-7) * best.objective);
    EXPECT_GE(plan->objective, found.objective * (1.0 - 1e-9));
  }
}

TEST(PaperProperty, EverythingIsPlannedAndValid) {
  for (std::uint64_t seed = 1; seed <= 120; ++seed) {
    SCOPED_TRACE(seed);
    RandomLimits limits{.subchains = 2 + static_cast<int>(seed % 9), .min_cost = 0.1, .max_cost = 100.0};
    limits.chains = limits.subchains;
    limits.all_queues = seed % 5 == 0;
    limits.zeros = seed % 3 == 0;
    limits.queue = seed % 2 == 0;
    limits.caps = seed % 4 < 2;
    limits.exact = seed % 7 == 0;
    limits.bounds = seed % 3 < 2;
    limits.pairs = seed % 2 == 1;
    limits.kinds = seed % 6 == 0;
    const RandomCase any = random_case(seed, limits, 1 + static_cast<int>(seed % 8));
    const std::optional<plan::Plan> plan = valid_plan(any, {.steps = 200'000});
    if (!plan) continue;
    // Again on the same cores, as it is done every 5 s, and after a lasting change.
    RandomCase other = any;
    for (std::size_t i = 0; i < any.app.graph.nodes().size(); ++i) {
      const double factor = 0.7 + 0.1 * static_cast<double>((seed + i) % 7);
      if (!any.app.graph.node(NodeId(i)).external) other.costs.set(NodeId(i), any.costs[NodeId(i)].times(factor));
    }
    const std::optional<plan::Plan> again = valid_plan(other, {.steps = 200'000, .allocated = &*plan});
    if (!again) continue;
    for (std::size_t i = 0; i < plan->subchains.size(); ++i) {
      EXPECT_EQ(plan->subchains[i].cores.size(), again->subchains[i].cores.size());
      EXPECT_EQ(plan::shares_core(*plan, plan->subchains[i]), plan::shares_core(*again, again->subchains[i]));
    }
  }
}

// The same cores and shares, whatever frames the app asks for.
TEST(PaperProperty, ElasticFramesArePlannedAndValid) {
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE(seed);
    const RandomLimits limits{.subchains = 2 + static_cast<int>(seed % 6),
                              .queue = seed % 2 == 0,
                              .caps = true,
                              .exact = seed % 4 == 0,
                              .bounds = seed % 3 == 0,
                              .pairs = true,
                              .kinds = seed % 5 == 0,
                              .waits = seed % 3 == 1};
    const RandomCase any = random_case(seed, limits, 1 + static_cast<int>(seed % 3));
    const std::optional<plan::Plan> fixed = valid_plan(any, {.steps = 50'000});
    const auto elastic = make_plan(any.app, any.costs, {.cores = any.cores, .slack = any.slack, .steps = 50'000});
    ASSERT_EQ(elastic.ok(), fixed.has_value());
    if (!elastic) continue;
    const Status valid = plan::validate(*elastic, any.app, any.costs, any.cores);
    EXPECT_TRUE(valid.ok()) << (valid.ok() ? "" : valid.error().message());
    EXPECT_EQ(elastic->subchains, fixed->subchains);
    EXPECT_EQ(elastic->objective, fixed->objective);
  }
}

TEST(PaperProperty, IsExactForAppsLargerThanThePapers) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE(seed);
    const RandomCase any =
        random_case(seed, {.subchains = 12, .chains = 12, .max_cost = 20.0, .queue = true, .pairs = true}, 8);
    const std::optional<plan::Plan> plan = valid_plan(any);
    ASSERT_TRUE(plan);
    EXPECT_EQ(plan->quality, plan::Quality::kOptimal) << plan->gap;
  }
}

TEST(PaperProperty, LargeAppsArePlannedWithAnHonestGap) {
  const RandomCase any = random_case(1, {.subchains = 100, .chains = 100, .max_cost = 20.0, .pairs = true}, 24);
  const std::optional<plan::Plan> plan = valid_plan(any, {.steps = 100'000});
  ASSERT_TRUE(plan);
  EXPECT_EQ(plan->quality, plan::Quality::kFeasible);
  EXPECT_GT(plan->gap, 0.0);
  EXPECT_LT(plan->gap, 0.2);
}

TEST(PaperProperty, WithoutAnyEffortThereIsAPlanAllTheSame) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    const RandomCase any = random_case(seed, {.subchains = 6, .caps = true, .bounds = true}, 3);
    EXPECT_TRUE(valid_plan(any, {.steps = 1}));
  }
}

}  // namespace
}  // namespace ctn::paper
