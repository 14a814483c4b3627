// Tells contents of files apart: FNV-1a, 64 bits. Not for keeping anything safe.
//
// Thread safety: values.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace ctn::program {

class Fingerprint {
 public:
  void add(std::span<const unsigned char> bytes) {
    for (const unsigned char byte : bytes) value_ = (value_ ^ byte) * 0x100000001b3U;
  }
  void add(std::string_view text) {
    for (const char letter : text) value_ = (value_ ^ static_cast<unsigned char>(letter)) * 0x100000001b3U;
  }
  std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 0xcbf29ce484222325U;
};

}  // namespace ctn::program
