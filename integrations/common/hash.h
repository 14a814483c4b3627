// Hashes by which programs of an app find what others wrote into a file that they share: the same in all of them. Of 64
// bits, and never 0, which is a place that is free. Not for what somebody may want to be equal: it is quick, no more.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace catan_ros {

// Of what comes before and this.
std::uint64_t add_to_hash(std::uint64_t hash, std::uint64_t value);
std::uint64_t add_to_hash(std::uint64_t hash, std::span<const std::byte> bytes);

std::uint64_t hash_of(std::string_view name);
std::uint64_t hash_of(std::string_view node, std::string_view topic);

}  // namespace catan_ros
