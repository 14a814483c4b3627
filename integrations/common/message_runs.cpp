#include "common/message_runs.h"

#include <algorithm>
#include <limits>

#include "common/hash.h"

namespace catan_ros {
namespace {

constexpr std::size_t kEndBytes = 256;  // of a message, at either end

}  // namespace

std::unique_ptr<MessageRuns> MessageRuns::open(const std::string& path) {
  auto file = SharedFile<Tables>::open(path);
  return file ? std::unique_ptr<MessageRuns>(new MessageRuns(std::move(file))) : nullptr;
}

std::unique_ptr<MessageRuns> MessageRuns::make() { return open({}); }

MessageRuns::Key MessageRuns::key_of(std::string_view topic, std::span<const std::byte> message) {
  const Key key =
      add_to_hash(add_to_hash(hash_of(topic), message.size()), message.first(std::min(message.size(), kEndBytes)));
  if (message.size() <= kEndBytes) return key;
  return add_to_hash(key, message.last(std::min(message.size() - kEndBytes, kEndBytes)));
}

MessageRuns::Key MessageRuns::key_of_address(std::string_view topic, const void* message) {
  return key_of(topic, std::as_bytes(std::span(&message, 1)));
}

// In place of the same message, of none, or of that of the oldest run. A later run than this one is of a server that
// was there before, since which runs are counted from 1 again: so older still.
void MessageRuns::note(std::string_view name, Key key, std::uint64_t run) {
  Node* const node = find_entry(file_->content().nodes, hash_of(name), true);
  if (node == nullptr) return;
  std::array<Message, kMessagesOfASet>& set = node->sets[key % kSets];
  Message* place = set.data();
  std::uint64_t oldest = std::numeric_limits<std::uint64_t>::max();
  for (Message& message : set) {
    if (message.key.load(std::memory_order_acquire) == key) {
      place = &message;
      break;
    }
    const std::uint64_t noted = message.run.load(std::memory_order_acquire);
    const std::uint64_t age = noted > run ? 0 : noted;
    if (age >= oldest) continue;
    oldest = age;
    place = &message;
  }
  place->key.store(0, std::memory_order_release);
  place->run.store(run, std::memory_order_release);
  place->key.store(key, std::memory_order_release);
}

std::uint64_t MessageRuns::find(std::string_view name, Key key) const {
  const Node* const node = find_entry(file_->content().nodes, hash_of(name), false);
  if (node == nullptr) return 0;
  std::uint64_t newest = 0;
  for (const Message& message : node->sets[key % kSets]) {
    if (message.key.load(std::memory_order_acquire) != key) continue;
    const std::uint64_t run = message.run.load(std::memory_order_acquire);
    // Another message may have taken its place meanwhile.
    if (message.key.load(std::memory_order_acquire) == key) newest = std::max(newest, run);
  }
  return newest;
}

void MessageRuns::note_time(std::string_view node, std::string_view topic, Time time) {
  Sender* const sender = find_entry(file_->content().senders, hash_of(node, topic), true);
  if (sender != nullptr) sender->time.store(time.time_since_epoch().count(), std::memory_order_release);
}

std::optional<MessageRuns::Time> MessageRuns::last_time(std::string_view node, std::string_view topic) const {
  const Sender* const sender = find_entry(file_->content().senders, hash_of(node, topic), false);
  const std::int64_t time = sender != nullptr ? sender->time.load(std::memory_order_acquire) : 0;
  return time != 0 ? std::optional(Time(Time::duration(time))) : std::nullopt;
}

void MessageRuns::note_subscription(std::string_view node, std::string_view topic) {
  find_entry(file_->content().subscriptions, hash_of(node, topic), true);
}

bool MessageRuns::subscribes(std::string_view node, std::string_view topic) const {
  return find_entry(file_->content().subscriptions, hash_of(node, topic), false) != nullptr;
}

}  // namespace catan_ros
