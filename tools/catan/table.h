// Tables as the command prints them, row by row, and what their cells hold.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "base/time.h"
#include "report/table.h"

namespace ctn::tool {

class Table {
 public:
  explicit Table(std::vector<std::string> header) { table_.header = std::move(header); }

  void add(std::vector<std::string> cells) { table_.rows.push_back(std::move(cells)); }

  // All columns aligned to the left.
  std::string text() const { return report::to_text(table_, report::Align::kLeft); }

 private:
  report::Table table_;
};

// "3.250ms".
std::string ms_text(Millis duration);

}  // namespace ctn::tool
