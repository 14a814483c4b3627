// Grids of square cells, and how far each cell is from the nearest obstacle.
//
// Units: metres. Thread safety: values.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "geometry.h"

namespace ctn::navigation {

inline constexpr double kCell = 0.04;  // side of a cell

// Where a grid is. Cells lie at whole multiples of the side, so that two grids share theirs.
struct GridFrame {
  int left = 0;  // column of the first cell, counted from x = 0
  int bottom = 0;
  int width = 0;
  int height = 0;
  bool operator==(const GridFrame&) const = default;

  std::size_t cells() const { return static_cast<std::size_t>(width) * static_cast<std::size_t>(height); }
  int column(double x) const { return static_cast<int>(std::floor(x / kCell)) - left; }
  int row(double y) const { return static_cast<int>(std::floor(y / kCell)) - bottom; }
  bool inside(int at_column, int at_row) const {
    return at_column >= 0 && at_row >= 0 && at_column < width && at_row < height;
  }
  std::size_t index(int at_column, int at_row) const {
    return static_cast<std::size_t>(at_row) * static_cast<std::size_t>(width) + static_cast<std::size_t>(at_column);
  }
  Point centre(int at_column, int at_row) const {
    return {(at_column + left + 0.5) * kCell, (at_row + bottom + 0.5) * kCell};
  }
};

// For each cell the distance from its centre to that of the nearest cell that is an obstacle, exact, and `limit` where
// that is farther or there is none. `obstacles` has a value for each cell; not 0: an obstacle.
std::vector<float> clearance(const GridFrame& frame, const std::vector<std::uint8_t>& obstacles, double limit);

}  // namespace ctn::navigation
