#include "record/run_metrics.h"

#include <gtest/gtest.h>

#include <vector>

#include "base/testing/times.h"
#include "graph/build.h"
#include "graph/testing/spec_text.h"

namespace ctn::record {
namespace {

using std::chrono::milliseconds;

struct All {
  void add(Nanos sample) { samples.push_back(sample); }
  Summary summary_ms() const {
    std::vector<double> all;
    for (const Nanos sample : samples) all.push_back(to_millis(sample).count());
    return summarize(std::move(all));
  }
  std::vector<Nanos> samples;
};

graph::App feeding(graph::InputKind input, bool external) {
  graph::AppSpec spec = graph::spec_of({"from", "to"}, {"from to"});
  graph::node(spec, "to").input = input;
  graph::node(spec, "from").external = external;
  spec.objective = {graph::period("to", 1.0)};
  return graph::build_app(spec).value();
}

// The periods that count where runs of `to` end at 10, 20, ..., and only those at 20 and 50 found something.
std::vector<Nanos> periods_of(const graph::App& app) {
  RunMetrics<All> metrics(app, {.begin = at_ms(0)});
  const NodeId to = *app.graph.find_node("to");
  for (int number = 1; number <= 5; ++number) {
    Run run;
    run.node = to;
    run.number = static_cast<std::uint64_t>(number);
    run.begin = at_ms(10 * number - 1);
    run.end = at_ms(10 * number);
    if (number % 3 == 2) run.consumed = {{*app.graph.find_node("from"), run.number, run.number}};
    metrics.add(run);
  }
  EXPECT_EQ(metrics.node(to).runs, 5U) << "they have run, whatever they found";
  return metrics.node(to).period.samples;
}

TEST(RunMetrics, ThePeriodOfAQueueNodeIsOfRunsThatHadAnInput) {
  EXPECT_EQ(periods_of(feeding(graph::InputKind::kQueue, false)), (std::vector<Nanos>{milliseconds{30}}));
}

TEST(RunMetrics, TheObjectiveIsOfWhatWasMeasured) {
  const graph::App app = feeding(graph::InputKind::kLatest, false);
  RunMetrics<All> metrics(app, {.begin = at_ms(0)});
  record::Run run;
  run.node = *app.graph.find_node("to");
  run.number = 1;
  run.end = at_ms(10);
  metrics.add(run);
  EXPECT_FALSE(metrics.objective(app)) << "there is no period yet";
  run.number = 2;
  run.end = at_ms(40);
  metrics.add(run);
  EXPECT_EQ(metrics.objective(app), 30.0);
}

TEST(RunMetrics, OfAllOthersEachRunCounts) {
  const std::vector<Nanos> each(4, milliseconds{10});
  EXPECT_EQ(periods_of(feeding(graph::InputKind::kLatest, false)), each);
  EXPECT_EQ(periods_of(feeding(graph::InputKind::kQueue, true)), each) << "what it found is not known";
}

}  // namespace
}  // namespace ctn::record
