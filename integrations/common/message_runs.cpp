#include "common/message_runs.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>

namespace catan_ros {
namespace {

constexpr std::uint64_t kHashStart = 14695981039346656037ULL;
constexpr std::uint64_t kHashFactor = 1099511628211ULL;
constexpr std::size_t kEndBytes = 256;  // of a message, at either end

// The upper half is added to the lower one, since a product carries nothing down: else two changes of the highest bit,
// as of the signs of two numbers, would be none.
std::uint64_t add(std::uint64_t hash, std::uint64_t value) {
  const std::uint64_t product = (hash ^ value) * kHashFactor;
  return product ^ (product >> 32U);
}

// Eight at a time: it is done for each message that a program gets.
std::uint64_t add_bytes(std::uint64_t hash, std::span<const std::byte> bytes) {
  for (std::uint64_t word = 0; bytes.size() >= sizeof word; bytes = bytes.subspan(sizeof word)) {
    std::memcpy(&word, bytes.data(), sizeof word);
    hash = add(hash, word);
  }
  for (const std::byte byte : bytes) hash = add(hash, std::to_integer<std::uint64_t>(byte));
  return hash;
}

std::uint64_t hash_of(std::string_view text) {
  return std::max<std::uint64_t>(add_bytes(kHashStart, std::as_bytes(std::span(text.data(), text.size()))), 1);
}

std::uint64_t hash_of_both(std::string_view node, std::string_view topic) {
  return std::max<std::uint64_t>(add(hash_of(node), hash_of(topic)), 1);
}

// Whether the place has that hash; with `make`, a free one gets it.
bool is_entry(std::atomic<std::uint64_t>& place, std::uint64_t hash, bool make) {
  std::uint64_t there = place.load(std::memory_order_acquire);
  if (there == hash) return true;
  return there == 0 && make && (place.compare_exchange_strong(there, hash) || there == hash);
}

}  // namespace

std::unique_ptr<MessageRuns> MessageRuns::open(const std::string& path) {
  const int file = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600);
  if (file < 0) return nullptr;
  struct stat found {};
  const bool own = ::fstat(file, &found) == 0 && S_ISREG(found.st_mode) && found.st_uid == ::geteuid();
  const auto size = static_cast<off_t>(sizeof(Shared));
  const bool sized = own && (found.st_size == size || ::ftruncate(file, size) == 0);
  void* const memory =
      sized ? ::mmap(nullptr, sizeof(Shared), PROT_READ | PROT_WRITE, MAP_SHARED, file, 0) : MAP_FAILED;
  ::close(file);
  if (memory == MAP_FAILED) return nullptr;
  // All zero is what a new one is, and atomics of an old one go on.
  return std::unique_ptr<MessageRuns>(new MessageRuns(*static_cast<Shared*>(memory)));
}

std::unique_ptr<MessageRuns> MessageRuns::make() {
  void* const memory = ::mmap(nullptr, sizeof(Shared), PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) return nullptr;
  return std::unique_ptr<MessageRuns>(new MessageRuns(*static_cast<Shared*>(memory)));
}

MessageRuns::~MessageRuns() { ::munmap(&shared_, sizeof(Shared)); }

MessageRuns::Key MessageRuns::key_of(std::string_view topic, std::span<const std::byte> message) {
  std::uint64_t key = add(hash_of(topic), message.size());
  key = add_bytes(key, message.first(std::min(message.size(), kEndBytes)));
  if (message.size() > kEndBytes) {
    key = add_bytes(key, message.last(std::min(message.size() - kEndBytes, kEndBytes)));
  }
  return std::max<std::uint64_t>(key, 1);
}

MessageRuns::Key MessageRuns::key_of_address(std::string_view topic, const void* message) {
  return key_of(topic, std::as_bytes(std::span(&message, 1)));
}

MessageRuns::Node* MessageRuns::node_of(std::string_view name, bool make) const {
  const std::uint64_t hash = hash_of(name);
  for (std::size_t step = 0; step < kNodes; ++step) {
    Node& node = shared_.nodes[(hash + step) % kNodes];
    if (is_entry(node.name, hash, make)) return &node;
    if (node.name.load(std::memory_order_acquire) == 0) return nullptr;
  }
  return nullptr;
}

// In place of the same message, of none, or of that of the oldest run.
void MessageRuns::note(std::string_view name, Key key, std::uint64_t run) {
  Node* const node = node_of(name, true);
  if (node == nullptr) return;
  std::array<Message, kMessagesOfASet>& set = node->sets[key % kSets];
  Message* place = set.data();
  for (Message& message : set) {
    if (message.key.load(std::memory_order_acquire) == key) {
      place = &message;
      break;
    }
    if (message.run.load(std::memory_order_acquire) < place->run.load(std::memory_order_acquire)) place = &message;
  }
  place->key.store(0, std::memory_order_release);
  place->run.store(run, std::memory_order_release);
  place->key.store(key, std::memory_order_release);
}

std::uint64_t MessageRuns::find(std::string_view name, Key key) const {
  const Node* const node = node_of(name, false);
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

MessageRuns::Sender* MessageRuns::sender_of(std::string_view node, std::string_view topic, bool make) const {
  const std::uint64_t hash = hash_of_both(node, topic);
  for (std::size_t step = 0; step < kSenders; ++step) {
    Sender& sender = shared_.senders[(hash + step) % kSenders];
    if (is_entry(sender.hash, hash, make)) return &sender;
    if (sender.hash.load(std::memory_order_acquire) == 0) return nullptr;
  }
  return nullptr;
}

void MessageRuns::note_time(std::string_view node, std::string_view topic, Time time) {
  Sender* const sender = sender_of(node, topic, true);
  if (sender != nullptr) sender->time.store(time.time_since_epoch().count(), std::memory_order_release);
}

std::optional<MessageRuns::Time> MessageRuns::last_time(std::string_view node, std::string_view topic) const {
  const Sender* const sender = sender_of(node, topic, false);
  const std::int64_t time = sender != nullptr ? sender->time.load(std::memory_order_acquire) : 0;
  return time != 0 ? std::optional(Time(Time::duration(time))) : std::nullopt;
}

void MessageRuns::note_subscription(std::string_view node, std::string_view topic) {
  const std::uint64_t hash = hash_of_both(node, topic);
  for (std::size_t step = 0; step < kSubscriptions; ++step) {
    if (is_entry(shared_.subscriptions[(hash + step) % kSubscriptions], hash, true)) return;
  }
}

bool MessageRuns::subscribes(std::string_view node, std::string_view topic) const {
  const std::uint64_t hash = hash_of_both(node, topic);
  for (std::size_t step = 0; step < kSubscriptions; ++step) {
    std::atomic<std::uint64_t>& place = shared_.subscriptions[(hash + step) % kSubscriptions];
    if (is_entry(place, hash, false)) return true;
    if (place.load(std::memory_order_acquire) == 0) return false;
  }
  return false;
}

}  // namespace catan_ros
