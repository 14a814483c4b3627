#include "ros1/noting_helper.h"

#include <gtest/gtest.h>
#include <ros/message_deserializer.h>
#include <ros/serialization.h>
#include <std_msgs/Int64.h>

#include <boost/make_shared.hpp>

namespace catan_ros {
namespace {

using Helper = ros::SubscriptionCallbackHelperT<const std_msgs::Int64::ConstPtr&>;

class NotingHelperTest : public testing::Test {
 protected:
  KeptMessages::Topic topic{"/topic"};

  boost::shared_ptr<NotingHelper> subscription() {
    return boost::make_shared<NotingHelper>(boost::make_shared<Helper>([](const std_msgs::Int64::ConstPtr&) {}), topic);
  }

  // A message that has come, which roscpp makes once for all subscriptions of a program.
  static ros::MessageDeserializer received(const ros::SubscriptionCallbackHelperPtr& helper) {
    std_msgs::Int64 message;
    message.data = 42;
    return {helper, ros::serialization::serializeMessage(message), boost::make_shared<ros::M_string>()};
  }
};

TEST_F(NotingHelperTest, WhatIsLetGoOfIsNotMade) {
  const auto only = subscription();
  ros::MessageDeserializer message = received(only);
  const BoundCallback::Discard discard;
  EXPECT_EQ(message.deserialize(), nullptr);
}

TEST_F(NotingHelperTest, WhatOneSubscriptionLetsGoOfReachesTheOthers) {
  const auto bound = subscription();
  const auto other = subscription();
  ros::MessageDeserializer message = received(bound);
  {
    const BoundCallback::Discard discard;
    message.deserialize();
  }
  const auto made = boost::static_pointer_cast<const std_msgs::Int64>(message.deserialize());
  ASSERT_NE(made, nullptr);
  EXPECT_EQ(made->data, 42);
}

TEST_F(NotingHelperTest, AnotherThatOnlyCountsIsReachedToo) {
  const auto bound = subscription();
  int called = 0;
  CountedHelper other(boost::make_shared<Helper>([&](const std_msgs::Int64::ConstPtr&) { ++called; }), topic);
  EXPECT_EQ(topic.subscriptions(), 2);
  const BoundCallback::Discard discard;
  const ros::VoidConstPtr made = received(bound).deserialize();
  ASSERT_NE(made, nullptr);
  ros::SubscriptionCallbackHelperCallParams params;
  params.event = ros::MessageEvent<void const>(made, boost::make_shared<ros::M_string>(), ros::Time(), true,
                                               ros::DefaultMessageCreator<std_msgs::Int64>());
  other.call(params);
  EXPECT_EQ(called, 1);
}

TEST_F(NotingHelperTest, AnotherThatIsGoneDoesNotCount) {
  const auto only = subscription();
  subscription().reset();
  ros::MessageDeserializer message = received(only);
  const BoundCallback::Discard discard;
  EXPECT_EQ(message.deserialize(), nullptr);
}

}  // namespace
}  // namespace catan_ros
