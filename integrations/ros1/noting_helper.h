// The callbacks of subscriptions in a program that has bound ones: in all but what is said here they are the program's
// own.
//
// Thread safety: as roscpp calls it; call() by the node's thread, and by any where it lets go of the message.
#pragma once

#include <ros/subscription_callback_helper.h>

#include <string>
#include <utility>

#include "common/kept_messages.h"
#include "common/message_runs.h"
#include "ros1/bound_node.h"

namespace catan_ros {

// The callback of a subscription that notes nothing: it is counted, since a message of which a bound one lets go may be
// another's.
class CountedHelper : public ros::SubscriptionCallbackHelper {
 public:
  // `topic` outlives it.
  CountedHelper(ros::SubscriptionCallbackHelperPtr inner, KeptMessages::Topic& topic)
      : inner_(std::move(inner)), topic_(topic) {
    topic_.add_subscriptions(1);
  }
  ~CountedHelper() override { topic_.add_subscriptions(-1); }
  CountedHelper(const CountedHelper&) = delete;
  CountedHelper& operator=(const CountedHelper&) = delete;

  ros::VoidConstPtr deserialize(const ros::SubscriptionCallbackHelperDeserializeParams& params) override {
    return inner_->deserialize(params);
  }
  void call(ros::SubscriptionCallbackHelperCallParams& params) override { inner_->call(params); }
  const std::type_info& getTypeInfo() override { return inner_->getTypeInfo(); }
  bool isConst() override { return inner_->isConst(); }
  bool hasHeader() override { return inner_->hasHeader(); }

 protected:
  KeptMessages::Topic& topic() { return topic_; }

 private:
  ros::SubscriptionCallbackHelperPtr inner_;
  KeptMessages::Topic& topic_;
};

// That of a bound one: what its node lets go of does not reach the program.
class BoundHelper : public CountedHelper {
 public:
  using CountedHelper::CountedHelper;

  ros::VoidConstPtr deserialize(const ros::SubscriptionCallbackHelperDeserializeParams& params) override;
  void call(ros::SubscriptionCallbackHelperCallParams& params) override;

 protected:
  // Whether the message that is to be made now is let go of, and nobody else takes it.
  bool is_for_nobody();
};

// One that notes which run of which node each of its messages is of (message_runs.h), and that the program has got it
// (kept_messages.h): where a node of the program has predecessors.
class NotingHelper final : public BoundHelper {
 public:
  using BoundHelper::BoundHelper;

  ros::VoidConstPtr deserialize(const ros::SubscriptionCallbackHelperDeserializeParams& params) override;
  void call(ros::SubscriptionCallbackHelperCallParams& params) override;
};

// The keys of a message that is published: with the sequence number of its header, if it has one, which only roscpp
// knows, and without.
struct PublishedKeys {
  MessageRuns::Key whole = 0;
  MessageRuns::Key without_sequence = 0;
};
PublishedKeys keys_of(const std::string& topic, const ros::SerializedMessage& message);

}  // namespace catan_ros
