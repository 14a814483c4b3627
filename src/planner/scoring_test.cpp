#include "planner/scoring.h"

#include <gtest/gtest.h>

#include <chrono>
#include <utility>
#include <vector>

#include "graph/build.h"
#include "graph/testing/spec_text.h"

namespace ctn::planner {
namespace {

using std::chrono::milliseconds;

// Two subchains; the response time of both weighs 2, the period of the second 1.
class ScoringTest : public ::testing::Test {
 protected:
  static graph::AppSpec spec() {
    graph::AppSpec spec = graph::spec_of({"a", "b"}, {"a b"});
    spec.objective = {graph::response("a b", 2.0), graph::period("b", 1.0)};
    return spec;
  }

  static trial::Schedule on_grid(int cores) {
    trial::Schedule schedule{.cores = cores, .subchains = std::vector<trial::Place>(2), .frames = {}, .pipelines = {}};
    for (int i = 0; i < 2; ++i) {
      trial::Place& place = schedule.subchains[static_cast<std::size_t>(i)];
      place.core = i % cores;
      place.priority = i + 1;
      place.period = milliseconds{20};
    }
    return schedule;
  }

  // Means of 10 and 20 ms, tails of 30 and 40.
  static trial::Figures figures(std::vector<double> busy) {
    trial::Figures figures;
    figures.objective = 40.0;
    figures.terms = {{.mean_ms = 10.0, .p95_ms = 30.0, .count = 100}, {.mean_ms = 20.0, .p95_ms = 40.0, .count = 100}};
    figures.busy = std::move(busy);
    return figures;
  }

  double unbounded(const trial::Schedule& schedule, const trial::Figures& figures) const {
    return scoring_.unbounded(schedule, figures, scoring_.use(schedule, figures));
  }

  static constexpr double kWeighted = 40.0 + kHeaviestTailWeight * 2.0 * 30.0 + kTailWeight * 40.0;

  graph::App app_ = graph::build_app(spec()).value();
  Scoring scoring_{app_, 0.06};
};

TEST_F(ScoringTest, TailsCountMostInTheResponseTimeThatWeighsMost) {
  EXPECT_DOUBLE_EQ(scoring_.of_term(figures({0.5}), 0), 10.0 + kHeaviestTailWeight * 30.0);
  EXPECT_DOUBLE_EQ(scoring_.of_term(figures({0.5}), 1), 20.0 + kTailWeight * 40.0);
  EXPECT_DOUBLE_EQ(unbounded(on_grid(1), figures({0.5})), kWeighted);
}

TEST_F(ScoringTest, ACoreIsFullWhereTheSlackBeginsAndALittleLater) {
  const CoreUse used = scoring_.use(on_grid(2), figures({0.945, 0.5}));
  EXPECT_EQ(used.by_core, (std::vector<double>{0.945, 0.5}));
  EXPECT_NEAR(used.fullest, 1.0, 1e-12);
  EXPECT_NEAR(used.overload, 0.0, 1e-12);
}

TEST_F(ScoringTest, WhatIsTooMuchOfAnyCoreIsWorseThanAnything) {
  const trial::Figures found = figures({0.955, 0.965});
  EXPECT_NEAR(scoring_.use(on_grid(2), found).fullest, 0.965 / 0.945, 1e-12);
  EXPECT_NEAR(scoring_.use(on_grid(2), found).overload, 0.03, 1e-12);
  EXPECT_GT(unbounded(on_grid(2), found), 0.029 * overload_score(app_));
  EXPECT_NEAR(scoring_.at_a_glance(on_grid(2), found), kWeighted * 1.03, 1e-9) << "in a short trial, which is luck";
}

// Guards: with weights of 10^8 any schedule was as bad as one that cannot be had.
TEST_F(ScoringTest, OnlyRatiosOfWeightsMatter) {
  graph::AppSpec heavy = spec();
  for (graph::TermSpec& term : heavy.objective) term.weight.value *= 1e8;
  const graph::App app = graph::build_app(heavy).value();
  EXPECT_NEAR(overload_score(app), 1e8 * overload_score(app_), 1e-6 * overload_score(app));
  EXPECT_NEAR(overload_score(app_), 3e9, 1.0);
}

// As the threads of a pipeline go where there is room.
TEST_F(ScoringTest, CoresOfAPipelineAreAsFullAsTheyAreOnAverage) {
  trial::Schedule schedule = on_grid(3);
  schedule.subchains[0].form = trial::Form::kPipeline;
  schedule.pipelines = {{.subchain = SubchainId(0), .cores = {0, 2}, .threads = 1, .pacing = {}}};
  EXPECT_EQ(scoring_.use(schedule, figures({1.0, 0.2, 0.5})).by_core, (std::vector<double>{0.75, 0.2, 0.75}));
}

TEST_F(ScoringTest, ACoreThatIsNearlyFullNeedsAGap) {
  trial::Schedule schedule = on_grid(1);
  const trial::Figures found = figures({0.92});
  EXPECT_GT(unbounded(schedule, found), kWeighted);
  EXPECT_DOUBLE_EQ(unbounded(schedule, figures({0.85})), kWeighted) << "with much to spare there are gaps anyway";
  schedule.subchains[0].after = plan::After{SubchainId(1), 1};
  EXPECT_GT(unbounded(schedule, found), kWeighted) << "its leader keeps to the grid";
  schedule.subchains[1].pause = milliseconds{5};
  EXPECT_DOUBLE_EQ(unbounded(schedule, found), kWeighted);
}

}  // namespace
}  // namespace ctn::planner
