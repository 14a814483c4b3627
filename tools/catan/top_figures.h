// Figures as `catan top` shows them: as text that is short, and drawn with the characters of a terminal. "-" stands for
// a figure that is not known.
//
// Thread safety: pure functions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/statistics.h"
#include "top_screen.h"

namespace ctn::tool {

// With three to five digits, whatever its size.
std::string short_figure(double value);
std::string short_figure(const std::optional<double>& value);
// Not known where there were no samples.
std::string short_figure(const Summary& summary, double Summary::*which);
// "25 %" of 0.25.
std::string percent_text(double part);
// "12.3 s", "2:05", "1:02:05".
std::string duration_text(double seconds);
// In that style, unless it is 0.
Span count_text(std::uint64_t number, Style style = Style::kWarning);

// One character for each step, the newest on the right; scaled from 0 to the largest value.
std::string sparkline(const std::vector<std::optional<double>>& values, std::size_t width, bool unicode);
// A bar that fills that part of the width.
std::string bar_text(double part, std::size_t width, bool unicode);

}  // namespace ctn::tool
