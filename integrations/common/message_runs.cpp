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

}  // namespace

std::unique_ptr<MessageRuns> MessageRuns::open(const std::string& path) {
  const int file = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600);
  if (file < 0) return nullptr;
  struct stat found {};
  const bool own = ::fstat(file, &found) == 0 && S_ISREG(found.st_mode) && found.st_uid == ::geteuid();
  const auto size = static_cast<off_t>(sizeof(Nodes));
  const bool sized = own && (found.st_size == size || ::ftruncate(file, size) == 0);
  void* const memory = sized ? ::mmap(nullptr, sizeof(Nodes), PROT_READ | PROT_WRITE, MAP_SHARED, file, 0) : MAP_FAILED;
  ::close(file);
  if (memory == MAP_FAILED) return nullptr;
  // All zero is what a new one is, and atomics of an old one go on.
  return std::unique_ptr<MessageRuns>(new MessageRuns(*static_cast<Nodes*>(memory)));
}

std::unique_ptr<MessageRuns> MessageRuns::make() {
  void* const memory = ::mmap(nullptr, sizeof(Nodes), PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) return nullptr;
  return std::unique_ptr<MessageRuns>(new MessageRuns(*static_cast<Nodes*>(memory)));
}

MessageRuns::~MessageRuns() { ::munmap(&nodes_, sizeof(Nodes)); }

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
    Node& node = nodes_[(hash + step) % kNodes];
    std::uint64_t there = node.name.load(std::memory_order_acquire);
    if (there == hash) return &node;
    if (there != 0) continue;
    if (!make) return nullptr;
    if (node.name.compare_exchange_strong(there, hash) || there == hash) return &node;
  }
  return nullptr;
}

void MessageRuns::note(std::string_view name, Key key, std::uint64_t run) {
  Node* const node = node_of(name, true);
  if (node == nullptr) return;
  Message& message = node->messages[node->noted.fetch_add(1) % kMessages];
  message.key.store(0, std::memory_order_release);
  message.run.store(run, std::memory_order_release);
  message.key.store(key, std::memory_order_release);
}

std::uint64_t MessageRuns::find(std::string_view name, Key key) const {
  const Node* const node = node_of(name, false);
  if (node == nullptr) return 0;
  std::uint64_t newest = 0;
  for (const Message& message : node->messages) {
    if (message.key.load(std::memory_order_acquire) != key) continue;
    const std::uint64_t run = message.run.load(std::memory_order_acquire);
    // Another message may have taken its place meanwhile.
    if (message.key.load(std::memory_order_acquire) == key) newest = std::max(newest, run);
  }
  return newest;
}

}  // namespace catan_ros
