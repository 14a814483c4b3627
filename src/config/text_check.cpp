#include "config/text_check.h"

#include <fmt/format.h>

#include <cstddef>

#include "config/yaml.h"

namespace ctn::config {
namespace {

// The length of the well-formed UTF-8 character that `text` begins with; 0: none. Precondition: not empty.
std::size_t character_length(std::string_view text) {
  const auto byte = [&](std::size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0U; };
  const auto continues = [&](std::size_t i) { return (byte(i) & 0xC0U) == 0x80U; };
  const unsigned first = byte(0);
  if (first < 0x80U) return 1;
  if (first >= 0xC2U && first <= 0xDFU) return continues(1) ? 2 : 0;
  if (first >= 0xE0U && first <= 0xEFU) {
    const bool overlong = first == 0xE0U && byte(1) < 0xA0U;
    const bool surrogate = first == 0xEDU && byte(1) >= 0xA0U;
    return continues(1) && continues(2) && !overlong && !surrogate ? 3 : 0;
  }
  if (first >= 0xF0U && first <= 0xF4U) {
    const bool overlong = first == 0xF0U && byte(1) < 0x90U;
    const bool beyond = first == 0xF4U && byte(1) >= 0x90U;
    return continues(1) && continues(2) && continues(3) && !overlong && !beyond ? 4 : 0;
  }
  return 0;
}

bool is_control(char c) {
  const auto byte = static_cast<unsigned char>(c);
  return (byte < 0x20 && c != '\n' && c != '\t' && c != '\r') || byte == 0x7F;
}

}  // namespace

std::optional<Problem> check_text(std::string_view text, std::string_view file) {
  Place place{std::string(file), 1, 1};
  if (text.size() > kMaxBytes) {
    return Problem{place, "", fmt::format("the file has more than {} bytes", kMaxBytes), "is it the right file?"};
  }
  bool indents = true;  // nothing but white space on this line so far
  bool tab = false;
  for (std::size_t i = 0; i < text.size();) {
    const char c = text[i];
    const std::size_t length = character_length(text.substr(i));
    if (length == 0) {
      return Problem{place, "", fmt::format("byte 0x{:02x} is not UTF-8", static_cast<unsigned char>(c)),
                     "save the file as UTF-8"};
    }
    if (is_control(c)) {
      return Problem{place, "", fmt::format("control character 0x{:02x}", static_cast<unsigned char>(c)), "remove it"};
    }
    if (c == '\r' && (i + 1 == text.size() || text[i + 1] != '\n')) {
      return Problem{place, "", "a carriage return that ends no line", "save the file with ordinary line ends"};
    }
    i += length;
    if (c == '\n') {
      ++place.line;
      place.column = 1;
      indents = true;
      tab = false;
      continue;
    }
    if (indents && c == '\t') {
      tab = true;
    } else if (indents && c != ' ' && c != '\r') {
      if (tab && c != '#') return Problem{place, "", "the line is indented by a tab", "indent by spaces"};
      indents = false;
    }
    ++place.column;
  }
  return std::nullopt;
}

}  // namespace ctn::config
