#include "common/local_callback.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <future>
#include <memory>
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
