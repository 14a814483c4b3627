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

// The same message. When the program lets go of it in a run, it has been used there, or is of no use any more.
ros::VoidConstPtr with_note_of_release(const ros::VoidConstPtr& message, MessageRuns::Key key) {
  return {message.get(), [message, key](const void*) {
            if (BoundNode* const node = BoundNode::current()) node->note_let_go(key);
          }};
}

}  // namespace

PublishedKeys keys_of(const std::string& topic, const ros::SerializedMessage& message) {
  const std::size_t before = static_cast<std::size_t>(message.message_start - message.buf.get());
  const auto bytes = bytes_of(message.message_start, message.num_bytes - before);
  return {MessageRuns::key_of(topic, bytes),
          MessageRuns::key_of(topic, bytes.subspan(std::min(kSequence, bytes.size())))};
}

// roscpp makes a message once for all subscriptions of a program: what one lets go of, another may be waiting for.
bool BoundHelper::is_for_nobody() { return BoundCallback::discarding() && topic().subscriptions() == 1; }

ros::VoidConstPtr BoundHelper::deserialize(const ros::SubscriptionCallbackHelperDeserializeParams& params) {
  return is_for_nobody() ? ros::VoidConstPtr() : CountedHelper::deserialize(params);
}

void BoundHelper::call(ros::SubscriptionCallbackHelperCallParams& params) {
  if (BoundCallback::discarding()) return;
  if (BoundNode* const node = BoundNode::current()) node->note_message();
  CountedHelper::call(params);
}

ros::VoidConstPtr NotingHelper::deserialize(const ros::SubscriptionCallbackHelperDeserializeParams& params) {
  ros::VoidConstPtr message = BoundHelper::deserialize(params);
  if (message == nullptr) return {};
  const auto bytes = bytes_of(params.buffer, params.length);
  const std::size_t left_out = hasHeader() ? std::min(kSequence, bytes.size()) : 0;
  topic().note_made(message.get(), MessageRuns::key_of(topic().name(), bytes.subspan(left_out)));
  return message;
}

void NotingHelper::call(ros::SubscriptionCallbackHelperCallParams& params) {
  if (BoundCallback::discarding()) return;
  const ros::VoidConstPtr message = params.event.getConstMessage();
  const MessageRuns::Key made = topic().find(message.get());
  const MessageRuns::Key key = made != 0 ? made : MessageRuns::key_of_address(topic().name(), message.get());
  topic().keep(key);
  if (BoundNode* const node = BoundNode::current()) node->note_taken(key);
  ros::SubscriptionCallbackHelperCallParams told;
  told.event = ros::MessageEvent<void const>(with_note_of_release(message, key), params.event.getConnectionHeaderPtr(),
                                             params.event.getReceiptTime(), params.event.nonConstWillCopy(),
                                             params.event.getMessageFactory());
  BoundHelper::call(told);
}

}  // namespace catan_ros
