// A world as a value, and the files that describe one (docs/navigation-worlds.md).
//
// Walls are line segments: those of the file's lines and blocks, and the outlines of an image's dark pixels, so that
// a wall is exactly where its pixels are. A block is its outline, which nothing that starts outside can pass.
//
// Units: metres, radians, seconds; files have degrees. Thread safety: plain values.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "catan/result.h"
#include "geometry.h"
#include "mover.h"
#include "robot.h"

namespace ctn::navigation::world {

struct WorldFile {
  std::string name;
  Box bounds;
  std::vector<Segment> walls;
  std::vector<std::vector<Point>> blocks;  // for pictures; their sides are among the walls
  Pose start;
  std::optional<Point> goal;  // none: the robot explores
  std::vector<MoverSpec> movers;

  bool explore() const { return !goal.has_value(); }
  friend bool operator==(const WorldFile&, const WorldFile&) = default;
};

// Errors: kCaller, all that is wrong with the file, each with its place; kEnvironment, where it cannot be read.
Result<WorldFile> read_world(const std::string& path);
// `file` names the text in errors; an image is looked for in `folder`.
Result<WorldFile> parse_world(std::string_view text, const std::string& file, const std::string& folder);

// The path of the image that the world at `path` takes walls from; empty: it names none, or is no world.
std::string image_of(const std::string& path);

// A file that parse_world() reads as the same world, to the millimetre. Walls that belong to no block are lines.
std::string to_yaml(const WorldFile& world);

// Adds the sides of a closed block to the walls.
void add_block(WorldFile& world, std::vector<Point> corners);

}  // namespace ctn::navigation::world
