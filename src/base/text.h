// Text that users write, and text for messages: trimming, quoting, and guessing what was meant.
//
// Thread safety: pure functions.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace ctn {

// Fit for one line of a terminal: control characters as \xNN.
std::string printable(std::string_view text);

// 'text', printable, long text cut off by "...".
std::string quote(std::string_view text);

// A name as that of a file: with '-' for each '/', and for a '.' at the beginning. Others may come to the same.
std::string as_file_name(std::string_view name);

// "'a', 'b' and 'c'"; of more than eight only the first, and how many more.
std::string quote_list(std::span<const std::string> names);

// "1st", "2nd", "3rd", "11th"; number >= 0.
std::string ordinal(int number);

// Without the blanks at both ends: spaces, tabs and ends of line.
std::string_view trimmed(std::string_view text);

// The candidate nearest to `word` by edits, if near enough to be what was meant; the first of several.
std::optional<std::string> nearest(std::string_view word, std::span<const std::string> candidates);

}  // namespace ctn
