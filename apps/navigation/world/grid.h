// A world as cells: which of them a wall crosses, how far each is from the nearest wall, and which can be reached.
//
// Units: metres. Thread safety: plain values.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "geometry.h"
#include "world_file.h"

namespace ctn::navigation::world {

class Grid {
 public:
  Grid(const WorldFile& world, double resolution);

  // Adds a wall that the world does not have.
  void add(const Segment& wall);

  std::size_t columns() const { return columns_; }
  std::size_t rows() const { return rows_; }
  std::size_t size() const { return columns_ * rows_; }
  // Nothing for a point outside.
  std::optional<std::size_t> cell(Point point) const;
  Point centre(std::size_t cell) const;
  bool wall(std::size_t cell) const { return walls_[cell] != 0; }
  // The exact distance from the centre of the point's cell to the nearest wall; at most about a metre, and 0 outside.
  double clearance(Point point) const;

  // For each cell, whether a disc of this radius can get there from `from` without touching a wall, its centre going
  // from centre of cell to centre of cell, through sides and corners. Radius 0: whether it is free and connected
  // through sides alone.
  std::vector<std::uint8_t> reachable(Point from, double radius) const;
  bool path_exists(Point from, Point to, double radius) const;

 private:
  double resolution_;
  Point origin_;
  std::size_t columns_ = 0;
  std::size_t rows_ = 0;
  std::vector<std::uint8_t> walls_;
  std::vector<float> clearances_;
};

// The part of the free space that a laser has seen.
class Explored {
 public:
  Explored(const WorldFile& world, double resolution);

  // Marks as seen what lies along rays from `from`, which are as Scene::cast() returns them.
  void see(const Pose& from, double field, double range, const std::vector<float>& rays);
  // Which part of the cells that can be reached from the start was seen.
  double fraction() const;
  bool seen(std::size_t cell) const { return seen_[cell] != 0; }
  const Grid& grid() const { return grid_; }

 private:
  Grid grid_;
  double resolution_;
  std::vector<std::uint8_t> free_;
  std::vector<std::uint8_t> seen_;
  std::size_t free_count_ = 0;
  std::size_t seen_count_ = 0;
};

}  // namespace ctn::navigation::world
