#include "record/ages.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "base/testing/times.h"
#include "graph/build.h"
#include "graph/testing/spec_text.h"

namespace ctn::record {
namespace {

using std::chrono::milliseconds;
using Ages = std::vector<Nanos>;

// scan -> LM -> LP, map -> LP, bus (external) -> map; log reads LP's output as a queue.
graph::App sensing_robot() {
  graph::AppSpec spec = graph::spec_of({"scan", "LM", "LP", "map", "bus", "log"}, {"scan LM LP log", "bus map LP"});
  graph::node(spec, "bus").external = true;
  graph::node(spec, "log").input = graph::InputKind::kQueue;
  spec.objective = {graph::response("scan LM LP", 1.0)};
  auto app = graph::build_app(spec);
  EXPECT_TRUE(app.ok()) << (app ? "" : app.error().message());
  return *app;
}

class AgesTest : public ::testing::Test {
 protected:
  NodeId id(const std::string& name) const { return *app.graph.find_node(name); }

  struct Took {
    const char* from;
    std::uint64_t first;
    std::uint64_t last;
  };
  // The next run of a node; times in ms.
  Ages run(const std::string& name, int begin, const std::vector<Took>& consumed = {}, bool emitted = true) {
    record::Run run;
    run.node = id(name);
    run.number = ++count_[name];
    run.begin = at_ms(begin);
    run.end = at_ms(begin + 1);
    run.emitted = emitted;
    for (const Took& took : consumed) run.consumed.push_back({id(took.from), took.first, took.last});
    origin_ = tracker.add(run);
    return run.ages;
  }
  TimePoint origin() const { return origin_; }

  const graph::App app = sensing_robot();
  AgeTracker tracker{app.graph};

 private:
  std::map<std::string, std::uint64_t> count_;
  TimePoint origin_{};
};

TEST_F(AgesTest, TheAgeIsCountedFromTheSourceAndNotFromTheNodeBefore) {
  EXPECT_EQ(run("scan", 0), Ages{});
  EXPECT_EQ(origin(), at_ms(0));
  EXPECT_EQ(run("LM", 5, {{"scan", 1, 1}}), Ages{milliseconds{5}});
  EXPECT_EQ(run("LP", 20, {{"LM", 1, 1}}), (Ages{milliseconds{20}, kNoAge})) << "map has given nothing yet";
  EXPECT_EQ(run("log", 50, {{"LP", 1, 1}}), Ages{milliseconds{50}});
}

TEST_F(AgesTest, OfSeveralSourcesTheOldestCounts) {
  run("map", 0);
  run("scan", 90);
  run("LM", 95, {{"scan", 1, 1}});
  EXPECT_EQ(run("LP", 100, {{"LM", 1, 1}, {"map", 1, 1}}), (Ages{milliseconds{10}, milliseconds{100}}));
  EXPECT_EQ(origin(), at_ms(0));
  EXPECT_EQ(run("log", 110, {{"LP", 1, 1}}), Ages{milliseconds{110}});
}

TEST_F(AgesTest, WhatAnExternalNodeFeedsIsASource) {
  EXPECT_EQ(run("map", 30), Ages{kNoAge});
  EXPECT_EQ(origin(), at_ms(30));
}

TEST_F(AgesTest, WhatIsReadAgainHasGrownOlder) {
  run("scan", 0);
  EXPECT_EQ(run("LM", 5, {{"scan", 1, 1}}), Ages{milliseconds{5}});
  EXPECT_EQ(run("LM", 500, {{"scan", 1, 1}}), Ages{milliseconds{500}});
}

TEST_F(AgesTest, OfAQueueTheOldestThatWasTakenCounts) {
  for (const int begin : {0, 10, 20}) run("LP", begin);
  EXPECT_EQ(run("log", 30, {{"LP", 1, 3}}), Ages{milliseconds{30}});
  run("LP", 40, {}, false);
  run("LP", 50);
  EXPECT_EQ(run("log", 60, {{"LP", 4, 5}}), Ages{milliseconds{10}}) << "run 4 gave nothing";
  EXPECT_EQ(run("log", 75), Ages{milliseconds{25}}) << "nothing new: it still has what it took last";
}

// LP's second run reads an older map, its third one no map at all.
TEST_F(AgesTest, ALaterOutputMayGoBackFurtherThanAnEarlierOne) {
  run("map", 0);
  run("scan", 50);
  run("LM", 51, {{"scan", 1, 1}});
  run("LP", 60, {{"LM", 1, 1}});
  run("LP", 70, {{"LM", 1, 1}, {"map", 1, 1}});
  run("LP", 80, {{"LM", 1, 1}});
  EXPECT_EQ(run("log", 90, {{"LP", 1, 3}}), Ages{milliseconds{90}});
}

// A node that has lost its input must not make what it gives seem fresh.
TEST_F(AgesTest, ARunThatConsumesNothingRestsOnWhatItHadBefore) {
  run("LM", 3);
  EXPECT_EQ(origin(), at_ms(3)) << "it never had any";
  run("scan", 5);
  run("LM", 10, {{"scan", 1, 1}});
  run("LM", 1000);
  EXPECT_EQ(origin(), at_ms(5));
}

TEST_F(AgesTest, ASourceThatBeganAfterItsReaderIsNotOld) {
  run("scan", 10);
  EXPECT_EQ(run("LM", 8, {{"scan", 1, 1}}), Ages{milliseconds{0}});
}

TEST_F(AgesTest, WhatWasForgottenIsTakenToBeAsOldAsWhatWasThereBefore) {
  run("scan", 0);
  run("LM", 1, {{"scan", 1, 1}});
  for (std::size_t i = 0; i < AgeTracker::kHorizon + 1; ++i) run("scan", 10);
  EXPECT_EQ(run("LM", 20, {{"scan", 2, 2}}), Ages{milliseconds{20}}) << "run 2 began at 10, which is not known";
  EXPECT_EQ(run("LM", 20, {{"scan", 3, 3}}), Ages{milliseconds{10}});
}

TEST_F(AgesTest, NothingThatComesIsHarmful) {
  constexpr std::uint64_t kMax = ~std::uint64_t{0};
  run("scan", 0);
  EXPECT_EQ(run("LM", 5, {{"scan", 1, kMax}}), Ages{milliseconds{5}});
  EXPECT_EQ(run("LM", 6, {{"scan", 7, 3}}), Ages{milliseconds{6}});
  EXPECT_EQ(run("LM", 7, {{"scan", kMax, kMax}}), Ages{milliseconds{7}});
  EXPECT_EQ(run("LM", 8, {{"log", 1, 1}}), Ages{milliseconds{8}}) << "no input of it";
  record::Run stranger{.node = NodeId{99}, .number = 1, .consumed = {}};
  tracker.add(stranger);
  record::Run none{.node = id("scan"), .number = 0, .consumed = {}};
  tracker.add(none);
  record::Run last{.node = id("scan"), .number = kMax, .begin = at_ms(9), .consumed = {}};
  tracker.add(last);
  EXPECT_EQ(run("LM", 10, {{"scan", kMax, kMax}}), Ages{milliseconds{1}});
  last.emitted = false;
  tracker.add(last);
  EXPECT_EQ(run("LM", 11, {{"scan", kMax - 5, kMax}}), Ages{milliseconds{2}});
}

// By the definition: which source runs each output goes back to, as sets.
RC_GTEST_PROP(AgesProperty, AgreeWithTheDefinition, ()) {
  const int size = *rc::gen::inRange(1, 6);
  std::vector<std::string> names;
  std::vector<std::string> edges;
  for (int to = 0; to < size; ++to) {
    names.push_back("n" + std::to_string(to));
    for (int from = 0; from < to; ++from) {
      if (*rc::gen::inRange(0, 2) == 0) edges.push_back(names[static_cast<std::size_t>(from)] + " " + names.back());
    }
  }
  graph::AppSpec spec = graph::spec_of(names, edges);
  for (graph::NodeSpec& node : spec.nodes) {
    if (*rc::gen::inRange(0, 3) == 0) node.input = graph::InputKind::kQueue;
  }
  spec.objective = {graph::period("n0", 1.0)};
  const graph::App app = *graph::build_app(spec);

  struct Known {
    std::uint64_t runs = 0;
    std::map<std::uint64_t, std::set<TimePoint>> outputs;  // begins of the sources
    std::map<NodeId, std::set<TimePoint>> inputs;          // taken last
    std::map<NodeId, std::uint64_t> taken;
    std::set<TimePoint> basis;  // of the last run that consumed anything
  };
  std::vector<Known> known(app.graph.nodes().size());
  AgeTracker tracker(app.graph);
  for (int step = 0; step < 150; ++step) {
    const NodeId node{*rc::gen::inRange<std::size_t>(0, known.size())};
    Known& mine = known[node.index()];
    record::Run run{
        .node = node, .number = ++mine.runs, .begin = at_ms(10 * step), .end = at_ms(10 * step + 1), .consumed = {}};
    run.emitted = *rc::gen::inRange(0, 5) != 0;
    std::set<TimePoint> basis;
    for (const NodeId from : app.graph.node(node).predecessors) {
      const Known& theirs = known[from.index()];
      if (theirs.outputs.empty() || *rc::gen::inRange(0, 5) == 0) continue;  // not read this time
      const std::uint64_t newest = theirs.outputs.rbegin()->first;
      const bool queue = app.graph.node(node).input == graph::InputKind::kQueue;
      const std::uint64_t before = std::exchange(mine.taken[from], newest);
      if (queue && newest == before) continue;
      const std::uint64_t first = queue ? before + 1 : newest;
      run.consumed.push_back({from, first, newest});
      std::set<TimePoint>& input = mine.inputs[from] = {};
      for (auto output = theirs.outputs.lower_bound(first); output != theirs.outputs.end(); ++output) {
        input.insert(output->second.begin(), output->second.end());
      }
      basis.insert(input.begin(), input.end());
    }
    if (!basis.empty()) mine.basis = basis;
    if (app.graph.node(node).predecessors.empty() || mine.basis.empty()) {
      if (run.emitted) mine.outputs[run.number] = {run.begin};
    } else if (run.emitted) {
      mine.outputs[run.number] = mine.basis;
    }
    Ages expected;
    for (const NodeId from : app.graph.node(node).predecessors) {
      const std::set<TimePoint>& input = mine.inputs[from];
      expected.push_back(input.empty() ? kNoAge : run.begin - *input.begin());
    }
    tracker.add(run);
    RC_ASSERT(run.ages == expected);
  }
}

}  // namespace
}  // namespace ctn::record
