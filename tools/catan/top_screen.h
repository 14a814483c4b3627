// What `catan top` shows, as lines for a terminal of any size: from a picture (view/picture.h) and what the user has
// chosen to lines whose parts have styles. What is most important comes first; what does not fit is left out, and a
// line says how much that is. top_terminal.h draws them.
//
// Units: milliseconds, unless a figure has its unit beside it. Thread safety: pure functions.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "view/picture.h"

namespace ctn::tool {

enum class Style { kPlain, kTitle, kHeading, kDim, kGood, kWarning, kBad, kSelected };

struct Span {
  std::string text;
  Style style = Style::kPlain;
};
using ScreenLine = std::vector<Span>;

struct ScreenSize {
  std::size_t columns = 80;
  std::size_t rows = 24;
};

// By which subchains are sorted; the largest first, unless reversed.
enum class SortBy { kApp, kWeight, kCpu, kLate, kPeriod };

struct ScreenState {
  bool paused = false;
  bool help = false;
  bool open = false;         // the selected chain fills the screen
  std::size_t selected = 0;  // chain
  SortBy sort = SortBy::kApp;
  bool reversed = false;
  bool unicode = true;              // else ASCII only
  std::vector<std::string> causes;  // of the opened chain's late responses, as lines; empty: not asked for
};

// What a key does to the state; false: it is none of ours. Keys with no character of their own:
constexpr int kKeyUp = -1;
constexpr int kKeyDown = -2;
constexpr int kKeyEnter = -3;
constexpr int kKeyEscape = -4;
bool press(ScreenState& state, int key, std::size_t chains);

// At most as many lines as there are rows, none wider than there are columns.
std::vector<ScreenLine> top_screen(const view::Picture& picture, const ScreenState& state, ScreenSize size);

// All that there is, as plain text.
std::string top_text(const view::Picture& picture);

// On a terminal: characters, not bytes.
std::size_t screen_width(const std::string& text);

}  // namespace ctn::tool
