// Sinks that stand between where something happens and where it goes.
#include "record/sink.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <vector>

namespace ctn::record {
namespace {

using testing::ElementsAre;

// Remembers what it is told, in words.
class Told : public Sink {
 public:
  void add(const Run& run) override { say("run", run.number); }
  void add(const Trigger& trigger) override { say("trigger", trigger.number); }
  void add(const SlotUse& /*slot*/) override { say("slot", 0); }
  void add(const Steal& /*steal*/) override { say("steal", 0); }
  void add(const Overrun& overrun) override { say("overrun", overrun.number); }
  void add(const PlanChange& /*change*/) override { say("plan", 0); }
  void add(const CostChange& change) override { say("cost", change.runs); }
  void add(const AppChange& change) override { say("app", change.item); }
  void add(const ClockReading& /*reading*/) override { say("clock", 0); }
  void add(const Notice& /*notice*/) override { say("notice", 0); }
  void set_totals(const Totals& totals) override { say("totals", totals.starved); }

  std::vector<std::string> words;

 private:
  void say(const std::string& word, std::uint64_t number) { words.push_back(word + " " + std::to_string(number)); }
};

void tell_all(Sink& sink) {
  Run run;
  run.number = 1;
  sink.add(run);
  Trigger trigger;
  trigger.number = 2;
  sink.add(trigger);
  sink.add(SlotUse{});
  sink.add(Steal{});
  Overrun overrun;
  overrun.number = 3;
  sink.add(overrun);
  sink.add(PlanChange{});
  CostChange cost;
  cost.runs = 4;
  sink.add(cost);
  AppChange change;
  change.item = 5;
  sink.add(change);
  sink.add(ClockReading{});
  sink.add(Notice{});
  Totals totals;
  totals.starved = 6;
  sink.set_totals(totals);
}

TEST(SinkTest, AForwardingSinkHandsAllOnToEach) {
  Told first;
  Told second;
  ForwardingSink both({&first, &second});
  tell_all(both);
  EXPECT_THAT(first.words, ElementsAre("run 1", "trigger 2", "slot 0", "steal 0", "overrun 3", "plan 0", "cost 4",
                                       "app 5", "clock 0", "notice 0", "totals 6"));
  EXPECT_EQ(second.words, first.words);
}

TEST(SinkTest, OneDerivedFromItMayLeaveOutSome) {
  class WithoutSteals : public ForwardingSink {
   public:
    using ForwardingSink::add;
    using ForwardingSink::ForwardingSink;
    void add(const Steal& /*steal*/) override {}
  };
  Told told;
  WithoutSteals some({&told});
  tell_all(some);
  EXPECT_THAT(told.words, ElementsAre("run 1", "trigger 2", "slot 0", "overrun 3", "plan 0", "cost 4", "app 5",
                                      "clock 0", "notice 0", "totals 6"));
}

}  // namespace
}  // namespace ctn::record
