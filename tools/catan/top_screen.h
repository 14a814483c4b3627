// What `catan top` shows, as lines for a terminal of any size, made from a picture (view/picture.h) and what the user
// has chosen to see. The parts of lines have styles. The most important lines come first; what does not fit is left
// out, and a line says how much that is. top_terminal.h draws them.
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

// What subchains are sorted by, the largest first unless reversed. kApp: in the order of the app.
enum class SortBy { kApp, kWeight, kCpu, kLate, kPeriod };

struct ScreenState {
  bool paused = false;
  bool help = false;
  bool open = false;         // the selected chain fills the screen
  std::size_t selected = 0;  // index of a chain
  SortBy sort = SortBy::kApp;
  bool reversed = false;
  bool unicode = true;              // else ASCII only
  std::vector<std::string> causes;  // of the opened chain's late responses, as lines; empty: not asked for
};

// Keys that have no character of their own.
constexpr int kKeyUp = -1;
constexpr int kKeyDown = -2;
constexpr int kKeyEnter = -3;
constexpr int kKeyEscape = -4;
// Does to the state what the key is for. False: the key has no meaning here.
bool press(ScreenState& state, int key, std::size_t chains);

// At most as many lines as there are rows, none wider than there are columns.
std::vector<ScreenLine> top_screen(const view::Picture& picture, const ScreenState& state, ScreenSize size);

// The whole picture, whatever its size, as plain text.
std::string top_text(const view::Picture& picture);

// The columns that UTF-8 text takes on a terminal: characters, not bytes.
std::size_t screen_width(const std::string& text);

}  // namespace ctn::tool
