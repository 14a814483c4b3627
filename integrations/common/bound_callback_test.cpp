// A schedule that is played, and calls that write down what happens in which order.
#include "common/bound_callback.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace catan_ros {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;

using Log = std::vector<std::string>;

class PlayedSchedule final : public Schedule {
 public:
  PlayedSchedule(int triggers, Log& log) : triggers_(triggers), log_(log) {}
  std::function<void()> at_trigger = [] {};
  bool lets_go = false;  // of the subchain, before the first trigger

  ctn::Awaited await() override {
    if (std::exchange(lets_go, false)) return ctn::Awaited::kIncomplete;
    if (triggers_-- == 0) return ctn::Awaited::kStopped;
    at_trigger();
    return ctn::Awaited::kTrigger;
  }
  bool await_complete() override {
    log_.emplace_back("await complete");
    return true;
  }
  void begin() override { log_.emplace_back("begin"); }
  void end(bool output) override { log_.emplace_back(output ? "end with output" : "end"); }

 private:
  int triggers_;
  Log& log_;
};

class LoggedTurn final : public Turn {
 public:
  explicit LoggedTurn(Log& log) : log_(log) {}
  bool take(const std::atomic<bool>& stop) override {
    log_.emplace_back("take turn");
    return !stop.load();
  }
  void give_back() override { log_.emplace_back("give back"); }

 private:
  Log& log_;
};

class BoundCallbackTest : public testing::Test {
 protected:
  void play(
      const BoundCallbackOptions& options, int triggers, std::function<void()> at_trigger = [] {}) {
    BoundCallback callback(options, inbox, turn);
    if (without_message) callback.set_without_message(without_message);
    if (newest_sent) callback.set_newest_sent(newest_sent);
    PlayedSchedule schedule(triggers, log);
    schedule.at_trigger = std::move(at_trigger);
    callback.run(schedule);
  }
  void put(const std::string& name, bool output = true, Outcome outcome = Outcome::kCalled, Inbox::Id id = 0) {
    inbox.put({id, [this, name, output, outcome] {
                 log.push_back(name);
                 if (output) BoundCallback::current()->note_output();
                 return outcome;
               }});
  }

  Log log;
  Inbox inbox;
  LoggedTurn turn{log};
  std::function<bool()> without_message;
  std::function<std::optional<BoundCallback::Time>()> newest_sent;
};

TEST_F(BoundCallbackTest, OneMessageATrigger) {
  put("first");
  put("second");
  play({}, 2);
  EXPECT_THAT(log, ElementsAre("take turn", "begin", "first", "end with output", "give back",  //
                               "take turn", "begin", "second", "end with output", "give back"));
  EXPECT_EQ(BoundCallback::current(), nullptr);
}

TEST_F(BoundCallbackTest, NothingIsCalledBeforeTheTrigger) {
  put("message");
  play({}, 0);
  EXPECT_TRUE(log.empty());
  EXPECT_EQ(inbox.size(), 1U);
}

TEST_F(BoundCallbackTest, AQueueTakesAllThatHasCome) {
  put("first");
  put("second");
  play({.takes_all = true}, 1);
  EXPECT_THAT(log, ElementsAre("take turn", "begin", "first", "second", "end with output", "give back"));
}

// What is called then is not to reach the program.
TEST_F(BoundCallbackTest, WhereOnlyTheNewestCountsThoseBeforeItAreDiscarded) {
  for (const char* const name : {"first", "second", "third"}) {
    inbox.put({0, [this, name] {
                 log.push_back(BoundCallback::discarding() ? std::string("not ") + name : name);
                 return Outcome::kCalled;
               }});
  }
  play({.takes_newest = true}, 1);
  EXPECT_THAT(log, ElementsAre("take turn", "begin", "not first", "not second", "third", "end", "give back"));
  EXPECT_FALSE(BoundCallback::discarding());
}

// A trigger is quicker than the message of whose sender it comes. One that is left over would be taken in its place,
// and so on for ever, a period behind.
TEST_F(BoundCallbackTest, AMessageThatIsUnderWayIsWaitedForWhereAnOlderOneLiesThere) {
  put("older", false);
  const auto sent = std::chrono::steady_clock::now();
  newest_sent = [sent] { return sent; };
  std::thread network;
  play({.takes_newest = true, .newer_patience = 10s}, 1, [&] {
    network = std::thread([this] {
      std::this_thread::sleep_for(5ms);
      put("newer");
    });
  });
  network.join();
  EXPECT_THAT(log, ElementsAre("take turn", "begin", "older", "newer", "end with output", "give back"));
}

TEST_F(BoundCallbackTest, AMessageThatDoesNotComeIsWaitedForForAMoment) {
  put("older");
  newest_sent = [] { return std::chrono::steady_clock::now(); };
  play({.takes_newest = true, .newer_patience = 1ms}, 1);
  EXPECT_THAT(log, ElementsAre("take turn", "begin", "older", "end with output", "give back"));
}

// Else these would take as long as the test may.
TEST_F(BoundCallbackTest, NoneIsWaitedForThatHasComeOrThatTheRunDoesNotNeed) {
  const auto sent = std::chrono::steady_clock::now();
  newest_sent = [sent] { return sent; };
  put("newest");
  play({.takes_newest = true, .newer_patience = 1h}, 1);
  newest_sent = [] { return std::chrono::steady_clock::now() + 1h; };
  put("each");
  play({.takes_all = true, .newer_patience = 1h}, 1);
  newest_sent = [] { return std::optional<std::chrono::steady_clock::time_point>(); };
  put("of an unknown sender");
  play({.takes_newest = true, .newer_patience = 1h}, 1);
  EXPECT_EQ(log.size(), 15U);
}

TEST_F(BoundCallbackTest, ARunThatPublishesNothingGivesNoOutput) {
  put("quiet", false);
  play({}, 1);
  EXPECT_THAT(log, ElementsAre("take turn", "begin", "quiet", "end", "give back"));
}

TEST_F(BoundCallbackTest, AtTheEndOfAChainItDoes) {
  put("quiet", false);
  play({.always_gives_output = true}, 1);
  EXPECT_THAT(log, ElementsAre("take turn", "begin", "quiet", "end with output", "give back"));
}

TEST_F(BoundCallbackTest, WithoutAMessageTheRunIsEmpty) {
  play({.always_gives_output = true, .patience = 1ms}, 1);
  EXPECT_THAT(log, ElementsAre("begin", "end"));
}

// As of a program that has unsubscribed, since nobody listens to it. Else the test would take days.
TEST_F(BoundCallbackTest, WhereNothingCanComeTheRunIsEmptyAtOnce) {
  inbox.expect_calls(false);
  play({.takes_newest = true, .patience = 24h}, 2);
  EXPECT_THAT(log, ElementsAre("begin", "end", "begin", "end"));
}

TEST_F(BoundCallbackTest, ThatNothingCanComeAnyMoreEndsTheWaitForIt) {
  std::thread unsubscribing;
  play({.takes_newest = true, .patience = 24h}, 1,
       [&] { unsubscribing = std::thread([&] { inbox.expect_calls(false); }); });
  unsubscribing.join();
  EXPECT_THAT(log, ElementsAre("begin", "end"));
}

TEST_F(BoundCallbackTest, WhatComesAgainIsWaitedFor) {
  inbox.expect_calls(false);
  std::thread subscribing;
  play({.takes_newest = true, .patience = 24h}, 1, [&] {
    inbox.expect_calls(true);
    subscribing = std::thread([&] { put("late"); });
  });
  subscribing.join();
  EXPECT_THAT(log, ElementsAre("take turn", "begin", "late", "end with output", "give back"));
}

TEST_F(BoundCallbackTest, AMessageThatComesAfterItsTriggerIsTaken) {
  std::thread network;
  play({.patience = 1min}, 1, [&] { network = std::thread([&] { put("late"); }); });
  network.join();
  EXPECT_THAT(log, ElementsAre("take turn", "begin", "late", "end with output", "give back"));
}

TEST_F(BoundCallbackTest, ATriggerTakesThePlaceOfATimer) {
  without_message = [this] {
    log.emplace_back("timer");
    return true;
  };
  put("due");
  play({.always_gives_output = true}, 2);
  EXPECT_THAT(log, ElementsAre("take turn", "begin", "due", "end with output", "give back",  //
                               "take turn", "begin", "timer", "end with output", "give back"));
}

TEST_F(BoundCallbackTest, WhatIsGoneIsNotOutput) {
  put("gone", false, Outcome::kNothing);
  play({.always_gives_output = true}, 1);
  EXPECT_THAT(log, ElementsAre("take turn", "begin", "gone", "end", "give back"));
}

TEST_F(BoundCallbackTest, ACallbackThatAnotherThreadIsInIsCalledLater) {
  int calls = 0;
  inbox.put({0, [&] { return ++calls < 3 ? Outcome::kAgain : Outcome::kCalled; }});
  play({.always_gives_output = true}, 1);
  EXPECT_EQ(calls, 3);
  EXPECT_THAT(log, ElementsAre("take turn", "begin", "end with output", "give back"));
}

TEST_F(BoundCallbackTest, WhatWasRemovedIsNotCalled) {
  put("removed", true, Outcome::kCalled, 7);
  put("kept", true, Outcome::kCalled, 8);
  inbox.remove(7);
  play({}, 1);
  EXPECT_THAT(log, ElementsAre("take turn", "begin", "kept", "end with output", "give back"));
}

// Who removes it lets go of what it uses right afterwards.
TEST_F(BoundCallbackTest, RemovingWaitsForACallThatIsUnderWay) {
  std::atomic<bool> removed{false};
  bool removed_meanwhile = true;
  std::thread remover;
  const auto call = [&] {
    remover = std::thread([&] {
      inbox.remove(7);
      removed = true;
    });
    std::this_thread::sleep_for(30ms);
    removed_meanwhile = removed;
    return Outcome::kCalled;
  };
  inbox.put({7, call});
  play({}, 1);
  remover.join();
  EXPECT_FALSE(removed_meanwhile);

  without_message = [&] { return call() == Outcome::kCalled; };
  removed = false;
  play({}, 1);
  remover.join();
  EXPECT_FALSE(removed_meanwhile) << "a timer that a trigger calls";
}

// What the call needs, the remover may have got.
TEST_F(BoundCallbackTest, RemovingDoesNotWaitWhereTheCallMayGoOn) {
  const auto call = [&] {
    std::thread([&] { inbox.remove(7, Inbox::UnderWay::kGoesOn); }).join();
    return Outcome::kCalled;
  };
  inbox.put({7, call});
  put("next", true, Outcome::kCalled, 7);
  play({}, 1);
  EXPECT_EQ(inbox.size(), 0U);

  without_message = [&] { return call() == Outcome::kCalled; };
  play({.always_gives_output = true}, 1);
  EXPECT_THAT(log, testing::Contains("end with output")) << "a timer that a trigger calls";
}

TEST_F(BoundCallbackTest, RemovingAnotherOrItselfDoesNotWait) {
  inbox.put({7, [&] {
               std::thread([&] { inbox.remove(8); }).join();
               inbox.remove(7);
               return Outcome::kCalled;
             }});
  put("next", true, Outcome::kCalled, 7);
  put("kept", true, Outcome::kCalled, 8);
  play({}, 1);
  EXPECT_EQ(inbox.size(), 0U);
}

// The port hands what has come to the framework, or calls it as here; the next trigger is for a run again.
TEST_F(BoundCallbackTest, WhatTheServerHasLetGoOfIsCalledOutsideOfRuns) {
  BoundCallback callback({.takes_all = true}, inbox, turn);
  bool has_run = false;
  inbox.put({0, [&] {
               has_run = has_run || BoundCallback::current() != nullptr;
               log.emplace_back("before");
               return Outcome::kCalled;
             }});
  callback.set_let_go(
      [&] {
        log.emplace_back("let go");
        callback.call_rest();
      },
      [&] {
        log.emplace_back("take back");
        put("after");
      });
  PlayedSchedule schedule(1, log);
  schedule.lets_go = true;
  callback.run(schedule);
  EXPECT_THAT(log, ElementsAre("let go", "before", "await complete", "take back",  //
                               "take turn", "begin", "after", "end with output", "give back"));
  EXPECT_FALSE(has_run);
}

TEST_F(BoundCallbackTest, WhatComesAfterACallComesWhenTheTurnIsGivenBack) {
  BoundCallback callback({.patience = 0ms}, inbox, turn);
  callback.set_after_call([this] { log.emplace_back("after"); });
  put("message", false);
  PlayedSchedule schedule(2, log);
  callback.run(schedule);
  EXPECT_THAT(log, ElementsAre("take turn", "begin", "message", "end", "give back", "after",  //
                               "begin", "end"))
      << "not after a run that called nothing";
}

// Guards: they piled up to the size of the program's queue as long as no trigger came.
TEST_F(BoundCallbackTest, WhereOnlyTheNewestCountsItIsKeptUntilTheTrigger) {
  BoundCallback callback({.takes_newest = true}, inbox, turn);
  for (int message = 1; message <= 100; ++message) {
    inbox.put({0, [this, message] {
                 if (!BoundCallback::discarding()) log.push_back(std::to_string(message));
                 return Outcome::kCalled;
               }});
    callback.let_go_of_older();
    EXPECT_EQ(inbox.size(), 1U) << "nothing is left to let go of between the trigger and the call";
  }
  EXPECT_FALSE(BoundCallback::discarding());
  PlayedSchedule schedule(1, log);
  callback.run(schedule);
  EXPECT_THAT(log, ElementsAre("take turn", "begin", "100", "end", "give back"));
}

TEST_F(BoundCallbackTest, WhereAllCountNoneIsLetGoOf) {
  BoundCallback callback({.takes_all = true}, inbox, turn);
  for (const char* const name : {"first", "second", "third"}) {
    put(name, false);
    callback.let_go_of_older();
  }
  PlayedSchedule schedule(1, log);
  callback.run(schedule);
  EXPECT_THAT(log, ElementsAre("take turn", "begin", "first", "second", "third", "end", "give back"));
}

// Of a subscription the call takes the oldest message that is there: one that was made meanwhile would take that of the
// call under way.
TEST_F(BoundCallbackTest, NoneIsLetGoOfWhileACallIsUnderWayAndThoseThatCameMeanwhileAreNext) {
  BoundCallback callback({.takes_newest = true}, inbox, turn);
  inbox.put({0, [&] {
               std::thread([&] {
                 for (const char* const name : {"2", "3", "4"}) {
                   put(name, false);
                   callback.let_go_of_older();
                 }
               }).join();
               log.push_back("1 while " + std::to_string(inbox.size()) + " wait");
               return Outcome::kCalled;
             }});
  PlayedSchedule schedule(1, log);
  callback.run(schedule);
  EXPECT_THAT(log, ElementsAre("take turn", "begin", "1 while 3 wait", "end", "give back"));
  inbox.put({0, [this] {
               log.emplace_back("5");
               return Outcome::kCalled;
             }});
  log.clear();
  callback.let_go_of_older();
  EXPECT_EQ(inbox.size(), 1U);
}

// Runs take longer than the sender's period: a run that waited for the next message would be later still.
TEST_F(BoundCallbackTest, WhereSeveralHaveComeNoNewerOneIsWaitedForThoughTheyWereLetGoOf) {
  BoundCallback callback({.takes_newest = true, .newer_patience = 1h}, inbox, turn);
  callback.set_newest_sent([] { return std::chrono::steady_clock::now() + 1h; });
  for (const char* const name : {"first", "second"}) {
    put(name, false);
    callback.let_go_of_older();
  }
  PlayedSchedule schedule(1, log);
  log.clear();
  callback.run(schedule);
  EXPECT_THAT(log, ElementsAre("take turn", "begin", "second", "end", "give back"));
}

// What was let go of while a run waited has nothing to do with the next one.
TEST_F(BoundCallbackTest, TheNextRunWaitsForANewerMessageAgain) {
  BoundCallback callback({.takes_newest = true, .newer_patience = 10s}, inbox, turn);
  std::chrono::steady_clock::time_point sent;
  callback.set_newest_sent([&] { return sent; });
  std::thread network;
  PlayedSchedule schedule(2, log);
  schedule.at_trigger = [&] {
    if (network.joinable()) network.join();
    inbox.put({0, [] { return Outcome::kCalled; }});  // it is left over
    sent = std::chrono::steady_clock::now();
    network = std::thread([&] {
      std::this_thread::sleep_for(5ms);
      put("newer", false);
      callback.let_go_of_older();
    });
  };
  callback.run(schedule);
  network.join();
  EXPECT_THAT(log, ElementsAre("take turn", "begin", "newer", "end", "give back",  //
                               "take turn", "begin", "newer", "end", "give back"));
}

TEST_F(BoundCallbackTest, StoppingEndsTheWaitForAMessage) {
  std::thread other;
  play({.runs_by_itself = true}, 1, [&] { other = std::thread([&] { inbox.stop(); }); });
  other.join();
  EXPECT_TRUE(log.empty());
}

}  // namespace
}  // namespace catan_ros
