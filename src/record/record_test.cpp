// What is written is what is read, whatever happens to the writer.
#include <gmock/gmock.h>

#include "record/app_changes.h"
#include "record/sqlite.h"
#include "record/testing/faulty_vfs.h"
#include "record/testing/record_fixture.h"

namespace ctn::record {
namespace {

using namespace test;
using testing::HasSubstr;

// Everything the planner and the lineage see of an app.
void expect_equal(const graph::App& a, const graph::App& b) {
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.core_kinds, b.core_kinds);
  EXPECT_EQ(a.exclusive, b.exclusive);
  ASSERT_EQ(a.graph.nodes().size(), b.graph.nodes().size());
  for (std::size_t i = 0; i < a.graph.nodes().size(); ++i) {
    const graph::Node& x = a.graph.nodes()[i];
    const graph::Node& y = b.graph.nodes()[i];
    EXPECT_EQ(std::tie(x.name, x.input, x.modes, x.external, x.unscheduled, x.period, x.output_period, x.max_threads),
              std::tie(y.name, y.input, y.modes, y.external, y.unscheduled, y.period, y.output_period, y.max_threads));
    EXPECT_TRUE(x.min_rate == y.min_rate && x.max_rate == y.max_rate && x.fallback_rate == y.fallback_rate);
    EXPECT_TRUE(x.subchain == y.subchain && x.predecessors == y.predecessors && x.successors == y.successors);
    EXPECT_EQ(std::tie(x.follows, x.needs_input), std::tie(y.follows, y.needs_input));
  }
  EXPECT_TRUE(
      std::equal(a.graph.edges().begin(), a.graph.edges().end(), b.graph.edges().begin(), b.graph.edges().end()));
  ASSERT_EQ(a.graph.subchains().size(), b.graph.subchains().size());
  for (std::size_t i = 0; i < a.graph.subchains().size(); ++i) {
    const graph::Subchain& x = a.graph.subchains()[i];
    const graph::Subchain& y = b.graph.subchains()[i];
    EXPECT_TRUE(x.name == y.name && x.nodes == y.nodes && x.implicit == y.implicit);
  }
  ASSERT_EQ(a.objective.size(), b.objective.size());
  for (std::size_t i = 0; i < a.objective.size(); ++i) {
    EXPECT_TRUE(a.objective[i].metric == b.objective[i].metric && a.objective[i].path == b.objective[i].path &&
                a.objective[i].weight == b.objective[i].weight && a.objective[i].max == b.objective[i].max);
  }
  EXPECT_TRUE(a.order == b.order && a.steal.priority == b.steal.priority && a.steal.off == b.steal.off);
  const graph::SchedulerOptions& x = a.scheduler;
  const graph::SchedulerOptions& y = b.scheduler;
  EXPECT_EQ(std::tie(x.slack, x.frames, x.min_slice, x.window, x.percentile, x.bootstrap, x.bootstrap_cost, x.replan),
            std::tie(y.slack, y.frames, y.min_slice, y.window, y.percentile, y.bootstrap, y.bootstrap_cost, y.replan));
}

void expect_equal(const Header& a, const Header& b) {
  EXPECT_EQ(std::tie(a.scheduler, a.cpus, a.real_time, a.slack, a.stealing, a.started, a.warm_up, a.host.utc, a.note),
            std::tie(b.scheduler, b.cpus, b.real_time, b.slack, b.stealing, b.started, b.warm_up, b.host.utc, b.note));
  EXPECT_EQ(std::tie(a.host.kernel, a.host.cpu_model, a.host.governor, a.host.clock_source, a.host.cpu_count),
            std::tie(b.host.kernel, b.host.cpu_model, b.host.governor, b.host.clock_source, b.host.cpu_count));
  EXPECT_EQ(a.host.steal, b.host.steal);
}

TEST(Record, GivesBackExactlyWhatWasWritten) {
  const Folder folder;
  const graph::App app = robot();
  const auto writer = make(folder.file("r"), app);
  std::vector<record::Run> expected = runs(app, seconds{100}, 1);
  // The order of writing does not matter.
  for (auto run = expected.rbegin(); run != expected.rend(); ++run) writer->add(*run);
  writer->add(Trigger{SubchainId{0}, 2, at(seconds{101}), at(seconds{101} + Nanos{17})});
  writer->add(Trigger{SubchainId{0}, 1, at(seconds{100}), at(seconds{100})});
  writer->add(SlotUse{1, SubchainId{1}, at(seconds{100}), at(seconds{101}), at(seconds{102})});
  writer->add(Steal{1, SubchainId{0}, SubchainId{1}, at(seconds{100}), at(seconds{101})});
  writer->add(PlanChange{at(seconds{100}), "bootstrap", "{\"a\": 1}"});
  ASSERT_TRUE(writer->flush().ok());
  writer->add(PlanChange{at(seconds{101}), "measured", ""});
  const CostChange change{.at = at(seconds{102}),
                          .node = NodeId(1),
                          .mode = 0,
                          .core_kind = 1,
                          .before = milliseconds{5},
                          .after = milliseconds{9},
                          .runs = 14};
  writer->add(change);
  const std::vector<AppChange> asked{{at(seconds{101}), AppChange::What::kWeight, 1, 0.5, 0.25},
                                     {at(seconds{101}), AppChange::What::kMax, 0, 60.0, std::nullopt},
                                     {at(seconds{102}), AppChange::What::kMinRate, 1, std::nullopt, 7.5}};
  for (const AppChange& each : asked) writer->add(each);
  const ClockReading reading{at(seconds{102}), NodeId(6), {at(seconds{101}), Nanos{8'333'333}}};
  writer->add(reading);
  writer->add(Notice{at(seconds{102}), "rates-only", "it's \"so\""});
  for (const record::Run& run : runs(app, seconds{103}, 3)) writer->add(expected.emplace_back(run));
  os::HostFacts host = header().host;
  host.steal += milliseconds{7};
  writer->set_totals({.plans_made = 2, .planning_cpu = milliseconds{1}, .starved = 3, .starved_for = milliseconds{90}});
  ASSERT_TRUE(writer->close(at(seconds{110}), host).ok());

  EXPECT_FALSE(std::filesystem::exists(folder.file("r-journal")));
  const Reader reader = open(folder.file("r"));
  expect_equal(reader.app(), app);
  expect_equal(reader.header(), header());
  EXPECT_TRUE(reader.ending().closed);
  EXPECT_EQ(reader.ending().ended, at(seconds{110}));
  EXPECT_EQ(reader.ending().stolen, milliseconds{7});
  EXPECT_EQ(reader.ending().starved, milliseconds{90});
  EXPECT_EQ(read_runs(reader), expected);
  std::vector<std::uint64_t> numbers;
  ASSERT_TRUE(reader.each_trigger([&](const Trigger& trigger) { numbers.push_back(trigger.number); }).ok());
  EXPECT_EQ(numbers, (std::vector<std::uint64_t>{1, 2}));
  std::vector<SlotUse> slots;
  ASSERT_TRUE(reader.each_slot([&](const SlotUse& slot) { slots.push_back(slot); }).ok());
  ASSERT_EQ(slots.size(), 1U);
  EXPECT_EQ(slots[0], (SlotUse{1, SubchainId{1}, at(seconds{100}), at(seconds{101}), at(seconds{102})}));
  std::vector<Steal> steals;
  ASSERT_TRUE(reader.each_steal([&](const Steal& steal) { steals.push_back(steal); }).ok());
  ASSERT_EQ(steals.size(), 1U);
  EXPECT_EQ(steals[0], (Steal{1, SubchainId{0}, SubchainId{1}, at(seconds{100}), at(seconds{101})}));
  const auto plans = reader.plans();
  ASSERT_TRUE(plans.ok());
  ASSERT_EQ(plans->size(), 2U);
  EXPECT_EQ(plans->at(0).json, "{\"a\": 1}");
  EXPECT_EQ(plans->at(1).at, at(seconds{101}));
  EXPECT_EQ(plans->at(1).reason, "measured");
  const auto changes = reader.cost_changes();
  ASSERT_TRUE(changes.ok());
  EXPECT_EQ(*changes, std::vector{change});
  const auto app_changes = reader.app_changes();
  ASSERT_TRUE(app_changes.ok());
  EXPECT_EQ(*app_changes, asked);
  const auto changed = app_after(reader.app(), *app_changes);
  ASSERT_TRUE(changed.ok()) << changed.error().message();
  EXPECT_EQ(differences(app, *changed, at(seconds{101})).size(), 3U);
  EXPECT_EQ(describe(app, asked[1]), "objective[0].max (scan -> LM -> LP -> base): 60ms -> none");
  const auto clocks = reader.clocks();
  ASSERT_TRUE(clocks.ok());
  EXPECT_EQ(*clocks, std::vector{reading});
  const auto notices = reader.notices();
  ASSERT_TRUE(notices.ok());
  ASSERT_EQ(notices->size(), 1U);
  EXPECT_EQ(notices->at(0).detail, "it's \"so\"");
}

// No writer writes such.
TEST(Record, RunsOfANodeThatEndInAnyOrderComeByTheirEnds) {
  const Folder folder;
  const graph::App app = robot();
  const NodeId scan = *app.graph.find_node("scan");
  const NodeId local = *app.graph.find_node("LM");
  const auto writer = make(folder.file("r"), app);
  const auto add = [&](NodeId node, std::uint64_t number, int end) {
    writer->add(record::Run{node, number, at(seconds{100}), at(seconds{100 + end}), Nanos{1}, 0, true, {}});
  };
  add(scan, 1, 5);
  add(scan, 2, 3);
  add(local, 1, 4);
  ASSERT_TRUE(writer->close(at(seconds{110}), header().host).ok());
  std::vector<TimePoint> ends;
  for (const record::Run& run : read_runs(open(folder.file("r")))) ends.push_back(run.end);
  EXPECT_EQ(ends, (std::vector<TimePoint>{at(seconds{103}), at(seconds{104}), at(seconds{105})}));
}

TEST(Record, RunsComeByWhenTheyBeganToo) {
  const Folder folder;
  const graph::App app = robot();
  const auto writer = make(folder.file("r"), app);
  for (const record::Run& run : runs(app, seconds{103}, 1)) writer->add(run);
  ASSERT_TRUE(writer->close(at(seconds{110}), header().host).ok());
  std::vector<record::Run> expected = runs(app, seconds{103}, 1);
  for (record::Run& run : expected) run.consumed.clear();
  std::stable_sort(expected.begin(), expected.end(), [](const auto& a, const auto& b) { return a.begin < b.begin; });
  std::vector<record::Run> read;
  ASSERT_TRUE(open(folder.file("r")).each_run_by_begin([&](const record::Run& run) { read.push_back(run); }).ok());
  EXPECT_EQ(read, expected);
}

TEST(Record, RunsComeWithThoseThatConsumedThem) {
  const Folder folder;
  const graph::App app = robot();
  const auto id = [&](const char* name) { return *app.graph.find_node(name); };
  const auto writer = make(folder.file("r"), app);
  const auto add = [&](const char* node, std::uint64_t number, std::vector<Consumed> consumed) {
    writer->add(record::Run{id(node), number, at(seconds{103}), at(seconds{104}), Nanos{0}, 0, true, consumed});
  };
  for (std::uint64_t i = 1; i < 6; ++i) add("scan", i, {});
  add("LM", 1, {{id("scan"), 2, 2}});
  add("LM", 2, {{id("scan"), 2, 2}});
  add("LM", 3, {{id("scan"), 9, 9}});  // which is not there
  add("GL", 1, {{id("scan"), 1, 3}});
  add("LP", 1, {{id("LM"), 1, 1}, {id("GL"), 1, 1}});
  ASSERT_TRUE(writer->close(at(seconds{110}), header().host).ok());

  std::map<std::pair<NodeId, std::uint64_t>, std::vector<Consumer>> consumers;
  std::vector<std::pair<NodeId, std::uint64_t>> order;
  const auto done = open(folder.file("r")).each_run_with_consumers([&](const record::Run& run, auto taken_by) {
    order.emplace_back(run.node, run.number);
    consumers[order.back()] = {taken_by.begin(), taken_by.end()};
  });
  ASSERT_TRUE(done.ok());
  EXPECT_TRUE(std::is_sorted(order.begin(), order.end()));
  EXPECT_EQ(order.size(), 10U);
  std::erase_if(consumers, [](const auto& entry) { return entry.second.empty(); });
  const decltype(consumers) expected{{{id("scan"), 1}, {{id("GL"), 1}}},
                                     {{id("scan"), 2}, {{id("GL"), 1}, {id("LM"), 1}, {id("LM"), 2}}},
                                     {{id("scan"), 3}, {{id("GL"), 1}}},
                                     {{id("LM"), 1}, {{id("LP"), 1}}},
                                     {{id("GL"), 1}, {{id("LP"), 1}}}};
  EXPECT_EQ(consumers, expected);
}

// With a period it would run by a timer.
TEST(Record, WhoFollowsFollowsAgain) {
  const Folder folder;
  graph::AppSpec spec;
  spec.name.value = "driver";
  for (const char* name : {"imu", "sum", "own", "sink"}) spec.nodes.emplace_back().name.value = name;
  for (std::size_t index = 0; index < 3; ++index) spec.nodes[index].unscheduled = true;
  for (const std::size_t index : {0U, 2U}) spec.nodes[index].period = graph::At<Nanos>{milliseconds{5}, {}};
  spec.edges = {{names("imu sum sink"), {}}, {names("imu own sink"), {}}};
  spec.objective.resize(1);
  spec.objective[0].path = names("sink");
  const auto app = graph::build_app(spec);
  ASSERT_TRUE(app.ok()) << app.error().message();
  ASSERT_TRUE(make(folder.file("r"), *app)->close(at(seconds{100}), {}).ok());
  const Reader reader = open(folder.file("r"));
  expect_equal(reader.app(), *app);
  EXPECT_EQ(reader.app().graph.node(NodeId(1)).follows, NodeId(0));
  EXPECT_EQ(reader.app().graph.node(NodeId(2)).follows, std::nullopt);
}

TEST(Record, GivesBackOptionsThatWereNotSet) {
  const Folder folder;
  graph::App app = robot();
  app.scheduler.slack.reset();
  Header first = header();
  first.slack.reset();
  auto writer = Writer::create(folder.file("r"), app, first);
  ASSERT_TRUE(writer.ok());
  ASSERT_TRUE((*writer)->close(at(seconds{100}), {}).ok());
  const Reader reader = open(folder.file("r"));
  expect_equal(reader.app(), app);
  EXPECT_EQ(reader.header().slack, std::nullopt);
  EXPECT_EQ(reader.ending().stolen, Nanos{0});
}

TEST(Record, NothingRecordedIsEverOverwritten) {
  const Folder folder;
  write_bytes(folder.file("r"), "precious");
  const auto writer = Writer::create(folder.file("r"), robot(), header());
  ASSERT_FALSE(writer.ok());
  EXPECT_EQ(writer.error().kind(), ErrorKind::kCaller);
  EXPECT_EQ(read_bytes(folder.file("r")), "precious");
}

TEST(Record, AFolderThatIsNotThereIsTheMachinesFault) {
  const Folder folder;
  const auto writer = Writer::create(folder.file("no/r"), robot(), header());
  ASSERT_FALSE(writer.ok());
  EXPECT_EQ(writer.error().kind(), ErrorKind::kEnvironment);
}

TEST(Record, APathIsAPathWhateverSqliteMakesOfIt) {
  const Folder folder;
  const auto before = std::filesystem::current_path();
  std::filesystem::current_path(folder.file(""));
  for (const char* name : {":memory:", "file:x?mode=memory", "a b%20c"}) {
    ASSERT_TRUE(make(name, robot())->close(at(seconds{100}), {}).ok());
    EXPECT_TRUE(std::filesystem::exists(folder.file(name))) << name;
    EXPECT_TRUE(Reader::open(name).ok()) << name;
  }
  std::filesystem::current_path(before);
}

TEST(Record, WithoutACloseIsReadableUpToTheLastFlush) {
  const Folder folder;
  const graph::App app = robot();
  const auto writer = make(folder.file("r"), app);
  const std::vector<record::Run> first = runs(app, seconds{100}, 1);
  for (const record::Run& run : first) writer->add(run);
  ASSERT_TRUE(writer->flush().ok());
  for (const record::Run& run : runs(app, seconds{101}, 3)) writer->add(run);
  // As a kill would leave it: one file.
  EXPECT_FALSE(std::filesystem::exists(folder.file("r-journal")));
  std::filesystem::copy_file(folder.file("r"), folder.file("killed"));
  const Reader reader = open(folder.file("killed"));
  EXPECT_EQ(read_runs(reader), first);
  EXPECT_FALSE(reader.ending().closed);
  EXPECT_EQ(reader.ending().ended, first.back().end);
}

TEST(Record, KilledAtAnyMomentHoldsWholeBatches) {
  const Folder folder;
  const graph::App app = robot();
  int kills = 0;
  {
    // Before each change of a file, keep what a kill would leave.
    const FaultyVfs vfs([&] {
      ++kills;
      for (const char* end : {"", "-journal"}) {
        const std::string name = folder.file("r") + end;
        if (std::filesystem::exists(name)) {
          std::filesystem::copy_file(name, folder.file("killed" + std::to_string(kills)) + end);
        }
      }
      return SQLITE_OK;
    });
    const auto writer = make(folder.file("r"), app);
    for (std::uint64_t batch = 0; batch < 3; ++batch) {
      for (const record::Run& run : runs(app, seconds{100 + batch}, 2 * batch + 1)) writer->add(run);
      ASSERT_TRUE(writer->flush().ok());
    }
    ASSERT_TRUE(writer->close(at(seconds{110}), {}).ok());
  }
  ASSERT_GT(kills, 20);
  std::size_t max = 0;
  int laid_out = 0;
  for (int kill = 1; kill <= kills; ++kill) {
    const auto reader = Reader::open(folder.file("killed" + std::to_string(kill)));
    if (!reader) {
      EXPECT_EQ(laid_out, 0) << "a record that could be read once can be read ever after";
      EXPECT_THAT(reader.error().message(), HasSubstr("no Catan record"));
      continue;
    }
    ++laid_out;
    const std::size_t count = read_runs(*reader).size();
    EXPECT_EQ(count % 7, 0U) << "half a batch";
    EXPECT_GE(count, max) << "what was committed is lost";
    max = count;
  }
  EXPECT_EQ(max, 21U);
}

TEST(Record, TheFirstFailureStaysAndTheFileStaysReadable) {
  const graph::App app = robot();
  // Fail the n-th change of a file after the record was laid out, for all n until nothing fails.
  for (int n = 0;; ++n) {
    const Folder folder;
    int changes = -1;  // none counted
    bool failed = false;
    {
      const FaultyVfs vfs([&] {
        if (changes >= 0 && changes++ >= n) failed = true;
        return failed ? SQLITE_FULL : SQLITE_OK;
      });
      const auto writer = make(folder.file("r"), app);
      changes = 0;
      for (const record::Run& run : runs(app, seconds{100}, 1)) writer->add(run);
      const Status flushed = writer->flush();
      for (const record::Run& run : runs(app, seconds{101}, 3)) writer->add(run);
      const Status again = writer->flush();
      const Status closed = writer->close(at(seconds{110}), {});
      if (!failed) {
        EXPECT_TRUE(closed.ok());
        ASSERT_GT(n, 10);
        break;
      }
      ASSERT_FALSE(closed.ok());
      EXPECT_EQ(closed.error().kind(), ErrorKind::kEnvironment);
      for (const Status& earlier : {flushed, again}) {
        if (!earlier) {
          EXPECT_EQ(earlier.error().message(), closed.error().message());
        }
      }
      EXPECT_THAT(closed.error().message(), HasSubstr("make room"));
    }
    const Reader reader = open(folder.file("r"));
    EXPECT_EQ(read_runs(reader).size() % 7, 0U) << "half a batch after failure " << n;
  }
}

TEST(Record, AFullDiskAtTheStartLeavesNoFile) {
  for (int n = 0;; ++n) {
    const Folder folder;
    int changes = 0;
    const FaultyVfs vfs([&] { return changes++ >= n ? SQLITE_FULL : SQLITE_OK; });
    const auto writer = Writer::create(folder.file("r"), robot(), header());
    if (writer.ok()) break;
    EXPECT_EQ(writer.error().kind(), ErrorKind::kEnvironment) << writer.error().message();
    EXPECT_FALSE(std::filesystem::exists(folder.file("r")));
  }
}

TEST(Record, AReaderThatHoldsTheFileOnlyDelaysTheWriter) {
  const Folder folder;
  const graph::App app = robot();
  const auto writer = make(folder.file("r"), app);
  {
    auto other = sqlite::Database::open(folder.file("r"), SQLITE_OPEN_READONLY);
    ASSERT_TRUE(other->execute("BEGIN; SELECT * FROM meta").ok());
    for (const record::Run& run : runs(app, seconds{100}, 1)) writer->add(run);
    EXPECT_TRUE(writer->flush().ok()) << "deferred";
    ASSERT_TRUE(other->execute("COMMIT").ok());
  }
  EXPECT_TRUE(writer->flush().ok());
  EXPECT_EQ(read_runs(open(folder.file("r"))).size(), 7U);
}

TEST(Record, WritesUnaskedWhenMuchHasGathered) {
  const Folder folder;
  const graph::App app = robot();
  const auto writer = make(folder.file("r"), app);
  for (int i = 0; i < 10000; ++i) writer->add(Notice{at(seconds{100}), "watchdog", std::to_string(i)});
  const auto notices = open(folder.file("r")).notices();
  ASSERT_TRUE(notices.ok());
  EXPECT_EQ(notices->size(), 8192U);
}

TEST(Record, ARunAddedTwiceIsAFailureThatStays) {
  const Folder folder;
  const graph::App app = robot();
  const auto writer = make(folder.file("r"), app);
  writer->add(runs(app, seconds{100}, 1).front());
  writer->add(runs(app, seconds{100}, 1).front());
  EXPECT_FALSE(writer->flush().ok());
  EXPECT_FALSE(writer->close(at(seconds{101}), {}).ok());
  EXPECT_FALSE(writer->close(at(seconds{101}), {}).ok());
}

}  // namespace
}  // namespace ctn::record
