// Rows of text under a header: the same table for a terminal (below) and for a page (html.h).
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace ctn::report {

// Rows may be shorter than the header: what is missing is empty.
struct Table {
  std::vector<std::string> header{};
  std::vector<std::vector<std::string>> rows{};
  std::string caption{};
};

// Whether all cells of a column are numbers (with or without a unit behind), dashes or empty: such a column is aligned
// to the right.
bool numeric_column(const Table& table, std::size_t column);

// Columns as wide as their widest cell, each line indented by two spaces; columns without any content are left out.
// Numeric columns are aligned to the right, or all columns to the left.
enum class Align { kNumbersRight, kLeft };
std::string to_text(const Table& table, Align align = Align::kNumbersRight);

}  // namespace ctn::report
