#include "planner/moves.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "plan/limits.h"
#include "planner/random_apps.h"

namespace ctn::planner {
namespace {

TEST(Random, IsTheSameEverywhere) {
  Random random(7);
  EXPECT_EQ(random.below(1000), 221U);
  EXPECT_EQ(random.below(1000), 174U);
  EXPECT_DOUBLE_EQ(random.fraction(), 0.54937432491932392);
}

RC_GTEST_PROP(MovesProperty, KeepASchedulePossibleWhateverTheyDo, (std::uint64_t seed)) {
  const int cores = 1 + static_cast<int>(seed % 3);
  const RandomCase random = random_case(seed, {.subchains = 5, .caps = true, .exact = true, .pairs = true}, cores);
  const graph::App& app = random.app;
  const std::size_t count = app.graph.subchains().size();
  const Pipelines pipelines(app, trial::Samples(app, trial::MeasuredRuns(app.graph.nodes().size()), random.costs),
                            random.costs, 0.06);
  const Moves moves(app, std::vector<double>(count, 3.0), pipelines, cores);
  trial::Schedule schedule{
      .cores = cores, .subchains = std::vector<trial::Place>(count), .frames = {}, .pipelines = {}};
  for (std::size_t i = 0; i < count; ++i) {
    schedule.subchains[i].priority = static_cast<int>(i) + 1;
    schedule.subchains[i].period = std::max(moves.shortest_period(i), Nanos{std::chrono::milliseconds{20}});
    if (moves.exact(i)) schedule.subchains[i].period = moves.shortest_period(i);
  }
  Random chance(seed);
  bool any_pipeline = false;
  for (int step = 0; step < 2000; ++step) {
    moves.change(schedule, chance);
    any_pipeline = any_pipeline || !schedule.pipelines.empty();
  }
  RC_CLASSIFY(any_pipeline, "with pipelines");
  std::vector<int> owners(static_cast<std::size_t>(cores), 0);
  for (const trial::Pipeline& pipeline : schedule.pipelines) {
    RC_ASSERT(pipeline.cores.size() > 1U);
    RC_ASSERT(schedule.subchains[pipeline.subchain.index()].form == trial::Form::kPipeline);
    for (const int core : pipeline.cores) RC_ASSERT(++owners.at(static_cast<std::size_t>(core)) == 1);
  }
  std::size_t in_pipelines = 0;
  std::vector<int> priorities;
  for (std::size_t i = 0; i < count; ++i) {
    const trial::Place& place = schedule.subchains[i];
    const plan::PeriodLimits limits = plan::period_limits(app.graph, SubchainId(i));
    if (place.form == trial::Form::kPipeline) {
      ++in_pipelines;
      continue;
    }
    RC_ASSERT(owners.at(static_cast<std::size_t>(place.core)) == 0);
    priorities.push_back(place.priority);
    RC_ASSERT(place.core >= 0 && place.core < cores);
    RC_ASSERT(!(place.pause && place.after));
    RC_ASSERT(place.period >= to_nanos(limits.min));
    if (limits.exact) RC_ASSERT(place.period == to_nanos(*limits.exact) && !place.pause && !place.after);
    RC_ASSERT(place.phase == Nanos{0} || place.phase < place.period);
    std::size_t at = i;
    for (std::size_t steps = 0; schedule.subchains[at].after; ++steps) {
      RC_ASSERT(steps <= count);
      at = schedule.subchains[at].after->subchain.index();
    }
  }
  RC_ASSERT(in_pipelines == schedule.pipelines.size());
  std::sort(priorities.begin(), priorities.end());
  RC_ASSERT(std::adjacent_find(priorities.begin(), priorities.end()) == priorities.end());
}

}  // namespace
}  // namespace ctn::planner
