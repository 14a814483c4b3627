#define NCURSES_NOMACROS  // they would rename functions of the standard library
#include "top_terminal.h"

#include <curses.h>
#include <langinfo.h>

#include <clocale>
#include <cstdio>
#include <cstdlib>
#include <string_view>

namespace ctn::tool {
namespace {

constexpr short kGreen = 1;
constexpr short kYellow = 2;
constexpr short kRed = 3;
// For so long an escape may be the beginning of what a key such as "up" sends.
constexpr int kEscapeMillis = 25;

attr_t attributes(Style style, bool colours) {
  const auto coloured = [&](short pair, attr_t without) -> attr_t {
    return colours ? static_cast<attr_t>(COLOR_PAIR(pair)) : without;
  };
  switch (style) {
    case Style::kPlain:
      return A_NORMAL;
    case Style::kTitle:
      return A_BOLD;
    case Style::kHeading:
      return A_BOLD | A_UNDERLINE;
    case Style::kDim:
      return A_DIM;
    case Style::kGood:
      return coloured(kGreen, A_NORMAL);
    case Style::kWarning:
      return coloured(kYellow, A_BOLD);
    case Style::kBad:
      return coloured(kRed, A_NORMAL) | A_BOLD;
    case Style::kSelected:
      return A_REVERSE;
  }
  return A_NORMAL;
}

}  // namespace

Result<std::unique_ptr<TopTerminal>> TopTerminal::open(bool colours) {
  std::setlocale(LC_CTYPE, "");
  SCREEN* const screen = newterm(nullptr, stdout, stdin);
  if (screen == nullptr) {
    const char* const kind = std::getenv("TERM");
    return Error::environment(
        std::string("this terminal cannot be drawn on (TERM is ") + (kind == nullptr ? "not set" : kind) + ")",
        "use --once, or set TERM to what the terminal is");
  }
  return std::unique_ptr<TopTerminal>(new TopTerminal(screen, colours));
}

TopTerminal::TopTerminal(void* screen, bool colours)
    : screen_(screen), colours_(colours && has_colors()), unicode_(std::string_view(nl_langinfo(CODESET)) == "UTF-8") {
  set_escdelay(kEscapeMillis);
  cbreak();
  noecho();
  curs_set(0);
  keypad(stdscr, TRUE);
  nodelay(stdscr, TRUE);
  if (!colours_) return;
  start_color();
  use_default_colors();
  init_pair(kGreen, COLOR_GREEN, -1);
  init_pair(kYellow, COLOR_YELLOW, -1);
  init_pair(kRed, COLOR_RED, -1);
}

TopTerminal::~TopTerminal() {
  endwin();
  delscreen(static_cast<SCREEN*>(screen_));
}

ScreenSize TopTerminal::size() const {
  return {static_cast<std::size_t>(getmaxx(stdscr)), static_cast<std::size_t>(getmaxy(stdscr))};
}

void TopTerminal::draw(const std::vector<ScreenLine>& lines) {
  werase(stdscr);
  for (std::size_t row = 0; row < lines.size(); ++row) {
    wmove(stdscr, static_cast<int>(row), 0);
    for (const Span& span : lines[row]) {
      const attr_t attribute = attributes(span.style, colours_);
      wattron(stdscr, static_cast<int>(attribute));
      waddstr(stdscr, span.text.c_str());
      wattroff(stdscr, static_cast<int>(attribute));
    }
  }
  wrefresh(stdscr);
}

std::optional<int> TopTerminal::key() {
  const int key = wgetch(stdscr);
  switch (key) {
    case ERR:
      return std::nullopt;
    case KEY_UP:
      return kKeyUp;
    case KEY_DOWN:
      return kKeyDown;
    case KEY_ENTER:
    case '\n':
    case '\r':
      return kKeyEnter;
    case 27:
      return kKeyEscape;
    default:
      return key > 0 && key < 256 ? key : 0;
  }
}

}  // namespace ctn::tool
