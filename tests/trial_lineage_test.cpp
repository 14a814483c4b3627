// The terms of a trial (src/trial) beside what the lineage of a record makes of its runs.
#include <gtest/gtest.h>

#include <chrono>
#include <random>
#include <stdexcept>
#include <vector>

#include "graph/build.h"
#include "graph/testing/spec_text.h"
#include "sim/clocks.h"
#include "trial/trial.h"
#include "trial_runs.h"

namespace ctn {
namespace {

using std::chrono::seconds;

struct Total {
  void add(Nanos value) {
    total += static_cast<double>(value.count());
    ++count;
  }
  double total = 0.0;
  std::size_t count = 0;
};

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

constexpr std::uint64_t kDrawSeed = 7;

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
  const trial::Samples samples(app, varying(app, costs), Nanos{0}, kDrawSeed);
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
    if (sum.count < trial::kMinSamples) continue;
    EXPECT_NEAR(figures.terms[term].mean_ms, sum.total / static_cast<double>(sum.count) / 1e6, 1e-9)
        << app.graph.path_name(of.path);
    samples_seen += sum.count;
  }
  EXPECT_GT(samples_seen, 1000U);
}

INSTANTIATE_TEST_SUITE_P(RandomSchedules, TrialLineage, ::testing::Range(0, 40));

}  // namespace
}  // namespace ctn
