#include "table.h"

#include <fmt/format.h>

#include <algorithm>

namespace ctn::tool {

std::string Table::text() const {
  const std::size_t columns = rows_.front().size();
  std::vector<std::size_t> widths(columns, 0);
  std::vector<bool> used(columns, false);
  for (std::size_t row = 0; row < rows_.size(); ++row) {
    for (std::size_t column = 0; column < columns; ++column) {
      widths[column] = std::max(widths[column], rows_[row][column].size());
      used[column] = used[column] || (row > 0 && !rows_[row][column].empty());
    }
  }
  std::string text;
  for (const auto& row : rows_) {
    std::string line;
    for (std::size_t column = 0; column < columns; ++column) {
      if (!used[column]) continue;
      line += "  " + row[column] + std::string(widths[column] - row[column].size(), ' ');
    }
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + "\n";
  }
  return text;
}

std::string ms_text(Millis duration) { return fmt::format("{:.3f}ms", duration.count()); }

}  // namespace ctn::tool
