#include "report/escape.h"

#include <algorithm>
#include <cstddef>
#include <vector>

namespace ctn::report {
namespace {

constexpr std::string_view kReplacement = "\xEF\xBF\xBD";

// How many bytes the UTF-8 sequence at the front of `text` has; 0: it is none (or overlong, or a surrogate).
std::size_t sequence_length(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char lead = byte(0);
  if (lead < 0x80) return 1;
  const std::size_t length = lead >= 0xC2 && lead < 0xE0   ? 2
                             : lead >= 0xE0 && lead < 0xF0 ? 3
                             : lead >= 0xF0 && lead < 0xF5 ? 4
                                                           : 0;
  if (length == 0 || text.size() < length) return 0;
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xC0) != 0x80) return 0;
  }
  if ((lead == 0xE0 && byte(1) < 0xA0) || (lead == 0xED && byte(1) > 0x9F)) return 0;
  if ((lead == 0xF0 && byte(1) < 0x90) || (lead == 0xF4 && byte(1) > 0x8F)) return 0;
  return length;
}

// The text's characters one by one, those that may not stand in a document replaced.
class Pieces {
 public:
  explicit Pieces(std::string_view text) {
    while (!text.empty()) {
      const std::size_t length = sequence_length(text);
      const std::string_view piece = text.substr(0, std::max<std::size_t>(length, 1));
      text.remove_prefix(piece.size());
      const char c = piece.front();
      const bool control = (static_cast<unsigned char>(c) < 0x20 && c != '\n' && c != '\t') || c == 0x7f;
      pieces_.push_back(length == 0 || control ? kReplacement : piece);
    }
  }
  auto begin() const { return pieces_.begin(); }
  auto end() const { return pieces_.end(); }

 private:
  std::vector<std::string_view> pieces_;
};

}  // namespace

std::string escaped(std::string_view text) {
  std::string result;
  for (const std::string_view piece : Pieces(text)) {
    if (piece == "&") {
      result += "&amp;";
    } else if (piece == "<") {
      result += "&lt;";
    } else if (piece == ">") {
      result += "&gt;";
    } else if (piece == "\"") {
      result += "&quot;";
    } else if (piece == "'") {
      result += "&#39;";
    } else {
      result += piece;
    }
  }
  return result;
}

std::string cleaned(std::string_view text) {
  std::string result;
  for (const std::string_view piece : Pieces(text)) {
    if (piece == "\n" || piece == "\t") {
      result += ' ';
    } else {
      result += piece;
    }
  }
  return result;
}

}  // namespace ctn::report
