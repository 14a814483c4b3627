#include "common/local_callback.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <future>
#include <memory>
#include <thread>
#include <vector>

#include "common/testing/played_runs.h"

namespace catan_ros {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;

Binding callback_binding(bool takes_all) {
  Binding binding;
  binding.node = "pose";
  binding.ros_node = "integrator";
  binding.name = "imu";
  binding.takes_all = takes_all;
  return binding;
}

std::shared_ptr<const void> message(int value) { return std::make_shared<const int>(value); }

class LocalCallbackTest : public testing::Test {
 protected:
  // It is registered: its first run, for which there was no message, has ended.
  std::unique_ptr<LocalCallback> started(const Binding& binding) {
    auto made = std::make_unique<LocalCallback>(
        binding, *runs, [this](const std::atomic<bool>&) { return std::make_unique<PlayedRuns>(play); },
        [this](const LocalCallback::Message& one) { called.push_back(*static_cast<const int*>(one.get())); });
    made->start();
    play.trigger();
    play.wait_for_ends(1);
    return made;
  }
  // Both ways, in that order.
  static void publish(LocalCallback& callback, int value) {
    const auto one = message(value);
    callback.expect(one.get());
    callback.deliver(one);
    callback.arrived(one);
  }
  void end(LocalCallback& callback) {
    play.finish();
    callback.stop();
  }

  std::unique_ptr<MessageRuns> runs = MessageRuns::make();
  Play play;
  std::vector<int> called;
};

TEST_F(LocalCallbackTest, TheNewestIsTakenWhenTheTriggerComes) {
  const auto callback = started(callback_binding(false));
  for (const int value : {1, 2, 3}) publish(*callback, value);
  play.trigger();
  play.wait_for_ends(2);
  end(*callback);
  EXPECT_THAT(called, ElementsAre(3));
}

TEST_F(LocalCallbackTest, OrAllInOrder) {
  const auto callback = started(callback_binding(true));
  for (const int value : {1, 2, 3}) publish(*callback, value);
  play.trigger();
  play.wait_for_ends(2);
  end(*callback);
  EXPECT_THAT(called, ElementsAre(1, 2, 3));
}

TEST_F(LocalCallbackTest, AMessageIsCalledOnceWhicheverWayItComesFirst) {
  const auto callback = started(callback_binding(true));
  const auto one = message(1);
  callback->expect(one.get());
  callback->arrived(one);  // the framework's thread was faster
  callback->deliver(one);
  callback->arrived(message(2));  // nobody expected it: its publisher does not know of Catan
  callback->deliver(message(3));  // was published before anyone looked: the framework's thread brings it
  play.trigger();
  play.wait_for_ends(2);
  end(*callback);
  EXPECT_THAT(called, ElementsAre(1, 2));
}

TEST_F(LocalCallbackTest, WithoutAServerTheFrameworksThreadCalls) {
  LocalCallback callback(
      callback_binding(false), *runs,
      [](const std::atomic<bool>& stop) -> std::unique_ptr<Runs> {
        while (!stop.load()) std::this_thread::sleep_for(1ms);
        return nullptr;
      },
      [this](const LocalCallback::Message& one) { called.push_back(*static_cast<const int*>(one.get())); });
  callback.start();
  publish(callback, 1);
  EXPECT_THAT(called, ElementsAre(1));
  callback.stop();
  publish(callback, 2);
  EXPECT_THAT(called, ElementsAre(1)) << "not after it was stopped";
}

// Guards: the framework's thread brought it late, and it took the place of a newer one.
TEST_F(LocalCallbackTest, WhatIsOnItsWayWhenTheNodeIsRegisteredComesFirst) {
  for (const bool takes_all : {false, true}) {
    Play of_node;
    std::vector<int> taken;
    std::promise<void> registered;
    LocalCallback callback(
        callback_binding(takes_all), *runs,
        [&](const std::atomic<bool>&) {
          registered.get_future().wait();
          return std::make_unique<PlayedRuns>(of_node);
        },
        [&](const LocalCallback::Message& one) { taken.push_back(*static_cast<const int*>(one.get())); });
    callback.start();
    const auto early = message(1);
    callback.expect(early.get());
    callback.deliver(early);
    const auto brought = message(2);
    callback.expect(brought.get());
    callback.arrived(brought);  // by the framework's thread, which is not late with this one
    EXPECT_THAT(taken, ElementsAre(2));
    registered.set_value();
    of_node.trigger();
    of_node.wait_for_ends(1);
    callback.deliver(brought);
    publish(callback, 3);
    callback.arrived(early);
    of_node.trigger();
    of_node.wait_for_ends(2);
    of_node.finish();
    callback.stop();
    EXPECT_THAT(taken, ElementsAre(2, 1, 3)) << "takes all: " << takes_all;
  }
}

TEST_F(LocalCallbackTest, WhileItsSubchainIsLetGoOfTheFrameworksThreadCalls) {
  for (const bool takes_all : {false, true}) {
    SCOPED_TRACE(takes_all);
    Play of_node;
    std::vector<int> taken;
    LocalCallback callback(
        callback_binding(takes_all), *runs,
        [&](const std::atomic<bool>&) { return std::make_unique<PlayedRuns>(of_node); },
        [&](const LocalCallback::Message& one) { taken.push_back(*static_cast<const int*>(one.get())); });
    callback.start();
    of_node.trigger();
    of_node.wait_for_ends(1);
    const auto waiting = message(1);
    callback.expect(waiting.get());
    callback.deliver(waiting);  // the framework's thread is late with it
    const auto brought = message(2);
    callback.expect(brought.get());
    of_node.let_go();
    EXPECT_THAT(taken, ElementsAre(1));
    callback.arrived(waiting);
    callback.arrived(brought);
    callback.deliver(brought);
    EXPECT_THAT(taken, ElementsAre(1, 2)) << "each once";
    publish(callback, 3);
    EXPECT_THAT(taken, ElementsAre(1, 2, 3));

    const auto late = message(4);
    callback.expect(late.get());
    callback.deliver(late);
    of_node.complete();
    of_node.trigger();
    of_node.wait_for_ends(2);
    callback.arrived(late);
    EXPECT_THAT(taken, ElementsAre(1, 2, 3, 4)) << "by the node's run";
    publish(callback, 5);
    of_node.trigger();
    of_node.wait_for_ends(3);
    of_node.finish();
    callback.stop();
    EXPECT_THAT(taken, ElementsAre(1, 2, 3, 4, 5));
    EXPECT_EQ(of_node.text(), "1 without; 2 without; 3 without; ");
  }
}

// Else the two would overlap.
TEST_F(LocalCallbackTest, ACallOfTheFrameworksHasReturnedBeforeTheNextRun) {
  std::promise<void> begun;
  std::promise<void> goes_on;
  LocalCallback callback(
      callback_binding(true), *runs, [this](const std::atomic<bool>&) { return std::make_unique<PlayedRuns>(play); },
      [&](const LocalCallback::Message& one) {
        const int value = *static_cast<const int*>(one.get());
        if (value == 1) {
          begun.set_value();
          goes_on.get_future().wait();
        }
        called.push_back(value);
      });
  callback.start();
  play.trigger();
  play.wait_for_ends(1);
  play.let_go();
  std::thread framework([&] { callback.arrived(message(1)); });
  begun.get_future().wait();
  play.complete();
  play.trigger();
  std::thread([&] {
    std::this_thread::sleep_for(20ms);
    EXPECT_EQ(play.text(), "1 without; ");
    goes_on.set_value();
  }).join();
  framework.join();
  play.wait_for_ends(2);
  end(callback);
  EXPECT_THAT(called, ElementsAre(1));
}

TEST_F(LocalCallbackTest, ARunThatIsUnderWayReturnsBeforeStop) {
  std::promise<void> begun;
  bool returned = false;
  LocalCallback callback(
      callback_binding(false), *runs, [this](const std::atomic<bool>&) { return std::make_unique<PlayedRuns>(play); },
      [&](const LocalCallback::Message&) {
        begun.set_value();
        std::this_thread::sleep_for(20ms);
        returned = true;
      });
  callback.start();
  play.trigger();
  play.wait_for_ends(1);
  callback.arrived(message(1));
  play.trigger();
  begun.get_future().wait();
  end(callback);
  EXPECT_TRUE(returned);
  EXPECT_EQ(play.text(), "1 without; 2 without; ");
}

}  // namespace
}  // namespace catan_ros
