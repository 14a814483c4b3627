#include "top_screen.h"

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "top_chain_screen.h"
#include "top_main_screen.h"
#include "top_sections.h"
#include "top_table.h"

namespace ctn::tool {
namespace {

using view::Picture;

std::vector<ScreenLine> help_lines() {
  const auto line = [](const char* text) { return ScreenLine{{text, Style::kPlain}}; };
  return {line(""),
          line("up, down   select a chain            Enter   open it"),
          line("Esc        back                      q       quit"),
          line("p          pause, or go on           s, S    sort subchains; reverse"),
          line("w          in an opened chain: why its responses were late"),
          line(""),
          line("Figures are of the last 10 s. 'late' of a chain: over its bound; if it has none,"),
          line("over what was promised. 'late' of a subchain: took longer than was promised."),
          line("'prio': p3 a fixed priority, 1/4 a share of a frame's slot, own: its own cores."),
          line("'used': CPU time of a run, beside the 'budget' that is planned. 'stolen': how"),
          line("often an unfinished subchain went on in its slot. docs/top.md tells the rest.")};
}

}  // namespace

bool press(ScreenState& state, int key, std::size_t chains) {
  if (state.help && key != 'q') {
    state.help = false;
    return true;
  }
  switch (key) {
    case 'p':
      state.paused = !state.paused;
      return true;
    case 's':
      state.sort = state.sort == SortBy::kPeriod ? SortBy::kApp : static_cast<SortBy>(static_cast<int>(state.sort) + 1);
      return true;
    case 'S':
      state.reversed = !state.reversed;
      return true;
    case 'h':
    case '?':
      state.help = true;
      return true;
    case kKeyUp:
      if (state.selected > 0) --state.selected;
      state.causes.clear();
      return true;
    case kKeyDown:
      if (state.selected + 1 < chains) ++state.selected;
      state.causes.clear();
      return true;
    case kKeyEnter:
      state.open = chains > 0;
      return true;
    case kKeyEscape:
      state.open = false;
      state.causes.clear();
      return true;
    default:
      return false;
  }
}

std::vector<ScreenLine> top_screen(const Picture& picture, const ScreenState& state, ScreenSize size) {
  if (size.rows == 0) return {};
  const bool open = state.open && !picture.chains.empty();
  std::vector<ScreenLine> lines = heading_lines(picture, state);
  const std::size_t end = size.rows - 1;  // the last line is for the keys
  if (state.help) {
    for (ScreenLine& line : help_lines()) lines.push_back(std::move(line));
  } else if (open) {
    chain_screen(picture, state, size, lines);
  } else {
    place_sections(main_sections(picture, state, size.columns), end > lines.size() ? end - lines.size() : 0,
                   state.unicode, lines);
  }
  lines.resize(end);  // also cuts off a screen that is too long
  const char* const keys = state.help ? "any key: back   q quit"
                           : open     ? "Esc back   up/down another chain   w why late   p pause   h help   q quit"
                                      : "up/down, Enter open a chain   s/S sort subchains   p pause   h help   q quit";
  lines.push_back({{keys, Style::kDim}});
  for (ScreenLine& line : lines) line = cut_off(std::move(line), size.columns);
  return lines;
}

std::string top_text(const Picture& picture) {
  ScreenState state;
  state.selected = picture.chains.size();  // none
  constexpr std::size_t kWide = 1000;
  std::vector<ScreenLine> lines = heading_lines(picture, state);
  for (ScreenSection& section : main_sections(picture, state, kWide)) {
    lines.emplace_back();
    for (ScreenLine& line : section.lines) lines.push_back(std::move(line));
  }
  std::string text;
  for (const ScreenLine& line : lines) {
    std::string whole;
    for (const Span& span : line) whole += span.text;
    whole.erase(whole.find_last_not_of(' ') + 1);
    text += whole + "\n";
  }
  return text;
}

}  // namespace ctn::tool
