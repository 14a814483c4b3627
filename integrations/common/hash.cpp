#include "common/hash.h"

#include <algorithm>
#include <cstring>

namespace catan_ros {
namespace {

constexpr std::uint64_t kHashStart = 14695981039346656037ULL;
constexpr std::uint64_t kHashFactor = 1099511628211ULL;

}  // namespace

// The upper half is added to the lower one, since a product carries nothing down: else two changes of the highest bit,
// as of the signs of two numbers, would be none.
std::uint64_t add_to_hash(std::uint64_t hash, std::uint64_t value) {
  const std::uint64_t product = (hash ^ value) * kHashFactor;
  return std::max<std::uint64_t>(product ^ (product >> 32U), 1);
}

// Eight at a time: it is done for each message that a program gets.
std::uint64_t add_to_hash(std::uint64_t hash, std::span<const std::byte> bytes) {
  for (std::uint64_t word = 0; bytes.size() >= sizeof word; bytes = bytes.subspan(sizeof word)) {
    std::memcpy(&word, bytes.data(), sizeof word);
    hash = add_to_hash(hash, word);
  }
  for (const std::byte byte : bytes) hash = add_to_hash(hash, std::to_integer<std::uint64_t>(byte));
  return hash;
}

std::uint64_t hash_of(std::string_view name) {
  return add_to_hash(kHashStart, std::as_bytes(std::span(name.data(), name.size())));
}

std::uint64_t hash_of(std::string_view node, std::string_view topic) {
  return add_to_hash(hash_of(node), hash_of(topic));
}

}  // namespace catan_ros
