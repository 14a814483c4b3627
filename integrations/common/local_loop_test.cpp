#include "common/local_loop.h"

#include <gtest/gtest.h>

#include <memory>

#include "common/local_topic.h"
#include "common/testing/played_runs.h"

namespace catan_ros {
namespace {

Binding loop_binding() {
  Binding binding;
  binding.node = "show";
  binding.ros_node = "timewarp";
  binding.kind = Binding::Kind::kLoop;
  binding.predecessors = {"render"};
  return binding;
}

class LocalLoopTest : public testing::Test {
 protected:
  LocalLoop loop_of(const Binding& binding) {
    return {binding, *runs,
            [this, waits = !binding.runs_by_itself] { return std::make_unique<PlayedRuns>(play, waits); }};
  }
  void publish(LocalTopic& topic) {
    const auto message = std::make_shared<const int>(1);
    topic.publishing(message.get());
    topic.published(message);
  }

  std::unique_ptr<MessageRuns> runs = MessageRuns::make();
  Play play;
};

TEST_F(LocalLoopTest, ARoundIsARunWithOutputIfItPublishes) {
  LocalTopic topic("image");
  LocalLoop loop = loop_of(loop_binding());
  play.trigger(2);
  play.finish();
  for (int round = 0; loop.wait(); ++round) {
    loop.begin();
    EXPECT_EQ(LocalNode::current(), &loop);
    if (round == 0) publish(topic);
    loop.end();
    EXPECT_EQ(LocalNode::current(), nullptr);
  }
  EXPECT_EQ(play.text(), "1 with output; 2 without; ");
}

TEST_F(LocalLoopTest, OnlyWhatSuccessorsTakeIsOutput) {
  LocalTopic log("log");
  Binding binding = loop_binding();
  binding.output_topics = {"image"};
  LocalLoop loop = loop_of(binding);
  play.trigger();
  ASSERT_TRUE(loop.wait());
  loop.begin();
  publish(log);
  loop.end();
  EXPECT_EQ(play.text(), "1 without; ");
}

TEST_F(LocalLoopTest, TheLastOfTheAppAlwaysGivesOutput) {
  Binding binding = loop_binding();
  binding.always_gives_output = true;
  LocalLoop loop = loop_of(binding);
  play.trigger(2);
  ASSERT_TRUE(loop.wait());
  loop.begin();
  loop.end();
  ASSERT_TRUE(loop.wait());
  loop.skip();
  EXPECT_EQ(play.text(), "1 with output; 2 without; ") << "but not where there was nothing to do";
}

TEST_F(LocalLoopTest, ADriverHasDoneItsRunWhenItHasPublished) {
  LocalTopic left("left");
  LocalTopic right("right");
  Binding binding = loop_binding();
  binding.runs_by_itself = true;
  binding.output_topics = {"left", "right"};
  LocalLoop loop = loop_of(binding);
  ASSERT_TRUE(loop.wait());
  loop.skip();  // it is not time yet
  loop.begin();
  publish(left);
  EXPECT_EQ(play.text(), "");
  publish(right);
  EXPECT_EQ(play.text(), "1 with output; ");
  publish(right);
  loop.end();
  EXPECT_EQ(play.text(), "1 with output; ");
}

TEST_F(LocalLoopTest, WhatIsReadWasSentByARun) {
  LocalTopic topic("frame");
  Binding binding = loop_binding();
  binding.node = "render";
  LocalLoop render = loop_of(binding);
  LocalLoop show = loop_of(loop_binding());
  play.trigger(2);
  const auto message = std::make_shared<const int>(1);
  ASSERT_TRUE(render.wait());
  render.begin();
  topic.publishing(message.get());
  topic.published(message);
  render.end();
  ASSERT_TRUE(show.wait());
  show.begin();
  topic.taken(message.get());
  topic.taken(&topic);  // nobody's
  show.end();
  EXPECT_EQ(play.text(), "1 with output; 1 took render:1 without; ");
}

TEST_F(LocalLoopTest, WhatARunWithoutOutputHasTakenIsKeptForTheNext) {
  LocalTopic frame("frame");
  LocalTopic image("image");
  const auto message = std::make_shared<const int>(1);
  runs->note("render", MessageRuns::key_of_address("frame", message.get()), 7);
  LocalLoop show = loop_of(loop_binding());
  play.trigger(3);
  for (int round = 0; round < 3; ++round) {
    ASSERT_TRUE(show.wait());
    show.begin();
    if (round == 0) frame.taken(message.get());
    if (round == 1) publish(image);
    show.end();
  }
  EXPECT_EQ(play.text(), "1 took render:7 without; 2 had render:7 with output; 3 without; ");
}

TEST_F(LocalLoopTest, GoesRoundWithoutTriggersWhileItsSubchainIsLetGoOf) {
  LocalTopic topic("image");
  LocalLoop loop = loop_of(loop_binding());
  play.is_incomplete();
  for (int round = 0; round < 3; ++round) {
    ASSERT_TRUE(loop.wait());
    loop.begin();
    EXPECT_EQ(LocalNode::current(), nullptr);
    publish(topic);
    loop.end();
    loop.skip();
  }
  EXPECT_EQ(play.text(), "");
  play.complete();
  play.trigger();
  play.finish();
  ASSERT_TRUE(loop.wait());
  loop.begin();
  publish(topic);
  loop.end();
  EXPECT_FALSE(loop.wait());
  EXPECT_EQ(play.text(), "1 with output; ");
}

TEST_F(LocalLoopTest, GoesRoundWithoutAServerAndBecomesANodeLater) {
  bool there = false;
  LocalLoop loop(loop_binding(), *runs,
                 [&]() -> std::unique_ptr<Runs> { return there ? std::make_unique<PlayedRuns>(play) : nullptr; });
  ASSERT_TRUE(loop.wait());
  loop.begin();
  EXPECT_EQ(LocalNode::current(), nullptr);
  loop.end();
  loop.skip();
  EXPECT_EQ(play.text(), "");
  there = true;
  play.trigger();
  play.finish();
  ASSERT_TRUE(loop.wait());
  loop.begin();
  loop.end();
  EXPECT_FALSE(loop.wait());
  EXPECT_EQ(play.text(), "1 without; ");
}

}  // namespace
}  // namespace catan_ros
