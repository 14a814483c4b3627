// The screen of a chain that was opened in `catan top`: its response times as figures, over time and as a distribution,
// its nodes, and why its responses were late where that was asked.
//
// Thread safety: pure function.
#pragma once

#include <vector>

#include "top_screen.h"
#include "view/picture.h"

namespace ctn::tool {

// Appends the selected chain to the lines, which have the top of the screen. The picture has a chain.
void chain_screen(const view::Picture& picture, const ScreenState& state, ScreenSize size,
                  std::vector<ScreenLine>& lines);

}  // namespace ctn::tool
