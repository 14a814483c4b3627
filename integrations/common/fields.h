// The fields of the lines that the command and the programs exchange (binding.h, observation.h): text between tabs,
// lists separated by commas, "-" where there is nothing.
//
// Thread safety: pure functions.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/binding.h"

namespace catan_ros {

inline constexpr std::string_view kEmptyField = "-";

// At least one part.
std::vector<std::string_view> split(std::string_view text, char separator);
// A whole number that is not negative.
std::optional<std::int64_t> parse_number(std::string_view text);

std::string_view or_nothing(const std::string& text);
std::string list_text(const std::vector<std::string>& list);
std::vector<std::string> read_list(std::string_view text);

std::string_view kind_text(Binding::Kind kind);
std::optional<Binding::Kind> parse_kind(std::string_view text);

}  // namespace catan_ros
