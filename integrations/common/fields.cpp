#include "common/fields.h"

#include <algorithm>
#include <array>
#include <charconv>

namespace catan_ros {
namespace {

constexpr std::array<std::string_view, 4> kKinds{"topic", "timer", "service", "loop"};

}  // namespace

std::vector<std::string_view> split(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  for (;;) {
    const std::size_t end = text.find(separator);
    parts.push_back(text.substr(0, end));
    if (end == std::string_view::npos) return parts;
    text.remove_prefix(end + 1);
  }
}

std::optional<std::int64_t> parse_number(std::string_view text) {
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || value < 0) return std::nullopt;
  return value;
}

std::string_view or_nothing(const std::string& text) { return text.empty() ? kEmptyField : std::string_view(text); }

std::string list_text(const std::vector<std::string>& list) {
  std::string text;
  for (const std::string& item : list) {
    if (!text.empty()) text += ',';
    text += item;
  }
  return text;
}

std::vector<std::string> read_list(std::string_view text) {
  std::vector<std::string> list;
  if (text == kEmptyField) return list;
  for (const std::string_view item : split(text, ',')) list.emplace_back(item);
  return list;
}

std::string_view kind_text(Binding::Kind kind) { return kKinds[static_cast<std::size_t>(kind)]; }

std::optional<Binding::Kind> parse_kind(std::string_view text) {
  const auto* const kind = std::find(kKinds.begin(), kKinds.end(), text);
  if (kind == kKinds.end()) return std::nullopt;
  return static_cast<Binding::Kind>(kind - kKinds.begin());
}

}  // namespace catan_ros
