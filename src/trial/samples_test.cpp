#include "trial/samples.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "graph/build.h"
#include "graph/testing/spec_text.h"

namespace ctn::trial {
namespace {

graph::App two_kinds() {
  graph::AppSpec spec = graph::spec_of({"a", "b"}, {"a b"});
  spec.objective = {graph::response("a b", 1.0)};
  spec.core_kinds.push_back({{"fast", {}}, {1, {}}, {2.0, {}}});
  spec.core_kinds.push_back({{"slow", {}}, {1, {}}, {0.5, {}}});
  graph::node(spec, "b").max_threads = graph::At<int>{4, {}};
  return graph::build_app(spec).value();
}

constexpr NodeId kA{0};
constexpr NodeId kB{1};
constexpr std::size_t kFastKind = 0;
constexpr std::size_t kSlowKind = 1;

TEST(Samples, OfAWorkloadAreItsDrawsAtThatTime) {
  const graph::App app = two_kinds();
  model::Workload work(app.graph);
  work.set(kA, {model::CostProfile::constant(Millis{4}), {Millis{2}}, 0.1, {0.1, Millis{5}}});
  const Samples samples(app, work, std::chrono::seconds{10}, 3);
  for (std::uint32_t run = 0; run < 100; ++run) {
    EXPECT_EQ(samples.draw(kA, kSlowKind, run),
              work.on(app, kSlowKind).draw(3, kA, run + 1, std::chrono::seconds{10}).cpu);
  }
  EXPECT_EQ(samples.draw(kA, kFastKind, 5), samples.draw(kA, kFastKind, 5 + Samples::kDraws));
}

TEST(Samples, RunsThatCostNothingTakeTimeAllTheSame) {
  const graph::App app = two_kinds();
  const Samples samples(app, model::Workload(app.graph), Nanos{0}, 1);
  EXPECT_GT(samples.draw(kA, kFastKind, 0), Nanos{0});
}

TEST(Samples, OfMeasuredRunsAreThoseRunsWhereTheyRan) {
  const graph::App app = two_kinds();
  const model::CostTable costs(app.graph, Millis{3});
  const std::vector<model::RunTime> runs{{Nanos{100}}, {Nanos{200}}, {Nanos{300}}, {Nanos{400}}};
  const Samples samples(app, {{{}, runs}}, costs);
  std::vector<int> seen(5, 0);
  for (std::uint32_t run = 0; run < Samples::kDraws; ++run) {
    ++seen[static_cast<std::size_t>(samples.draw(kA, kSlowKind, run).count() / 100)];
    // Four times as fast there.
    EXPECT_EQ(4 * samples.draw(kA, kFastKind, run), samples.draw(kA, kSlowKind, run));
  }
  for (int run = 1; run <= 4; ++run) EXPECT_NEAR(seen[static_cast<std::size_t>(run)], Samples::kDraws / 4.0, 150.0);
}

TEST(Samples, AWaitStaysWithItsRunAndIsTheSameOnAllKindsOfCores) {
  const graph::App app = two_kinds();
  const std::vector<model::RunTime> runs{{Nanos{100}, Nanos{7}}, {Nanos{200}, Nanos{0}}};
  const Samples samples(app, {{{}, runs}}, model::CostTable(app.graph, Millis{3}));
  EXPECT_TRUE(samples.waits(kA) && samples.any_waits() && !samples.waits(kB));
  for (std::uint32_t run = 0; run < 100; ++run) {
    EXPECT_EQ(samples.wait(kA, run), samples.draw(kA, kSlowKind, run) == Nanos{100} ? Nanos{7} : Nanos{0});
  }
  EXPECT_EQ(samples.wait(kB, 1), Nanos{0});
}

TEST(Samples, ANodeThatNeverRanCostsWhatIsPlanned) {
  const graph::App app = two_kinds();
  const Samples samples(app, MeasuredRuns{}, model::CostTable(app.graph, Millis{3}));
  EXPECT_EQ(samples.draw(kB, kFastKind, 0), to_nanos(Millis{1.5}));
  EXPECT_EQ(samples.draw(kB, kSlowKind, 7), to_nanos(Millis{6}));
}

TEST(Samples, SplitsARunAsItsProfileSays) {
  const graph::App app = two_kinds();
  model::CostTable costs(app.graph, Millis{3});
  costs.set(kA, model::CostProfile::of_threads({{1, Millis{8}}}));
  const Samples even(app, MeasuredRuns{}, costs);
  EXPECT_EQ(even.split(kB, kFastKind, 3).threads, 3);
  EXPECT_NEAR(even.split(kB, kFastKind, 3).part, 1.0 / 3.0, 1e-12);
  EXPECT_EQ(even.split(kA, kFastKind, 3).threads, 1);
  EXPECT_EQ(even.split(kA, kFastKind, 3).part, 1.0);
  costs.set(kB, model::CostProfile::of_threads({{1, Millis{8}}, {2, Millis{5}}}));
  const Samples measured(app, MeasuredRuns{}, costs);
  EXPECT_EQ(measured.split(kB, kFastKind, 3).threads, 2);
  EXPECT_NEAR(measured.split(kB, kFastKind, 3).part, 5.0 / 8.0, 1e-12);
  costs.set(kB, model::CostProfile::constant(Millis{8}).with_measured({{3, Millis{7}}}));
  const Samples partly(app, MeasuredRuns{}, costs);
  EXPECT_EQ(partly.split(kB, kFastKind, 3).threads, 3);
  EXPECT_NEAR(partly.split(kB, kFastKind, 3).part, 7.0 / 8.0, 1e-12);
  EXPECT_NEAR(partly.split(kB, kFastKind, 2).part, 1.0 / 2.0, 1e-12) << "has not run";
}

}  // namespace
}  // namespace ctn::trial
