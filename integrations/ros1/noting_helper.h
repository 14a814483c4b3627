// The callback of a bound subscription, which notes which run of which node each of its messages is of
// (message_runs.h). In all else it is the program's own.
//
// Thread safety: as roscpp calls it; call() by the node's thread.
#pragma once

#include <ros/subscription_callback_helper.h>

#include <array>
#include <cstddef>
#include <mutex>
#include <string>
#include <utility>

#include "common/message_runs.h"
#include "ros1/bound_node.h"

namespace catan_ros {

class NotingHelper final : public ros::SubscriptionCallbackHelper {
 public:
  NotingHelper(ros::SubscriptionCallbackHelperPtr inner, std::string topic)
      : inner_(std::move(inner)), topic_(std::move(topic)) {}

  ros::VoidConstPtr deserialize(const ros::SubscriptionCallbackHelperDeserializeParams& params) override;
  void call(ros::SubscriptionCallbackHelperCallParams& params) override;
  const std::type_info& getTypeInfo() override { return inner_->getTypeInfo(); }
  bool isConst() override { return inner_->isConst(); }
  bool hasHeader() override { return inner_->hasHeader(); }

 private:
  // Of messages that came over a connection, from when they are made to when they are handled.
  struct Known {
    const void* message = nullptr;
    MessageRuns::Key key = 0;
  };
  static constexpr std::size_t kKnown = 16;

  MessageRuns::Key key_of(const void* message);

  ros::SubscriptionCallbackHelperPtr inner_;
  const std::string topic_;
  std::mutex mutex_;
  std::array<Known, kKnown> known_{};
  std::size_t next_ = 0;
};

// The keys of a message that is published: with the sequence number of its header, if it has one, which only roscpp
// knows, and without.
struct PublishedKeys {
  MessageRuns::Key whole = 0;
  MessageRuns::Key without_sequence = 0;
};
PublishedKeys keys_of(const std::string& topic, const ros::SerializedMessage& message);
// Of one that goes to a subscription in the same program as it is.
MessageRuns::Key key_of_address(const std::string& topic, const void* message);

}  // namespace catan_ros
