// The screen that `catan top` begins with: all chains, subchains, cores, notices and nodes.
//
// Thread safety: pure functions.
#pragma once

#include <cstddef>
#include <vector>

#include "top_screen.h"
#include "top_sections.h"
#include "view/picture.h"

namespace ctn::tool {

// What stands above every screen: the app, whether it runs, the plan in force and what that relaxed or assumed.
std::vector<ScreenLine> heading_lines(const view::Picture& picture, const ScreenState& state);

// The most important first.
std::vector<ScreenSection> main_sections(const view::Picture& picture, const ScreenState& state, std::size_t width);

}  // namespace ctn::tool
