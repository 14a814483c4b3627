// The terminal that `catan top` draws on. Nothing else uses ncurses.
//
// The terminal is in full-screen mode as long as the object lives, and as it was before afterwards. Thread safety:
// none; one owner, and at most one object at a time.
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
  // The next key that was pressed, as press() takes it; none: no more were pressed. 0: a key that means nothing to
  // press(), or the terminal's size has changed.
  std::optional<int> key();

 private:
  TopTerminal(void* screen, bool colours);

  void* screen_;
  bool colours_;
  bool unicode_;
};

}  // namespace ctn::tool
