#include "ros1/noting_helper.h"

#include <algorithm>
#include <cstdint>
#include <span>

namespace catan_ros {
namespace {

constexpr std::size_t kSequence = sizeof(std::uint32_t);  // at the begin of a message that has a header

std::span<const std::byte> bytes_of(const std::uint8_t* begin, std::size_t size) {
  return std::as_bytes(std::span(begin, size));
}

}  // namespace

PublishedKeys keys_of(const std::string& topic, const ros::SerializedMessage& message) {
  const std::size_t before = static_cast<std::size_t>(message.message_start - message.buf.get());
  const auto bytes = bytes_of(message.message_start, message.num_bytes - before);
  return {MessageRuns::key_of(topic, bytes),
          MessageRuns::key_of(topic, bytes.subspan(std::min(kSequence, bytes.size())))};
}

MessageRuns::Key key_of_address(const std::string& topic, const void* message) {
  return MessageRuns::key_of(topic, std::as_bytes(std::span(&message, 1)));
}

ros::VoidConstPtr NotingHelper::deserialize(const ros::SubscriptionCallbackHelperDeserializeParams& params) {
  ros::VoidConstPtr message = inner_->deserialize(params);
  const auto bytes = bytes_of(params.buffer, params.length);
  const std::size_t left_out = inner_->hasHeader() ? std::min(kSequence, bytes.size()) : 0;
  topic_.note_made(message.get(), MessageRuns::key_of(topic_.name(), bytes.subspan(left_out)));
  return message;
}

void NotingHelper::call(ros::SubscriptionCallbackHelperCallParams& params) {
  const void* const message = params.event.getConstMessage().get();
  const MessageRuns::Key made = topic_.find(message);
  const MessageRuns::Key key = made != 0 ? made : key_of_address(topic_.name(), message);
  topic_.keep(key);
  if (BoundNode* const node = BoundNode::current()) node->note_taken(key);
  inner_->call(params);
}

}  // namespace catan_ros
