// The terminal that `catan top` draws on: the only place that knows of ncurses.
//
// While it lives the terminal is in its full-screen mode; at its end it is as it was before. Thread safety: none; one
// owner, and at most one at a time.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "base/result.h"
#include "top_screen.h"

namespace ctn::tool {

class TopTerminal {
 public:
  // kEnvironment: a terminal that cannot be drawn on.
  static Result<std::unique_ptr<TopTerminal>> open(bool colours);
  ~TopTerminal();
  TopTerminal(const TopTerminal&) = delete;
  TopTerminal& operator=(const TopTerminal&) = delete;

  bool unicode() const { return unicode_; }
  ScreenSize size() const;
  void draw(const std::vector<ScreenLine>& lines);
  // The next key that was pressed, as press() takes them; none: no other was. 0: one that is none of these, or the
  // terminal has another size.
  std::optional<int> key();

 private:
  TopTerminal(void* screen, bool colours);

  void* screen_;
  bool colours_;
  bool unicode_;
};

}  // namespace ctn::tool
