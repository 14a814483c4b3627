// Numbers as text for a page's script: base64 of bytes, in which each number takes as many bytes as it needs (LEB128:
// seven bits a byte, the lowest first; the eighth bit says that more follow).
//
// Thread safety: none; one owner.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace ctn::page {

std::string base64(std::span<const std::uint8_t> bytes);

class Packer {
 public:
  // A number below 0 counts as 0.
  void add(std::int64_t number) {
    auto rest = static_cast<std::uint64_t>(number < 0 ? 0 : number);
    for (; rest >= 0x80; rest >>= 7U) bytes_.push_back(static_cast<std::uint8_t>(rest | 0x80U));
    bytes_.push_back(static_cast<std::uint8_t>(rest));
  }
  std::string text() const { return base64(bytes_); }

 private:
  std::vector<std::uint8_t> bytes_;
};

}  // namespace ctn::page
