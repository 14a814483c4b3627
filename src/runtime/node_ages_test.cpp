// How old a run's inputs are, in virtual time: what node ports carry from run to run through the region, and that no
// process that writes there can do more than make an age wrong.
#include <gtest/gtest.h>

#include <atomic>
#include <cstdint>
#include <limits>
#include <thread>
#include <vector>

#include "base/run_access.h"
#include "config/testing/apps.h"
#include "os/fake/fake_os.h"
#include "runtime/node_link.h"
#include "runtime/node_port.h"
#include "runtime/report.h"
#include "runtime/report_check.h"

namespace ctn::runtime {
namespace {

using std::chrono::milliseconds;
using Ages = std::vector<Nanos>;

// Unscheduled nodes begin and end their runs when the test says so.
class NodeAgesTest : public ::testing::Test {
 protected:
  NodeId id(const char* name) const { return *app.graph.find_node(name); }

  struct Node {
    Node(NodeAgesTest& test, const char* name)
        : port(test.fake, test.app.graph, test.id(name), test.region),
          link(test.fake, test.app.graph, test.id(name), test.region) {}
    NodePort port;
    NodeLink link;
    ctn::Run run;
    Ages reported;
    bool emitted = false;
  };

  // A run that takes so long; `in`: what its function asks.
  template <class Ask>
  void run(Node& node, Nanos length, Ask&& ask) {
    node.port.begin(node.run);
    ask(node.run);
    fake.burn(length);
    node.port.end(node.run);
    node.link.drain([&](const record::Run& run) {
      node.reported = run.ages;
      node.emitted = run.emitted;
    });
  }
  void run(Node& node, Nanos length = Nanos{0}) {
    run(node, length, [](ctn::Run&) {});
  }
  void pass(Nanos time) { fake.sleep_until(fake.now() + time); }

  os::FakeOs fake;
  const graph::App app = parse(R"(
catan: 1
app: ages
nodes:
  scan: { unscheduled: true, period: 10ms }
  map: { unscheduled: true, period: 1s }
  LM: { unscheduled: true, period: 10ms }
  LP: { unscheduled: true, period: 10ms }
  log: { unscheduled: true, period: 10ms, input: queue }
  sink: {}
edges:
  - { path: scan -> LM, max_age: 20ms }
  - { path: LM -> LP, max_age: 50ms, on_stale: skip }
  - map -> LP -> log
  - LP -> sink
objective: [ { period: sink, weight: 1 } ]
)");
  LocalRegion memory{app.graph, 1};
  Region& region = memory.region();
  Node scan{*this, "scan"};
  Node map{*this, "map"};
  Node lm{*this, "LM"};
  Node lp{*this, "LP"};
  Node log{*this, "log"};
};

TEST_F(NodeAgesTest, AreCountedFromTheBeginOfTheSourceRun) {
  run(scan, milliseconds{3});
  pass(milliseconds{4});
  run(lm, milliseconds{5}, [&](ctn::Run& run) {
    EXPECT_EQ(run.age("scan"), milliseconds{7});
    EXPECT_EQ(run.age("map"), ctn::Run::kNoInput) << "it has no such input";
    EXPECT_FALSE(run.stale());
  });
  EXPECT_EQ(lm.reported, Ages{milliseconds{7}});
  run(lp, milliseconds{1}, [&](ctn::Run& run) {
    EXPECT_EQ(run.age("LM"), milliseconds{12});
    EXPECT_EQ(run.age("map"), ctn::Run::kNoInput) << "it has given nothing yet";
  });
  EXPECT_EQ(lp.reported, (Ages{milliseconds{12}, record::kNoAge}));
}

TEST_F(NodeAgesTest, OfSeveralSourcesTheOldestIsCarriedOn) {
  run(map);
  pass(milliseconds{100});
  run(scan);
  run(lm);
  pass(milliseconds{5});
  run(lp);
  EXPECT_EQ(lp.reported, (Ages{milliseconds{5}, milliseconds{105}}));
  pass(milliseconds{5});
  run(log);
  EXPECT_EQ(log.reported, Ages{milliseconds{110}});
}

TEST_F(NodeAgesTest, ASourceThatStopsGrowsStaleAndTheOutputThatRestsOnItIsWithheld) {
  run(scan);
  run(lm);
  pass(milliseconds{50});
  run(lp);
  EXPECT_TRUE(lp.emitted) << "just as old as it may be";
  pass(milliseconds{1});
  bool called = false;
  run(lp, Nanos{0}, [&](ctn::Run& run) {
    called = true;
    EXPECT_TRUE(run.stale());
  });
  EXPECT_TRUE(called);
  EXPECT_FALSE(lp.emitted);
  EXPECT_EQ(region.node(id("LP")).newest_output.load(), 1U);
  run(lm);  // the scan is still the old one, which LM goes on with: on_stale is run
  EXPECT_TRUE(lm.emitted);
  EXPECT_EQ(lm.reported, Ages{milliseconds{51}});
  run(lp);
  EXPECT_FALSE(lp.emitted) << "LM's output is new, but the scan that it rests on is not";
  run(scan);
  run(lm);
  run(lp);
  EXPECT_TRUE(lp.emitted);
}

TEST_F(NodeAgesTest, OfAQueueTheOldestThatIsTakenCounts) {
  for (int count = 0; count < 3; ++count) {
    run(map);
    run(lp);
    pass(milliseconds{10});
  }
  run(log);
  EXPECT_EQ(log.reported, Ages{milliseconds{30}});
  pass(milliseconds{10});
  run(log);
  EXPECT_EQ(log.reported, Ages{milliseconds{40}}) << "nothing new: it still has what it took last";
}

// The cell holds the origins of so many outputs; beyond that the error is on the side of caution.
TEST_F(NodeAgesTest, WhoTakesMoreAtOnceThanTheCellHoldsTakesItForOlder) {
  run(map);
  run(lp);
  pass(milliseconds{10});
  run(log);
  EXPECT_EQ(log.reported, Ages{milliseconds{10}});
  for (std::size_t count = 0; count < NodeCell::kOutputs; ++count) {
    pass(milliseconds{1});
    run(map);
    run(lp);
  }
  run(log);
  EXPECT_EQ(log.reported, Ages{milliseconds{63}}) << "all of them are there";
  for (std::size_t count = 0; count <= NodeCell::kOutputs; ++count) {
    pass(milliseconds{1});
    run(map);
    run(lp);
  }
  run(log);
  EXPECT_EQ(log.reported, Ages{milliseconds{63 + 65}}) << "what was taken before";
}

// A late map: LP's outputs before it go back to a scan, and that with it to what the map had.
TEST_F(NodeAgesTest, AnyOutputOfABatchMayBeTheOldest) {
  run(map);
  pass(milliseconds{30});
  NodeCell& cell = region.node(id("map"));
  const std::uint64_t given = cell.newest_output.exchange(0);
  run(scan);
  run(lm);
  run(lp);
  cell.newest_output.store(given);
  run(lp);
  cell.newest_output.store(0);
  run(lp);
  EXPECT_EQ(lp.reported, (Ages{Nanos{0}, milliseconds{30}})) << "nothing taken, but had before";
  run(log);
  EXPECT_EQ(log.reported, Ages{milliseconds{30}});
  pass(milliseconds{1});
  run(lp);
  run(log);
  EXPECT_EQ(log.reported, Ages{milliseconds{1}});
}

// As of a node with an `output_period`.
TEST_F(NodeAgesTest, RunsWithoutOutputInBetweenTakeNoPlaceInTheCell) {
  run(map);
  run(lp);
  run(log);
  for (int output = 0; output < 3; ++output) {
    pass(milliseconds{10});
    run(map);
    run(lp);
    for (int count = 0; count < 200; ++count) run(lp, Nanos{0}, [](ctn::Run& run) { run.skip_output(); });
  }
  run(log);
  EXPECT_EQ(log.reported, Ages{milliseconds{20}});
}

// A node that has moved to another region, as when a server has ended, still has what it took in the old one.
TEST_F(NodeAgesTest, GoOnInAnotherRegion) {
  run(scan);
  run(lm);
  LocalRegion other(app.graph, 1);
  lm.port.bind_to(other.region(), app.graph);
  NodeLink link(fake, app.graph, id("LM"), other.region());
  pass(milliseconds{30});
  lm.port.begin(lm.run);
  EXPECT_EQ(lm.run.age("scan"), milliseconds{30});
  EXPECT_TRUE(lm.run.stale());
  lm.port.end(lm.run);
}

// Any word that another process may write. What comes of it is an age, from 0 up, that need not be believed.
TEST_F(NodeAgesTest, ACellThatLiesMakesAgesWrongAndNoMore) {
  constexpr std::uint64_t kNumbers[] = {
      0, 1, 63, 64, std::uint64_t{1} << 62U, std::uint64_t{1} << 63U, ~std::uint64_t{0}};
  constexpr std::int64_t kOrigins[] = {std::numeric_limits<std::int64_t>::min(), -2, -1, 0, 1,
                                       std::numeric_limits<std::int64_t>::max()};
  ReportCheck check(app.graph);
  pass(milliseconds{100});
  for (const std::uint64_t number : kNumbers) {
    for (const std::uint64_t newest : kNumbers) {
      for (const std::int64_t origin : kOrigins) {
        for (NodeCell::Output& output : region.node(id("LP")).outputs) {
          output.number.store(number);
          output.origin.store(origin);
          output.previous.store(number - 1);
        }
        region.node(id("LP")).newest_output.store(newest);
        log.port.begin(log.run);
        const Nanos age = log.run.age("LP");
        EXPECT_TRUE(age == ctn::Run::kNoInput || (age >= Nanos{0} && age <= fake.now() - TimePoint{}));
        log.port.end(log.run);
        log.link.drain([&](record::Run run) {
          EXPECT_TRUE(check.accept(run, fake.now()));
          ASSERT_EQ(run.ages.size(), 1U);
          EXPECT_TRUE(run.ages[0] == record::kNoAge || run.ages[0] == age) << run.ages[0].count();
        });
      }
    }
  }
}

// A report's words may be anything, too.
TEST(Report, OriginsThatLieMakeAgesWrongAndNoMore) {
  const NodeId predecessors[] = {NodeId(0)};
  constexpr std::uint64_t kWords[] = {
      0, 1, std::uint64_t{1} << 62U, (std::uint64_t{1} << 63U) - 1, std::uint64_t{1} << 63U, ~std::uint64_t{0}};
  for (const std::uint64_t begin : kWords) {
    for (const std::uint64_t origin : kWords) {
      std::vector<std::uint64_t> words(report_words(1), 0);
      words[0] = 1;
      words[1] = words[2] = begin;
      const std::size_t input = report_words(0);
      words[input] = words[input + 1] = 1;
      words[input + 2] = origin;
      const record::Run run = decode_report(NodeId(1), predecessors, words);
      ASSERT_EQ(run.ages.size(), 1U);
      EXPECT_GE(run.ages[0], record::kNoAge);
    }
  }
}

// Against the clock, but right however the threads are scheduled: an origin is never that of another number.
TEST(NodeCell, NumberAndOriginBelongTogether) {
  NodeCell cell;
  constexpr std::uint64_t kRuns = 300000;
  const auto origin_of = [](std::uint64_t run) { return static_cast<std::int64_t>(run * 7); };
  std::thread writer([&] {
    // Every third run gives nothing.
    for (std::uint64_t run = 1; run <= kRuns; ++run) {
      if (run % 3 != 0) cell.give(run, origin_of(run));
    }
  });
  std::uint64_t found = 0;
  for (std::uint64_t newest = 0; newest < kRuns - 1;) {
    newest = cell.newest_output.load(std::memory_order_acquire);
    if (newest == 0) continue;
    const std::uint64_t first = newest > 70 ? newest - 70 : 1;
    for (std::uint64_t run = first; run <= newest; ++run) {
      const std::int64_t origin = cell.origin_of(run);
      if (origin == NodeCell::kUnknown) continue;
      ASSERT_EQ(origin, origin_of(run));
      ASSERT_NE(run % 3, 0U) << "that one gave none";
      ++found;
    }
    const std::int64_t oldest = cell.oldest_origin(newest > 20 ? newest - 20 : 1, newest);
    if (oldest == NodeCell::kUnknown) continue;
    const std::uint64_t expected = newest > 20 ? newest - 20 : 1;
    ASSERT_EQ(oldest, origin_of(expected % 3 != 0 ? expected : expected + 1));
  }
  writer.join();
  EXPECT_GT(found, 0U);
  for (std::uint64_t run = kRuns - NodeCell::kOutputs; run <= kRuns - 1; ++run) {
    EXPECT_EQ(cell.origin_of(run), run % 3 != 0 ? origin_of(run) : NodeCell::kUnknown);
  }
  EXPECT_EQ(cell.oldest_origin(kRuns - 40, kRuns - 1), origin_of(kRuns - 40));
}

}  // namespace
}  // namespace ctn::runtime
