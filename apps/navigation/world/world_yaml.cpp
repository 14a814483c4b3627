#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <iterator>
#include <string>
#include <vector>

#include "world_file.h"

namespace ctn::navigation::world {
namespace {

// A quote inside quotes is written twice.
std::string quoted(const std::string& text) {
  std::string result = "'";
  for (const char letter : text) result += letter == '\'' ? "''" : std::string(1, letter);
  return result + "'";
}

std::string text_of(Point point) { return fmt::format("[{:.3f}, {:.3f}]", point.x, point.y); }

template <class Points>
std::string list_of(const Points& points) {
  std::vector<std::string> texts;
  for (const Point point : points) texts.push_back(text_of(point));
  return fmt::format("[{}]", fmt::join(texts, ", "));
}

}  // namespace

std::string to_yaml(const WorldFile& world) {
  std::string text = "catan_world: 1\n";
  if (!world.name.empty()) text += fmt::format("name: {}\n", quoted(world.name));
  const Box& in = world.bounds;
  text += fmt::format("bounds: [{:.3f}, {:.3f}, {:.3f}, {:.3f}]\n", in.low.x, in.low.y, in.high.x, in.high.y);
  std::vector<Segment> of_blocks;
  for (const auto& block : world.blocks) std::ranges::copy(sides_of(block), std::back_inserter(of_blocks));
  std::string walls;
  for (const Segment& wall : world.walls) {
    if (std::ranges::find(of_blocks, wall) != of_blocks.end()) continue;
    walls += fmt::format("  - [{}, {}]\n", text_of(wall.from), text_of(wall.to));
  }
  if (!walls.empty()) text += "walls:\n" + walls;
  if (!world.blocks.empty()) text += "blocks:\n";
  for (const auto& block : world.blocks) text += fmt::format("  - {}\n", list_of(block));
  text += fmt::format("robot: {{ at: {}, heading: {:.3f} }}\n", text_of(position(world.start)),
                      world.start.heading / kDegree);
  text += world.goal ? fmt::format("goal: {}\n", text_of(*world.goal)) : "explore: true\n";
  if (!world.movers.empty()) text += "movers:\n";
  for (const MoverSpec& mover : world.movers) {
    text += fmt::format("  - path: {}\n    speed: {:.3f}\n", list_of(mover.path), mover.speed);
    text += mover.radius > 0.0 ? fmt::format("    radius: {:.3f}\n", mover.radius)
                               : fmt::format("    size: {}\n    heading: {:.3f}\n",
                                             text_of({mover.length, mover.width}), mover.heading / kDegree);
    text += fmt::format("    closed: {}\n    pause: {:.3f}\n", mover.closed, mover.pause);
    text += mover.phase ? fmt::format("    phase: {:.3f}\n", *mover.phase) : "    phase: any\n";
  }
  return text;
}

}  // namespace ctn::navigation::world
