#include "common/executor_callback.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <deque>
#include <exception>
#include <future>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <utility>
#include <vector>

#include "common/testing/played_runs.h"
#include "common/thrown.h"

namespace catan_ros {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;

Binding detector(bool takes_all = false) {
  Binding binding;
  binding.node = "detect";
  binding.ros_node = "/detector";
  binding.name = "/image";
  binding.takes_all = takes_all;
  binding.predecessors = {"camera"};
  binding.output_topics = {"/people"};
  return binding;
}

class ExecutorCallbackTest : public testing::Test {
 protected:
  // It is registered, and has the messages of `history`, as a subscription of the middleware has.
  std::unique_ptr<ExecutorCallback> started(const Binding& binding) {
    auto made = std::make_unique<ExecutorCallback>(
        binding, *times,
        [this](const std::atomic<bool>&, const std::function<void()>&) { return std::make_unique<PlayedRuns>(play); });
    made->connect(
        {[this] { return next(); }, {}, &exclusion, [this](std::exception_ptr one) { thrown.put(std::move(one)); }});
    made->start();
    EXPECT_TRUE(made->bound());
    return made;
  }
  void arrive(int value, std::int64_t sent = 0) {
    const std::lock_guard lock(mutex);
    history.push_back({sent, [this, value] {
                         called.push_back(value);
                         return true;
                       }});
  }
  std::optional<ExecutorCallback::Call> next() {
    const std::lock_guard lock(mutex);
    if (history.empty()) return std::nullopt;
    std::optional<ExecutorCallback::Call> first = std::move(history.front());
    history.pop_front();
    return first;
  }
  void run_once(int ends) {
    play.trigger();
    play.wait_for_ends(ends);
  }
  void end(ExecutorCallback& callback) {
    play.finish();
    callback.stop();
  }

  std::unique_ptr<RunTimes> times = RunTimes::open({});
  Play play;
  PriorityMutex exclusion;
  std::mutex mutex;
  std::deque<ExecutorCallback::Call> history;
  std::vector<int> called;
  ThrownExceptions thrown;
};

// As without Catan, where the executor calls it; the node goes on, and publishes what it had before.
TEST_F(ExecutorCallbackTest, WhatACallbackThrowsComesOutOfTheExecutorOnce) {
  const auto callback = started(detector());
  history.push_back({0, []() -> bool {
                       BoundCallback::current()->note_output();
                       throw std::range_error("of the callback");
                     }});
  run_once(1);
  arrive(2);
  run_once(2);
  end(*callback);
  EXPECT_THROW(thrown.throw_first(), std::range_error);
  EXPECT_NO_THROW(thrown.throw_first());
  EXPECT_THAT(called, ElementsAre(2));
  EXPECT_EQ(play.text(), "1 with output; 2 without; ");
}

TEST_F(ExecutorCallbackTest, SoDoesWhatIsThrownWhileItsSubchainIsLetGoOf) {
  const auto callback = started(detector());
  history.push_back({0, []() -> bool { throw std::range_error("of the callback"); }});
  callback->collect();
  play.let_go();
  EXPECT_THROW(thrown.throw_first(), std::range_error);
  end(*callback);
}

TEST_F(ExecutorCallbackTest, SoDoesWhatATimerThrows) {
  Binding binding = detector();
  binding.kind = Binding::Kind::kTimer;
  ExecutorCallback callback(binding, *times, [this](const std::atomic<bool>&, const std::function<void()>&) {
    return std::make_unique<PlayedRuns>(play);
  });
  callback.connect({{},
                    []() -> bool { throw std::range_error("of the timer"); },
                    &exclusion,
                    [this](std::exception_ptr one) { thrown.put(std::move(one)); }});
  callback.start();
  run_once(1);
  end(callback);
  EXPECT_THROW(thrown.throw_first(), std::range_error);
  EXPECT_TRUE(thrown.empty());
}

TEST_F(ExecutorCallbackTest, WhileItsSubchainIsLetGoOfTheExecutorCalls) {
  const auto callback = started(detector());
  run_once(1);
  arrive(1);
  callback->collect();
  play.let_go();
  EXPECT_FALSE(callback->bound());
  EXPECT_THAT(called, ElementsAre(1)) << "nobody else has it any more";
  arrive(2);
  callback->collect();
  EXPECT_EQ(history.size(), 1U) << "it is the executor's";
  EXPECT_FALSE(callback->offer({}));
  play.complete();
  run_once(2);
  EXPECT_TRUE(callback->bound());
  arrive(3);
  EXPECT_TRUE(callback->offer(*next()));
  run_once(3);
  end(*callback);
  EXPECT_THAT(called, ElementsAre(1, 2, 3));
  EXPECT_EQ(play.text(), "1 without; 2 without; 3 without; ");
}

// Who asked waits for the answer.
TEST_F(ExecutorCallbackTest, ARunOfAServiceAnswersAllRequests) {
  Binding binding = detector();
  binding.kind = Binding::Kind::kService;
  const auto callback = started(binding);
  for (const int value : {1, 2}) arrive(value);
  run_once(1);
  end(*callback);
  EXPECT_THAT(called, ElementsAre(1, 2));
  EXPECT_EQ(play.text(), "1 with output; ") << "the answers";
}

TEST_F(ExecutorCallbackTest, ATriggerTakesTheNewestThatIsThereWithoutTheExecutor) {
  const auto callback = started(detector());
  for (const int value : {1, 2, 3}) arrive(value);
  run_once(1);
  end(*callback);
  EXPECT_THAT(called, ElementsAre(3));
}

TEST_F(ExecutorCallbackTest, OrAllInOrder) {
  const auto callback = started(detector(true));
  arrive(1);
  callback->collect();
  arrive(2);
  run_once(1);
  end(*callback);
  EXPECT_THAT(called, ElementsAre(1, 2));
}

TEST_F(ExecutorCallbackTest, ATriggerThatIsEarlyWaitsForTheExecutor) {
  const auto callback = started(detector());
  play.trigger();
  std::this_thread::sleep_for(5ms);
  arrive(7);
  callback->collect();
  play.wait_for_ends(1);
  end(*callback);
  EXPECT_THAT(called, ElementsAre(7));
}

TEST_F(ExecutorCallbackTest, WithoutATriggerNothingIsCalled) {
  const auto callback = started(detector());
  arrive(1);
  callback->collect();
  std::this_thread::sleep_for(5ms);
  EXPECT_THAT(called, ElementsAre());
  run_once(1);
  end(*callback);
  EXPECT_THAT(called, ElementsAre(1));
}

TEST_F(ExecutorCallbackTest, AMessageIsTheOutputOfTheRunWithinWhichItWasSent) {
  times->begin("camera", 4, 1000);
  times->end("camera", 2000);
  const auto callback = started(detector());
  arrive(1, 1500);
  run_once(1);
  arrive(2, 2500);  // between two runs
  run_once(2);
  end(*callback);
  EXPECT_EQ(play.text(), "1 took camera:4 without; 2 had camera:4 without; ")
      << "a run without output keeps what it took for the next one";
}

TEST_F(ExecutorCallbackTest, OnlyItsOwnTopicsAreOutput) {
  const auto callback = started(detector());
  for (const char* const topic : {"/debug", "/people"}) {
    const std::lock_guard lock(mutex);
    history.push_back({0, [topic] {
                         LocalNode::current()->note_published(topic);
                         return true;
                       }});
  }
  const auto one = next();
  const auto other = next();
  history.push_back(*one);
  run_once(1);
  history.push_back(*other);
  run_once(2);
  end(*callback);
  EXPECT_EQ(play.text(), "1 without; 2 with output; ");
  EXPECT_EQ(LocalNode::current(), nullptr);
}

TEST_F(ExecutorCallbackTest, CallbacksOfItsGroupDoNotOverlap) {
  const auto callback = started(detector());
  arrive(1);
  exclusion.lock();  // another callback of the group runs
  play.trigger();
  std::this_thread::sleep_for(20ms);
  EXPECT_THAT(called, ElementsAre());
  exclusion.unlock();
  play.wait_for_ends(1);
  ASSERT_TRUE(exclusion.try_lock_for(5s)) << "waiting for a trigger holds nothing";
  exclusion.unlock();
  end(*callback);
  EXPECT_THAT(called, ElementsAre(1));
}

TEST_F(ExecutorCallbackTest, StopDoesNotWaitForAGroupThatIsBusy) {
  const auto callback = started(detector());
  arrive(1);
  exclusion.lock();
  play.trigger();
  std::this_thread::sleep_for(5ms);
  end(*callback);
  exclusion.unlock();
  EXPECT_THAT(called, ElementsAre());
}

TEST_F(ExecutorCallbackTest, ATimerIsCalledWhenItIsTriggered) {
  Binding binding = detector();
  binding.kind = Binding::Kind::kTimer;
  ExecutorCallback callback(binding, *times, [this](const std::atomic<bool>&, const std::function<void()>&) {
    return std::make_unique<PlayedRuns>(play);
  });
  bool cancelled = false;
  callback.connect({{},
                    [&] {
                      if (!cancelled) called.push_back(1);
                      return !cancelled;
                    },
                    nullptr});
  callback.set_always_gives_output();
  callback.start();
  run_once(1);
  cancelled = true;
  run_once(2);
  end(callback);
  EXPECT_THAT(called, ElementsAre(1));
  EXPECT_EQ(play.text(), "1 with output; 2 without; ");
}

TEST_F(ExecutorCallbackTest, AnotherObjectOfTheProgramTakesItsPlace) {
  const auto callback = started(detector());
  arrive(1);
  callback->connect({[]() -> std::optional<ExecutorCallback::Call> { return std::nullopt; }, {}, &exclusion});
  callback->offer({0, [] { return false; }});  // of the one that is gone
  run_once(1);
  callback->connect({[this] { return next(); }, {}, nullptr});
  run_once(2);
  end(*callback);
  EXPECT_THAT(called, ElementsAre(1));
  EXPECT_EQ(play.text(), "1 without; 2 without; ");
}

TEST_F(ExecutorCallbackTest, WithoutAServerTheExecutorCalls) {
  ExecutorCallback callback(
      detector(), *times,
      [](const std::atomic<bool>& stop, const std::function<void()>& settled) -> std::unique_ptr<Runs> {
        settled();
        while (!stop.load()) std::this_thread::sleep_for(1ms);
        return nullptr;
      });
  const auto before = std::chrono::steady_clock::now();
  callback.start();
  EXPECT_LT(std::chrono::steady_clock::now() - before, 900ms) << "it is known that there will be none soon";
  EXPECT_FALSE(callback.bound());
  callback.stop();
}

TEST_F(ExecutorCallbackTest, ARunThatIsUnderWayReturnsBeforeStop) {
  const auto callback = started(detector());
  std::promise<void> begun;
  bool returned = false;
  callback->offer({0, [&] {
                     begun.set_value();
                     std::this_thread::sleep_for(20ms);
                     returned = true;
                     return true;
                   }});
  play.trigger();
  begun.get_future().wait();
  end(*callback);
  EXPECT_TRUE(returned);
  EXPECT_FALSE(callback->bound());
  EXPECT_EQ(play.text(), "1 without; ");
}

}  // namespace
}  // namespace catan_ros
