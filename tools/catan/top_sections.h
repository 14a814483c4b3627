// Sections of what `catan top` shows, which stand one below the other and share the lines of the screen, and what the
// main screen and that of an opened chain (top_main_screen.h, top_chain_screen.h) both have.
//
// Thread safety: pure functions.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "top_screen.h"
#include "view/picture.h"

namespace ctn::tool {

// Begins with a line of headings.
struct ScreenSection {
  std::vector<ScreenLine> lines;
  std::size_t min = 0;       // lines that it gets before any section gets more
  std::size_t selected = 0;  // row that must be visible
};

// Appends the sections to the lines, in at most so many rows. Each gets its `min` first, then the first ones get more;
// what does not fit is left out, and a line says how much that is.
void place_sections(std::vector<ScreenSection> sections, std::size_t rows, bool unicode,
                    std::vector<ScreenLine>& lines);

// What these nodes do.
ScreenSection node_section(const std::vector<const view::Node*>& nodes, const view::Picture& picture,
                           const ScreenState& state, std::size_t width);

// The style of one of the chain's response times.
Style response_style(const view::Chain& chain, double response_ms);
// "pre-empted 12, long-run 3"
std::string causes_text(const std::vector<view::LateBy>& causes);

}  // namespace ctn::tool
