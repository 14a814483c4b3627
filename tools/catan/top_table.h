// Rows of figures under headings, fitted to a width: the least important columns are left out first, and names are
// shortened in the middle.
//
// Thread safety: none; one owner.
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "top_screen.h"

namespace ctn::tool {

struct ScreenColumn {
  std::string heading;
  int rank = 0;  // the largest is left out first; 0: never
};

class ScreenTable {
 public:
  // The first column has names, aligned to the left; the others have figures, aligned to the right.
  explicit ScreenTable(std::vector<ScreenColumn> columns) : columns_(std::move(columns)) {}

  // Cells may be fewer than columns.
  void add(std::vector<Span> cells, bool selected = false);
  std::size_t rows() const { return rows_.size(); }
  // A line with the headings, then one for each row.
  std::vector<ScreenLine> lines(std::size_t width, bool unicode) const;

 private:
  struct Row {
    std::vector<Span> cells;
    bool selected = false;
  };
  std::size_t natural_width(std::size_t column) const;

  std::vector<ScreenColumn> columns_;
  std::vector<Row> rows_;
};

// The text, shortened in the middle to at most that width.
std::string shortened(const std::string& text, std::size_t width, bool unicode);
// The line, cut off at that width.
ScreenLine cut_off(ScreenLine line, std::size_t width);

}  // namespace ctn::tool
