// Columns of text, each as wide as its widest cell, and what cells hold.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "base/time.h"

namespace ctn::tool {

class Table {
 public:
  explicit Table(std::vector<std::string> heads) { rows_.push_back(std::move(heads)); }

  // Precondition: as many cells as heads.
  void add(std::vector<std::string> cells) { rows_.push_back(std::move(cells)); }

  // Indented by two spaces; columns that hold nothing at all are left out.
  std::string text() const;

 private:
  std::vector<std::vector<std::string>> rows_;
};

// "3.250ms".
std::string ms_text(Millis duration);

}  // namespace ctn::tool
