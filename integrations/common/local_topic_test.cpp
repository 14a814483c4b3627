// A driver's loop, a callback and what it gives: the lineage of messages that nobody copies.
#include "common/local_topic.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "common/local_loop.h"
#include "common/testing/played_runs.h"

namespace catan_ros {
namespace {

Binding binding_of(const std::string& node, const std::string& topic, std::vector<std::string> predecessors) {
  Binding binding;
  binding.node = node;
  binding.name = topic;
  binding.kind = topic.empty() ? Binding::Kind::kLoop : Binding::Kind::kTopic;
  binding.predecessors = std::move(predecessors);
  return binding;
}

void put(LocalTopic& topic) {
  const auto message = std::make_shared<const int>(1);
  topic.publishing(message.get());
  topic.published(message);
}

TEST(LocalTopic, GivesACallbackWhatARunHasPublished) {
  const auto runs = MessageRuns::make();
  Play driver_play;
  Play callback_play;
  LocalTopic imu("imu");
  LocalTopic pose("pose");
  Binding binding = binding_of("imu", "", {});
  binding.runs_by_itself = true;
  binding.output_topics = {"imu"};
  LocalLoop driver(binding, *runs, [&] { return std::make_unique<PlayedRuns>(driver_play, false); });
  LocalCallback callback(
      binding_of("pose", "imu", {"imu"}), *runs,
      [&](const std::atomic<bool>&) { return std::make_unique<PlayedRuns>(callback_play); },
      [&](const LocalCallback::Message&) { put(pose); });
  imu.add(callback);
  callback.start();
  callback_play.trigger();
  callback_play.wait_for_ends(1);  // without a message; now it is registered
  for (int round = 0; round < 2; ++round) {
    ASSERT_TRUE(driver.wait());
    driver.begin();
    put(imu);
    driver.end();
    callback_play.trigger();
    callback_play.wait_for_ends(round + 2);
  }
  callback_play.finish();
  callback.stop();
  EXPECT_EQ(driver_play.text(), "1 with output; 2 with output; ");
  EXPECT_EQ(callback_play.text(), "1 without; 2 took imu:1 with output; 3 took imu:2 with output; ");
}

TEST(LocalTopic, WhatHasLeftTheProgramIsOutputToo) {
  const auto runs = MessageRuns::make();
  Play play;
  LocalTopic pose("pose");
  LocalLoop loop(binding_of("send", "", {}), *runs, [&] { return std::make_unique<PlayedRuns>(play); });
  play.trigger();
  ASSERT_TRUE(loop.wait());
  loop.begin();
  pose.publishing(&pose);
  pose.published(nullptr);
  loop.end();
  EXPECT_EQ(play.text(), "1 with output; ");
}

}  // namespace
}  // namespace catan_ros
