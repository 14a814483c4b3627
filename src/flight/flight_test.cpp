#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <map>
#include <thread>

#include "flight/find.h"
#include "flight/late_watch.h"
#include "flight/recorder.h"
#include "flight/recording.h"
#include "record/testing/record_fixture.h"

namespace ctn::flight {
namespace {

using namespace record::test;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

// Keeps all that it is told.
struct Told : record::Sink {
  std::vector<record::Run> runs;
  std::vector<record::Trigger> triggers;
  std::vector<record::SlotUse> slots;
  std::vector<record::Steal> steals;
  std::vector<record::Overrun> overruns;
  std::vector<record::PlanChange> plans;
  std::vector<record::CostChange> cost_changes;
  std::vector<record::AppChange> app_changes;
  std::vector<record::ClockReading> clocks;
  std::vector<record::Notice> notices;
  std::vector<record::Totals> totals;

  void add(const record::Run& run) override { runs.push_back(run); }
  void add(const record::Trigger& trigger) override { triggers.push_back(trigger); }
  void add(const record::SlotUse& slot) override { slots.push_back(slot); }
  void add(const record::Steal& steal) override { steals.push_back(steal); }
  void add(const record::Overrun& overrun) override { overruns.push_back(overrun); }
  void add(const record::PlanChange& change) override { plans.push_back(change); }
  void add(const record::CostChange& change) override { cost_changes.push_back(change); }
  void add(const record::AppChange& change) override { app_changes.push_back(change); }
  void add(const record::ClockReading& reading) override { clocks.push_back(reading); }
  void add(const record::Notice& notice) override { notices.push_back(notice); }
  void set_totals(const record::Totals& of) override { totals.push_back(of); }

  std::size_t events() const {
    return runs.size() + triggers.size() + slots.size() + steals.size() + overruns.size() + plans.size() +
           cost_changes.size() + app_changes.size() + clocks.size() + notices.size() + totals.size();
  }
};

std::unique_ptr<Recorder> recorder_of(const graph::App& app, std::size_t bytes = Recorder::kMinBytes) {
  auto recorder = Recorder::create(app, header(), os::ProcessId{static_cast<std::int32_t>(::getpid())}, bytes);
  EXPECT_TRUE(recorder.ok()) << (recorder ? "" : recorder.error().message());
  return std::move(*recorder);
}

Recording recording_of(const Recorder& recorder) {
  auto memory = recorder.readable();
  EXPECT_TRUE(memory.ok());
  auto recording = Recording::open(std::move(*memory));
  EXPECT_TRUE(recording.ok()) << (recording ? "" : recording.error().message());
  return std::move(*recording);
}

// The head of the robot's first subchain; `number` decides all of it.
record::Run scan(const graph::App& app, std::uint64_t number) {
  const TimePoint begin = at(seconds{101}) + number * milliseconds{10};
  return {*app.graph.find_node("scan"),
          number,
          begin,
          begin + Nanos{static_cast<std::int64_t>(number)},
          Nanos{static_cast<std::int64_t>(number)},
          0,
          true,
          {}};
}

class FlightTest : public testing::Test {
 protected:
  const graph::App app_ = robot();
  Folder folder_;
};

TEST_F(FlightTest, EventsComeOutAsTheyWentIn) {
  const auto recorder = recorder_of(app_);
  Recording recording = recording_of(*recorder);
  const NodeId lamp = *app_.graph.find_node("lamp");
  record::Run run = runs(app_, seconds{103}, 1).back();
  run.on_cpu = 2;
  run.wait = milliseconds{3};
  const record::Trigger trigger{SubchainId(0), 7, at(seconds{101}), at(seconds{102})};
  const record::SlotUse slot{3, SubchainId(0), at(seconds{101}), at(seconds{102}), at(seconds{103})};
  const record::Steal steal{3, SubchainId(0), SubchainId(1), at(seconds{102}), at(seconds{103})};
  const record::Overrun overrun{SubchainId(1), 3, at(seconds{101}), milliseconds{5}};
  const record::PlanChange plan{at(seconds{101}), "periodic", "{\"a plan\": \"of some length\"}"};
  const record::CostChange cost{at(seconds{101}), NodeId(2), 0, 1, milliseconds{3}, milliseconds{4}, 12};
  const record::AppChange change{at(seconds{101}), record::AppChange::What::kMax, 0, 60.0, std::nullopt};
  const record::ClockReading clock{at(seconds{101}), lamp, {at(seconds{100}), milliseconds{8}}};
  const record::Notice notice{at(seconds{101}), "starved", ""};
  const record::Totals totals{3, milliseconds{20}, 1, milliseconds{2}};
  recorder->add(run);
  recorder->add(trigger);
  recorder->add(slot);
  recorder->add(steal);
  recorder->add(overrun);
  recorder->add(plan);
  recorder->add(cost);
  recorder->add(change);
  recorder->add(clock);
  recorder->add(notice);
  recorder->set_totals(totals);
  Told told;
  EXPECT_EQ(recording.read_new(told), 0U);
  EXPECT_THAT(told.runs, ElementsAre(run));
  ASSERT_THAT(told.triggers, SizeIs(1));
  EXPECT_EQ(told.triggers[0].number, trigger.number);
  EXPECT_EQ(told.triggers[0].due, trigger.due);
  EXPECT_EQ(told.triggers[0].sent, trigger.sent);
  EXPECT_THAT(told.slots, ElementsAre(slot));
  EXPECT_THAT(told.steals, ElementsAre(steal));
  EXPECT_THAT(told.overruns, ElementsAre(overrun));
  ASSERT_THAT(told.plans, SizeIs(1));
  EXPECT_EQ(told.plans[0].reason, plan.reason);
  EXPECT_EQ(told.plans[0].json, plan.json);
  EXPECT_THAT(told.cost_changes, ElementsAre(cost));
  EXPECT_THAT(told.app_changes, ElementsAre(change));
  EXPECT_THAT(told.clocks, ElementsAre(clock));
  ASSERT_THAT(told.notices, SizeIs(1));
  EXPECT_EQ(told.notices[0].kind, notice.kind);
  EXPECT_EQ(told.notices[0].detail, notice.detail);
  EXPECT_THAT(told.totals, ElementsAre(totals));
}

TEST_F(FlightTest, ReadersAreToldWhatIsNew) {
  const auto recorder = recorder_of(app_);
  Recording one = recording_of(*recorder);
  recorder->add(scan(app_, 1));
  Recording other = recording_of(*recorder);
  Told first;
  EXPECT_EQ(one.read_new(first), 0U);
  EXPECT_THAT(first.runs, ElementsAre(scan(app_, 1)));
  recorder->add(scan(app_, 2));
  Told second;
  EXPECT_EQ(one.read_new(second), 0U);
  EXPECT_THAT(second.runs, ElementsAre(scan(app_, 2)));
  Told both;
  EXPECT_EQ(other.read_new(both), 0U);
  EXPECT_THAT(both.runs, ElementsAre(scan(app_, 1), scan(app_, 2)));
  Told none;
  EXPECT_EQ(one.read_new(none), 0U);
  EXPECT_EQ(none.events(), 0U);
}

TEST_F(FlightTest, TheNewestOverwriteTheOldest) {
  const auto recorder = recorder_of(app_);
  Recording late = recording_of(*recorder);
  Told before;
  late.read_new(before);
  constexpr std::uint64_t kRuns = 20'000;
  for (std::uint64_t number = 1; number <= kRuns; ++number) recorder->add(scan(app_, number));
  Told told;
  EXPECT_GT(late.read_new(told), 0U);  // what it missed
  ASSERT_THAT(told.runs, testing::Not(IsEmpty()));
  EXPECT_GT(told.runs.front().number, 1U);
  for (std::size_t index = 0; index < told.runs.size(); ++index) {
    EXPECT_EQ(told.runs[index], scan(app_, kRuns - told.runs.size() + 1 + index));
  }
  // A run takes less than 16 words of the ring.
  EXPECT_GE(told.runs.size(), Recorder::kMinBytes / 8 / 16);
  Told of_new_reader;
  EXPECT_EQ(recording_of(*recorder).read_new(of_new_reader), 0U);
  EXPECT_EQ(of_new_reader.runs, told.runs);
}

TEST_F(FlightTest, WhatHoldsIsThereHoweverOldItIs) {
  const auto recorder = recorder_of(app_);
  const record::AppChange old_weight{at(seconds{101}), record::AppChange::What::kWeight, 0, 1.0, 0.7};
  const record::AppChange weight{at(seconds{102}), record::AppChange::What::kWeight, 0, 0.7, 0.5};
  const record::AppChange bound{at(seconds{102}), record::AppChange::What::kMax, 2, std::nullopt, 9.0};
  const record::ClockReading clock{at(seconds{101}), *app_.graph.find_node("lamp"), {at(seconds{1}), seconds{1}}};
  recorder->add(record::PlanChange{at(seconds{101}), "bootstrap", "{}"});
  recorder->add(record::PlanChange{at(seconds{102}), "measured", "{ }"});
  for (const auto& change : {old_weight, weight, bound}) recorder->add(change);
  recorder->add(clock);
  recorder->set_totals({4, milliseconds{1}, 0, Nanos{0}});
  for (std::uint64_t number = 1; number <= 20'000; ++number) recorder->add(scan(app_, number));
  Told told;
  EXPECT_EQ(recording_of(*recorder).read_new(told), 0U);
  ASSERT_THAT(told.plans, testing::Not(IsEmpty()));
  for (const record::PlanChange& plan : told.plans) EXPECT_EQ(plan.reason, "measured");
  EXPECT_THAT(told.app_changes, testing::Each(testing::AnyOf(weight, bound)));
  EXPECT_THAT(told.app_changes, testing::AllOf(testing::Contains(weight), testing::Contains(bound)));
  EXPECT_THAT(told.clocks, testing::Contains(clock));
  EXPECT_THAT(told.totals, testing::Not(IsEmpty()));
}

// Not even for the moment in which an event is written.
TEST_F(FlightTest, WhatHoldsIsThereWheneverItIsRead) {
  const auto recorder = recorder_of(app_);
  recorder->add(record::PlanChange{at(seconds{101}), "measured", std::string(2000, 'p')});
  std::atomic<bool> done{false};
  std::thread writer([&] {
    for (std::uint64_t number = 1; !done.load(); ++number) {
      recorder->add(scan(app_, number));
      if (number % 64 == 0) std::this_thread::sleep_for(microseconds{20});
    }
  });
  int whole = 0;
  while (whole < 300) {
    Recording recording = recording_of(*recorder);
    Told told;
    if (recording.read_new(told) > 0) continue;  // overtaken while it copied: what is left says nothing
    ++whole;
    EXPECT_FALSE(told.plans.empty());
  }
  done.store(true);
  writer.join();
}

TEST_F(FlightTest, AnEventOfTheRingsLengthIsLeftOut) {
  const auto recorder = recorder_of(app_);
  recorder->add(scan(app_, 1));
  recorder->add(record::Notice{at(seconds{101}), "long", std::string(Recorder::kMinBytes, 'x')});
  recorder->add(record::PlanChange{at(seconds{101}), "long", std::string(Recorder::kMinBytes, 'x')});
  recorder->add(scan(app_, 2));
  Told told;
  EXPECT_EQ(recording_of(*recorder).read_new(told), 0U);
  EXPECT_THAT(told.runs, ElementsAre(scan(app_, 1), scan(app_, 2)));
  EXPECT_THAT(told.notices, IsEmpty());
  EXPECT_THAT(told.plans, IsEmpty());
}

TEST_F(FlightTest, TellsOfTheRunAndItsProcess) {
  auto recorder = recorder_of(app_);
  const Recording recording = recording_of(*recorder);
  EXPECT_EQ(recording.app().name, "robot");
  EXPECT_EQ(recording.app().graph.nodes().size(), app_.graph.nodes().size());
  EXPECT_EQ(recording.header().scheduler, "catan");
  EXPECT_EQ(recording.process(), ::getpid());
  recorder->show_alive(at(seconds{123}));
  EXPECT_EQ(recording.seen_alive(), at(seconds{123}));
  EXPECT_FALSE(recording.over());
  recorder.reset();
  EXPECT_TRUE(recording.over());
}

// Whole entries only, whenever they are read. The reader may be late, but what it gets is as it was written.
TEST_F(FlightTest, IsReadWhileItIsWritten) {
  const auto recorder = recorder_of(app_);
  Recording recording = recording_of(*recorder);
  constexpr std::uint64_t kRuns = 60'000;
  std::atomic<bool> done{false};
  std::thread writer([&] {
    for (std::uint64_t number = 1; number <= kRuns; ++number) recorder->add(scan(app_, number));
    done.store(true);
  });
  std::uint64_t last = 0;
  std::uint64_t reads = 0;
  while (true) {
    const bool was_done = done.load();
    Told told;
    recording.read_new(told);
    ++reads;
    for (const record::Run& run : told.runs) {
      ASSERT_GT(run.number, last);
      ASSERT_EQ(run, scan(app_, run.number));
      last = run.number;
    }
    if (was_done) break;
  }
  writer.join();
  EXPECT_EQ(last, kRuns);
  EXPECT_GT(reads, 1U);
}

TEST_F(FlightTest, IsSavedAsARecord) {
  const auto recorder = recorder_of(app_);
  recorder->add(record::PlanChange{at(seconds{101}), "bootstrap", "{}"});
  const std::vector<record::Run> all = runs(app_, seconds{103}, 1);
  for (const record::Run& run : all) recorder->add(run);
  recorder->add(record::Trigger{SubchainId(0), 1, at(seconds{103}), at(seconds{103})});
  recorder->set_totals({4, milliseconds{1}, 2, milliseconds{3}});
  const std::string path = folder_.file("saved.catan");
  const Recording recording = recording_of(*recorder);
  const Status saved = recording.save(path, "a test asked", header().host);
  ASSERT_TRUE(saved.ok()) << saved.error().message();
  const record::Reader record = open(path);
  EXPECT_THAT(read_runs(record), SizeIs(all.size()));
  EXPECT_EQ(record.header().started, header().started);
  EXPECT_EQ(record.header().warm_up, header().warm_up);
  EXPECT_TRUE(record.ending().closed);
  EXPECT_EQ(record.ending().starved, milliseconds{3});
  ASSERT_THAT(*record.plans(), SizeIs(1));
  EXPECT_EQ(record.plans()->front().at, at(seconds{101}));
  ASSERT_THAT(*record.notices(), SizeIs(1));
  EXPECT_EQ(record.notices()->front().kind, "flight-recorder");
  EXPECT_THAT(record.notices()->front().detail, HasSubstr("a test asked"));
  EXPECT_FALSE(recording.save(path, "again", header().host).ok());  // nothing recorded is overwritten
}

TEST_F(FlightTest, ASavedRecordBeginsWithTheOldestEventThatIsKept) {
  const auto recorder = recorder_of(app_);
  recorder->add(record::PlanChange{at(seconds{101}), "measured", "{}"});
  constexpr std::uint64_t kRuns = 20'000;
  for (std::uint64_t number = 1; number <= kRuns; ++number) recorder->add(scan(app_, number));
  const std::string path = folder_.file("saved.catan");
  ASSERT_TRUE(recording_of(*recorder).save(path, "asked", header().host).ok());
  const record::Reader record = open(path);
  const std::vector<record::Run> kept = read_runs(record);
  ASSERT_THAT(kept, testing::Not(IsEmpty()));
  EXPECT_EQ(record.header().started, kept.front().begin);
  EXPECT_EQ(record.header().warm_up, Nanos{0});
  EXPECT_EQ(record.ending().ended, kept.back().end);
  EXPECT_EQ(kept.back(), scan(app_, kRuns));
  // The plan in force, once, and from the record's start on.
  ASSERT_THAT(*record.plans(), SizeIs(1));
  EXPECT_EQ(record.plans()->front().at, record.header().started);
}

TEST_F(FlightTest, OtherMemoryIsRefused) {
  EXPECT_FALSE(Recording::open(os::Descriptor()).ok());
  for (const std::size_t size : {std::size_t{1}, sizeof(Head) - 1, sizeof(Head), std::size_t{100'000}}) {
    auto memory = os::SharedMemory::create("none", size);
    ASSERT_TRUE(memory.ok());
    EXPECT_FALSE(Recording::open(*memory->read_only()).ok()) << size;
  }
}

// Whatever another process writes into the memory, reading ends, and what is handed on could have happened.
TEST_F(FlightTest, NothingInTheMemoryIsTrusted) {
  const auto recorder = recorder_of(app_);
  recorder->add(record::PlanChange{at(seconds{101}), "measured", "{}"});
  for (const record::Run& run : runs(app_, seconds{103}, 1)) recorder->add(run);
  recorder->add(record::SlotUse{3, SubchainId(0), at(seconds{101}), at(seconds{102}), at(seconds{103})});
  auto memory = os::SharedMemory::open(os::Descriptor(::dup(recorder->readable()->number())));
  ASSERT_FALSE(memory.ok());  // a reader's descriptor is read-only
  // So another memory with the same content, as a process might forge it.
  const auto original = os::ReadOnlyMemory::open(*recorder->readable());
  auto copy = os::SharedMemory::create("copy", original->bytes().size());
  ASSERT_TRUE(copy.ok());
  const std::size_t words = copy->bytes().size() / sizeof(Word);
  const std::size_t image_words = words - Recorder::kMinBytes / sizeof(Word);
  std::size_t opened = 0;
  for (const Word value : {Word{0}, Word{1}, Word{9}, ~Word{0}, Word{1} << 62U, Word{0x7fffffff}}) {
    for (std::size_t word = 0; word < words; word += word < sizeof(Head) / sizeof(Word) ? 1 : 7) {
      if (word > sizeof(Head) / sizeof(Word) && word < image_words) {
        word += 97;  // the image is a record's, which has tests of its own
      }
      if (word > image_words + 200) break;  // nothing was written there
      std::memcpy(copy->bytes().data(), original->bytes().data(), original->bytes().size());
      std::memcpy(copy->bytes().data() + word * sizeof(Word), &value, sizeof value);
      auto recording = Recording::open(*copy->read_only());
      if (!recording) continue;
      ++opened;
      Told told;
      recording->read_new(told);
      for (const record::Run& run : told.runs) EXPECT_LT(run.node.index(), app_.graph.nodes().size());
      for (const record::SlotUse& slot : told.slots) EXPECT_LT(slot.subchain.index(), app_.graph.subchains().size());
    }
  }
  EXPECT_GT(opened, 100U);
}

TEST_F(FlightTest, IsFoundByItsAppAndItsProcess) {
  const std::string process = std::to_string(::getpid());
  EXPECT_FALSE(find(process).ok());
  auto recorder = recorder_of(app_);
  const Recording reader = recording_of(*recorder);  // it has a descriptor of the memory, too
  auto found = find(process);
  ASSERT_TRUE(found.ok()) << found.error().message();
  EXPECT_EQ(Recording::open(std::move(*found))->process(), ::getpid());
  EXPECT_FALSE(find("no such app").ok());
  const auto second = recorder_of(app_);
  const auto several = find(process);
  ASSERT_FALSE(several.ok());
  EXPECT_THAT(several.error().message(), HasSubstr(process + " (robot), " + process + " (robot)"));
  recorder.reset();  // the run is over, though a reader still has the memory
  EXPECT_TRUE(find(process).ok());
}

// --- Late responses ---

class LateWatchTest : public FlightTest {
 protected:
  // The robot's local subchain, one run of each node after the other; LP's takes so long. A response goes on to the end
  // of the next output.
  void step(LateWatch& watch, Nanos cost) {
    const std::uint64_t number = ++number_;
    const TimePoint begin = at(seconds{103}) + number * milliseconds{20};
    const NodeId head = *app_.graph.find_node("scan");
    const NodeId map = *app_.graph.find_node("LM");
    const NodeId plan = *app_.graph.find_node("LP");
    watch.add(record::Run{head, number, begin, begin, Nanos{0}, 0, true, {}});
    watch.add(record::Run{map, number, begin, begin, Nanos{0}, 0, true, {{head, number, number}}});
    watch.add(record::Run{plan, number, begin, begin + cost, cost, 0, true, {{map, number, number}}});
  }
  std::uint64_t number_ = 0;
};

TEST_F(LateWatchTest, TellsWhatIsLongerThanItsBound) {
  LateWatch watch(app_, {{0, std::nullopt}}, at(seconds{100}));
  step(watch, milliseconds{5});
  step(watch, milliseconds{5});  // a response of 25 ms; the bound is 60 ms
  EXPECT_FALSE(watch.take());
  step(watch, milliseconds{50});
  const auto late = watch.take();
  ASSERT_TRUE(late.has_value());
  EXPECT_EQ(late->term, 0U);
  EXPECT_EQ(late->response, milliseconds{70});
  EXPECT_EQ(late->over, milliseconds{60});
  EXPECT_FALSE(watch.take());
}

TEST_F(LateWatchTest, TakesTheBoundThatHolds) {
  LateWatch watch(app_, {{0, std::nullopt}}, at(seconds{100}));
  watch.add(record::AppChange{at(seconds{103}), record::AppChange::What::kMax, 0, 60.0, 24.0});
  step(watch, milliseconds{5});
  step(watch, milliseconds{5});
  EXPECT_EQ(watch.take()->over, milliseconds{24});
  watch.add(record::AppChange{at(seconds{104}), record::AppChange::What::kMax, 0, 24.0, std::nullopt});
  step(watch, milliseconds{50});
  EXPECT_FALSE(watch.take());  // no bound, and no plan that promises anything
}

TEST_F(LateWatchTest, TakesTheLimitThatIsGivenAndTheLongest) {
  LateWatch watch(app_, {{0, milliseconds{10}}}, at(seconds{100}));
  step(watch, milliseconds{5});
  step(watch, milliseconds{9});
  step(watch, milliseconds{7});
  const auto late = watch.take();
  ASSERT_TRUE(late.has_value());
  EXPECT_EQ(late->response, milliseconds{29});
  EXPECT_EQ(late->over, milliseconds{10});
}

// Guards: catan watch told how often it had seen late responses, each time one of many.
TEST_F(LateWatchTest, CountsAllThatWereLate) {
  LateWatch watch(app_, {{0, milliseconds{10}}}, at(seconds{100}));
  for (int count = 0; count < 5; ++count) step(watch, milliseconds{5});
  EXPECT_TRUE(watch.take());
  EXPECT_EQ(watch.take_count(), 4U);  // the last run's response is not over yet
  EXPECT_EQ(watch.take_count(), 0U);
  step(watch, milliseconds{5});
  EXPECT_EQ(watch.take_count(), 1U);
}

TEST_F(LateWatchTest, LeavesOutWhatBeganBefore) {
  LateWatch watch(app_, {{0, milliseconds{10}}}, at(seconds{200}));
  step(watch, milliseconds{5});
  step(watch, milliseconds{5});
  EXPECT_FALSE(watch.take());
}

}  // namespace
}  // namespace ctn::flight
