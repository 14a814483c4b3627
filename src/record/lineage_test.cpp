#include "record/lineage.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "base/testing/times.h"
#include "graph/build.h"

namespace ctn::record {
namespace {

using std::chrono::milliseconds;

struct TestNode {
  std::string name;
  bool queue = false;
  bool external = false;
  int period_ms = 0;  // of a clock
};

// A path of nodes, each a subchain of its own.
graph::App path_app(const std::vector<TestNode>& nodes) {
  graph::AppSpec spec;
  spec.name.value = "test";
  graph::PathSpec path;
  for (const TestNode& node : nodes) {
    graph::NodeSpec written;
    written.name.value = node.name;
    written.input = node.queue ? graph::InputKind::kQueue : graph::InputKind::kLatest;
    written.external = node.external;
    if (node.period_ms > 0) written.period = graph::At<Nanos>{milliseconds{node.period_ms}, {}};
    spec.nodes.push_back(written);
    path.nodes.push_back({node.name, {}});
  }
  if (nodes.size() > 1) spec.edges.push_back(path);
  graph::TermSpec term;
  term.path = path.nodes;
  term.weight.value = 1.0;
  spec.objective.push_back(term);
  auto app = graph::build_app(spec);
  EXPECT_TRUE(app.ok()) << (app ? "" : app.error().message());
  return *app;
}

// A tracker over a path, fed with runs of nodes by name; times in ms.
class Chain {
 public:
  explicit Chain(const std::vector<TestNode>& nodes) : app_(path_app(nodes)), tracker_(app_.graph, path()) {}

  std::vector<NodeId> path() const { return app_.objective.front().path; }
  NodeId id(const std::string& name) const { return *app_.graph.find_node(name); }

  // The next run of a node; it consumed runs first..last of the node before, 0: nothing.
  std::vector<ChainSample> run(const std::string& name, int begin, int end, std::uint64_t first = 0,
                               std::uint64_t last = 0, bool emitted = true) {
    Run run;
    run.node = id(name);
    run.number = ++count_[name];
    run.begin = at_ms(begin);
    run.end = at_ms(end);
    run.emitted = emitted;
    if (first > 0) {
      run.consumed.push_back({app_.graph.node(run.node).predecessors.front(), first, last == 0 ? first : last});
    }
    return tracker_.add(run);
  }

  std::vector<std::uint64_t> path_of(std::uint64_t source_run) const { return tracker_.path_of(source_run); }

  void set_clock(const std::string& name, int tick, int period) {
    tracker_.set_clock(id(name), {at_ms(tick), milliseconds{period}});
  }

 private:
  graph::App app_;
  ChainTracker tracker_;
  std::map<std::string, std::uint64_t> count_;
};

ChainSample first_sample(std::uint64_t source, int begin, int end) {
  return {source, at_ms(begin), at_ms(end), milliseconds{end - begin}, std::nullopt, std::nullopt};
}
ChainSample sample(std::uint64_t source, int begin, int end, int period, int response) {
  return {source, at_ms(begin), at_ms(end), milliseconds{end - begin}, milliseconds{period}, milliseconds{response}};
}
using Samples = std::vector<ChainSample>;

TEST(ChainTracker, FollowsALinearChain) {
  Chain chain({{"a"}, {"b"}, {"c"}});
  EXPECT_EQ(chain.run("a", 0, 2), Samples{});
  EXPECT_EQ(chain.run("b", 2, 5, 1), Samples{});
  EXPECT_EQ(chain.run("c", 5, 6, 1), Samples{first_sample(1, 0, 6)});
  chain.run("a", 10, 12);
  chain.run("b", 12, 16, 2);
  EXPECT_EQ(chain.run("c", 16, 18, 2), Samples{sample(2, 10, 18, 12, 18)});
}

TEST(ChainTracker, SkipsInputsThatWereOverwritten) {
  Chain chain({{"a"}, {"b"}});
  chain.run("a", 0, 1);
  EXPECT_EQ(chain.run("b", 1, 3, 1), Samples{first_sample(1, 0, 3)});
  chain.run("a", 10, 11);
  chain.run("a", 20, 21);
  // Number 2 was dropped, so the world was last looked at in run 1.
  EXPECT_EQ(chain.run("b", 21, 25, 3), Samples{sample(3, 20, 25, 22, 25)});
}

TEST(ChainTracker, CountsTheFirstOutputThatUsedAnInput) {
  Chain chain({{"a"}, {"b"}});
  chain.run("a", 0, 1);
  EXPECT_EQ(chain.run("b", 1, 2, 1).size(), 1U);
  EXPECT_EQ(chain.run("b", 3, 4, 1), Samples{});
  EXPECT_EQ(chain.run("b", 5, 6, 1), Samples{});
  chain.run("a", 6, 7);
  EXPECT_EQ(chain.run("b", 7, 8, 2), Samples{sample(2, 6, 8, 6, 8)});
}

TEST(ChainTracker, GivesASampleForEachInputOfABatch) {
  Chain chain({{"a"}, {"q", true}, {"c"}});
  chain.run("a", 0, 1);
  chain.run("a", 10, 11);
  chain.run("a", 20, 21);
  EXPECT_EQ(chain.run("q", 21, 30, 1, 3), Samples{});
  EXPECT_EQ(chain.run("c", 30, 35, 1),
            (Samples{first_sample(1, 0, 35), sample(2, 10, 35, 0, 35), sample(3, 20, 35, 0, 25)}));
}

TEST(ChainTracker, SaysByWhichRunsASampleCame) {
  Chain chain({{"a"}, {"q", true}, {"c"}});
  for (int i = 0; i < 3; ++i) chain.run("a", 10 * i, 10 * i + 1, 0, 0, i != 1);
  chain.run("q", 21, 30, 1, 3);
  EXPECT_EQ(chain.run("c", 30, 35, 1).size(), 2U);
  EXPECT_EQ(chain.path_of(1), (std::vector<std::uint64_t>{1, 1, 1}));
  EXPECT_EQ(chain.path_of(3), (std::vector<std::uint64_t>{3, 1, 1}));
  EXPECT_EQ(chain.path_of(2), std::vector<std::uint64_t>{}) << "emitted nothing";
  chain.run("c", 40, 41, 1);
  EXPECT_EQ(chain.path_of(3), (std::vector<std::uint64_t>{3, 1, 1})) << "the first output that used it";
  chain.run("a", 41, 42);
  chain.run("q", 42, 43, 4);
  EXPECT_EQ(chain.run("c", 43, 44, 2).size(), 1U);
  EXPECT_EQ(chain.path_of(4), (std::vector<std::uint64_t>{4, 2, 3}));
}

TEST(ChainTracker, RunsThatEmitNothingAreNoInputAndNoOutput) {
  Chain chain({{"a"}, {"q", true}});
  chain.run("a", 0, 1);
  chain.run("a", 10, 11, 0, 0, false);
  chain.run("a", 20, 21);
  EXPECT_EQ(chain.run("q", 21, 22, 1, 3, false), Samples{}) << "no output";
  chain.run("a", 30, 31);
  EXPECT_EQ(chain.run("q", 31, 40, 4), Samples{first_sample(4, 30, 40)}) << "what the silent run took is lost";
  chain.run("a", 41, 42, 0, 0, false);
  chain.run("a", 43, 44);
  EXPECT_EQ(chain.run("q", 45, 50, 5, 6), Samples{sample(6, 43, 50, 10, 20)}) << "run 5 emitted nothing";
}

TEST(ChainTracker, PassesOverExternalNodesAtTheEnds) {
  Chain chain({{"sensor", false, true}, {"a"}, {"b"}, {"base", false, true}});
  chain.run("a", 0, 1);
  EXPECT_EQ(chain.run("b", 1, 3, 1), Samples{first_sample(1, 0, 3)});
}

TEST(ChainTracker, InfersWhatPassedThroughAnExternalNode) {
  Chain chain({{"a"}, {"bus", false, true}, {"b"}});
  chain.run("a", 0, 2);
  chain.run("a", 10, 12);
  EXPECT_EQ(chain.run("b", 11, 13), Samples{first_sample(1, 0, 13)}) << "run 2 had not ended when b began";
  EXPECT_EQ(chain.run("b", 13, 14), Samples{sample(2, 10, 14, 1, 14)});
  EXPECT_EQ(chain.run("b", 15, 16), Samples{});
}

TEST(ChainTracker, MayStartAndEndAmidTheGraph) {
  const graph::App app = path_app({{"a"}, {"b"}, {"c"}, {"d"}});
  const std::vector<NodeId> middle{NodeId{1}, NodeId{2}};
  ChainTracker tracker(app.graph, middle);
  EXPECT_TRUE(
      tracker.add({.node = NodeId{0}, .number = 1, .begin = at_ms(0), .end = at_ms(1), .consumed = {}}).empty());
  EXPECT_TRUE(
      tracker.add({.node = NodeId{1}, .number = 1, .begin = at_ms(1), .end = at_ms(2), .consumed = {{NodeId{0}, 1, 1}}})
          .empty());
  const auto samples = tracker.add(
      {.node = NodeId{2}, .number = 1, .begin = at_ms(2), .end = at_ms(4), .consumed = {{NodeId{1}, 1, 1}}});
  EXPECT_EQ(samples, Samples{first_sample(1, 1, 4)});
}

TEST(ChainTracker, OneNodeIsItsOwnSourceAndEnd) {
  Chain chain({{"a"}, {"base", false, true}});
  EXPECT_EQ(chain.run("a", 0, 2), Samples{first_sample(1, 0, 2)});
  EXPECT_EQ(chain.run("a", 10, 13), Samples{sample(2, 10, 13, 11, 13)});
}

TEST(ChainTracker, CrossesFromAFastSubchainIntoASlowOne) {
  Chain chain({{"a"}, {"b"}, {"slow"}});
  for (int i = 0; i < 10; ++i) {
    chain.run("a", 10 * i, 10 * i + 2);
    chain.run("b", 10 * i + 2, 10 * i + 4, static_cast<std::uint64_t>(i + 1));
  }
  EXPECT_EQ(chain.run("slow", 34, 60, 4), Samples{first_sample(4, 30, 60)});
  EXPECT_EQ(chain.run("slow", 65, 95, 7), Samples{sample(7, 60, 95, 35, 65)});
}

TEST(ChainTracker, CountsAsDroppedWhatLiesBeyondTheHorizon) {
  Chain chain({{"a"}, {"b"}});
  for (std::size_t i = 0; i <= ChainTracker::kHorizon; ++i) chain.run("a", static_cast<int>(i), static_cast<int>(i));
  EXPECT_EQ(chain.run("b", 10000, 10001, 1), Samples{});
  EXPECT_EQ(chain.run("b", 10002, 10003, 2), Samples{first_sample(2, 1, 10003)});
}

TEST(ChainTracker, IsNotHarmedByRunsThatMakeNoSense) {
  Chain chain({{"a"}, {"q", true}});
  EXPECT_EQ(chain.run("q", 0, 1, 1, ~std::uint64_t{0}), Samples{});
  EXPECT_EQ(chain.run("q", 1, 2, 7, 3), Samples{});
  chain.run("a", 2, 3);
  EXPECT_EQ(chain.run("q", 3, 4, 1, ~std::uint64_t{0}).size(), 1U);
  const graph::App app = path_app({{"a"}});
  ChainTracker tracker(app.graph, std::vector<NodeId>{NodeId{0}});
  EXPECT_TRUE(tracker.add({.node = NodeId{9}, .number = 1, .consumed = {}}).empty());
  EXPECT_TRUE(tracker.add({.node = NodeId{0}, .number = 0, .consumed = {}}).empty());
}

// A random history of a path: nodes run concurrently, take what was emitted before they began, some in batches.
struct History {
  std::vector<TestNode> nodes;
  std::vector<Run> runs;  // by end, predecessors first
};

History random_history() {
  History history;
  const int length = *rc::gen::inRange(1, 6);
  for (int i = 0; i < length; ++i) {
    const bool inner = i > 0 && i + 1 < length && !history.nodes.back().external;
    const bool external = inner && *rc::gen::inRange(0, 5) == 0;
    const bool queue = !external && *rc::gen::inRange(0, 3) == 0;
    history.nodes.push_back({std::string(1, static_cast<char>('a' + i)), queue, external});
  }
  std::vector<TimePoint> busy_until(history.nodes.size());
  std::vector<std::uint64_t> taken(history.nodes.size());
  std::vector<std::vector<Run>> of(history.nodes.size());
  TimePoint now = at_ms(0);
  for (int step = *rc::gen::inRange(0, 150); step > 0; --step) {
    // No two steps at one instant: else a run of no length could end just when an earlier one had begun without it.
    now += milliseconds{*rc::gen::inRange(0, 4)} + Nanos{1};
    const auto node = *rc::gen::inRange<std::size_t>(0, history.nodes.size());
    if (history.nodes[node].external || busy_until[node] > now) continue;
    Run run{.node = NodeId{node}, .number = of[node].size() + 1, .begin = now, .consumed = {}};
    run.end = busy_until[node] = now + milliseconds{*rc::gen::inRange(0, 12)};
    run.emitted = *rc::gen::inRange(0, 6) != 0;
    const std::size_t before = node > 0 && history.nodes[node - 1].external ? node - 2 : node - 1;
    if (node > 0) {
      std::uint64_t newest = 0;
      for (const Run& earlier : of[before]) {
        if (earlier.emitted && earlier.end <= now) newest = earlier.number;
      }
      const bool queue = history.nodes[node].queue;
      if (newest > (queue ? taken[node] : 0)) {
        run.consumed.push_back({NodeId{before}, queue ? taken[node] + 1 : newest, newest});
      }
      taken[node] = newest;
    }
    of[node].push_back(run);
  }
  for (const auto& runs : of) history.runs.insert(history.runs.end(), runs.begin(), runs.end());
  std::stable_sort(history.runs.begin(), history.runs.end(), [](const Run& a, const Run& b) { return a.end < b.end; });
  return history;
}

// By the definitions: every run's source runs as a set, each source run's output as the first that has it.
Samples by_definition(const History& history) {
  std::map<std::pair<NodeId, std::uint64_t>, std::pair<bool, std::set<std::uint64_t>>> sources;  // emitted, from where
  std::map<std::uint64_t, TimePoint> begins;
  std::map<std::uint64_t, TimePoint> outputs;
  const NodeId last{history.nodes.size() - 1};
  for (const Run& run : history.runs) {
    auto& [emitted, from] = sources[{run.node, run.number}];
    emitted = run.emitted;
    if (run.node == NodeId{0}) {
      begins[run.number] = run.begin;
      from = {run.number};
    }
    for (const Consumed& input : run.consumed) {
      for (std::uint64_t number = input.first; number <= input.last; ++number) {
        const auto& [gave, their] = sources[{input.predecessor, number}];
        if (gave) from.insert(their.begin(), their.end());
      }
    }
    if (run.node != last || !run.emitted) continue;
    for (const std::uint64_t source : from) outputs.emplace(source, run.end);
  }
  Samples samples;
  for (const auto& [source, end] : outputs) {
    const TimePoint begin = begins[source];
    ChainSample sample{source, begin, end, end - begin, std::nullopt, std::nullopt};
    if (!samples.empty()) {
      sample.period = end - samples.back().end;
      sample.response = end - samples.back().begin;
    }
    samples.push_back(sample);
  }
  return samples;
}

RC_GTEST_PROP(ChainTrackerProperty, AgreesWithTheDefinitions, ()) {
  const History history = random_history();
  const graph::App app = path_app(history.nodes);
  ChainTracker tracker(app.graph, app.objective.front().path);
  Samples samples;
  for (Run run : history.runs) {
    // What was taken through an external node is not reported.
    std::erase_if(run.consumed,
                  [&](const Consumed& input) { return !app.graph.has_edge(input.predecessor, run.node); });
    for (const ChainSample& sample : tracker.add(run)) samples.push_back(sample);
  }
  RC_ASSERT(samples == by_definition(history));
}

// --- Clocks of others ---

TEST(ChainTracker, AnOutputEndsAtTheNextTick) {
  Chain chain({{"a"}, {.name = "display", .external = true, .period_ms = 10}});
  chain.set_clock("display", 3, 10);
  EXPECT_EQ(chain.run("a", 0, 2), Samples{}) << "until the tick has passed";
  EXPECT_EQ(chain.run("a", 10, 13), Samples{first_sample(1, 0, 3)});
  EXPECT_EQ(chain.run("a", 20, 24), Samples{sample(2, 10, 13, 10, 13)}) << "by the tick is in time";
  EXPECT_EQ(chain.run("a", 40, 41), Samples{sample(3, 20, 33, 20, 23)}) << "just missed";
}

TEST(ChainTracker, OfOutputsThatEndAtOneTickTheNewestCounts) {
  Chain chain({{"a"}, {.name = "display", .external = true, .period_ms = 10}});
  chain.set_clock("display", 10, 10);
  chain.run("a", 0, 1);
  EXPECT_EQ(chain.run("a", 11, 12), Samples{first_sample(1, 0, 10)});
  EXPECT_EQ(chain.run("a", 15, 16), Samples{}) << "overtakes run 2";
  EXPECT_EQ(chain.run("a", 21, 22), Samples{sample(3, 15, 20, 10, 20)});
}

TEST(ChainTracker, AnOutputThatBringsNothingNewOvertakesNothing) {
  Chain chain({{"a"}, {"b"}, {.name = "display", .external = true, .period_ms = 10}});
  chain.set_clock("display", 10, 10);
  chain.run("a", 0, 1);
  chain.run("b", 1, 2, 1);
  chain.run("b", 3, 4, 1);
  chain.run("a", 10, 11);
  EXPECT_EQ(chain.run("b", 11, 12, 2), Samples{first_sample(1, 0, 10)});
}

TEST(ChainTracker, ASourceRunBeginsAtTheTickBeforeIt) {
  Chain chain({{.name = "sensor", .external = true, .period_ms = 10}, {"a"}});
  chain.set_clock("sensor", 0, 10);
  EXPECT_EQ(chain.run("a", 4, 5), Samples{first_sample(1, 0, 5)});
  EXPECT_EQ(chain.run("a", 7, 8), Samples{}) << "has nothing new";
  EXPECT_EQ(chain.run("a", 12, 14), Samples{sample(3, 10, 14, 9, 14)});
}

TEST(ChainTracker, AClockOfWhichNothingIsKnownIsPassedOver) {
  Chain chain({{.name = "sensor", .external = true, .period_ms = 10},
               {"a"},
               {.name = "display", .external = true, .period_ms = 10}});
  EXPECT_EQ(chain.run("a", 4, 5), Samples{first_sample(1, 4, 5)});
  EXPECT_EQ(chain.run("a", 7, 8), Samples{sample(2, 7, 8, 3, 4)});
  chain.set_clock("display", 0, 10);
  EXPECT_EQ(chain.run("a", 11, 12), Samples{});
  EXPECT_EQ(chain.run("a", 21, 22), Samples{sample(3, 11, 20, 12, 13)}) << "from when it is known on";
}

// What is known of a clock changes by little again and again: that is no other tick.
TEST(ChainTracker, ACorrectedClockSplitsNoTick) {
  Chain chain({{"a"}, {.name = "display", .external = true, .period_ms = 100}});
  chain.set_clock("display", 100, 100);
  chain.run("a", 10, 20);
  chain.set_clock("display", 101, 100);
  EXPECT_EQ(chain.run("a", 30, 40), Samples{});
  EXPECT_EQ(chain.run("a", 110, 120), Samples{first_sample(2, 30, 100)});
}

// The definition: a node that runs at each tick, costs nothing, and takes the newest there is.
RC_GTEST_PROP(ChainTrackerProperty, AClockIsANodeThatRunsAtItsTicks, ()) {
  Chain ticking({{.name = "s", .external = true, .period_ms = 10},
                 {"a"},
                 {"b"},
                 {.name = "d", .external = true, .period_ms = 10}});
  Chain running({{"s"}, {"a"}, {"b"}, {"d"}});
  const int period_s = *rc::gen::inRange(1, 20);
  const int period_d = *rc::gen::inRange(1, 20);
  ticking.set_clock("s", 0, period_s);
  ticking.set_clock("d", 0, period_d);
  Samples with_ticks;
  Samples with_runs;
  const auto add = [](Samples& all, const Samples& more) { all.insert(all.end(), more.begin(), more.end()); };
  struct Work {
    int until = 0;
    std::uint64_t taken = 0;
  };
  Work a;
  Work b;
  std::uint64_t done_s = 0;
  std::uint64_t done_a = 0;
  std::uint64_t done_b = 0;
  int begin_a = 0;
  int begin_b = 0;
  for (int now = 0; now < 300; ++now) {
    if (now % period_s == 0) {
      add(with_runs, running.run("s", now, now));
      ++done_s;
    }
    if (a.until == now && a.taken > 0) {
      add(with_ticks, ticking.run("a", begin_a, now));
      add(with_runs, running.run("a", begin_a, now, a.taken));
      ++done_a;
      a.taken = 0;
    }
    if (b.until == now && b.taken > 0) {
      add(with_ticks, ticking.run("b", begin_b, now, b.taken));
      add(with_runs, running.run("b", begin_b, now, b.taken));
      ++done_b;
      b.taken = 0;
    }
    if (now % period_d == 0 && done_b > 0) add(with_runs, running.run("d", now, now, done_b));
    if (a.taken == 0 && *rc::gen::inRange(0, 3) == 0) {
      a = {now + *rc::gen::inRange(1, 12), done_s};
      begin_a = now;
    }
    if (b.taken == 0 && done_a > 0 && *rc::gen::inRange(0, 3) == 0) {
      b = {now + *rc::gen::inRange(1, 12), done_a};
      begin_b = now;
    }
  }
  // The last tick is complete once an output of a later one has come. Numbers are those of other nodes.
  RC_ASSERT(with_ticks.size() <= with_runs.size() && with_ticks.size() + 1 >= with_runs.size());
  for (std::size_t i = 0; i < with_ticks.size(); ++i) {
    with_runs[i].source_run = with_ticks[i].source_run;
    RC_ASSERT(with_ticks[i] == with_runs[i]);
  }
}

}  // namespace
}  // namespace ctn::record
