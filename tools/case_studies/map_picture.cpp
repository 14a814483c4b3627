#include "map_picture.h"

#include <fmt/format.h>

#include <numbers>

#include "report/escape.h"

namespace ctn::case_studies {
namespace {

using navigation::Point;
using navigation::Segment;
using navigation::world::MoverSpec;
using navigation::world::WorldFile;

constexpr double kWidth = 460.0;  // pixels
constexpr double kRobot = 0.56;   // metres
constexpr double kDegrees = 180.0 / std::numbers::pi;

// A path through points, in a picture whose y axis points down.
std::string path_of(const std::vector<Point>& points) {
  std::string path;
  for (const Point& point : points) path += fmt::format("{}{:.5g},{:.5g}", path.empty() ? "M" : "L", point.x, -point.y);
  return path;
}

std::string box(Point at, double length, double width, double heading, const char* colour) {
  return fmt::format(
      "<rect x='{:.5g}' y='{:.5g}' width='{:.5g}' height='{:.5g}' transform='rotate({:.5g} {:.5g} {:.5g})' "
      "fill='{}'/>",
      at.x - length / 2.0, -at.y - width / 2.0, length, width, -heading * kDegrees, at.x, -at.y, colour);
}

std::string mover(const MoverSpec& spec, double line) {
  const char* const colour = "#d55e00";
  const std::string way =
      fmt::format("<path d='{}{}' fill='none' stroke='{}' stroke-width='{:.3g}' stroke-dasharray='{:.3g}'/>",
                  path_of(spec.path), spec.closed ? "Z" : "", colour, line, 3.0 * line);
  const Point at = spec.path.front();
  if (spec.radius <= 0.0) return way + box(at, spec.length, spec.width, spec.heading, colour);
  return way + fmt::format("<circle cx='{:.5g}' cy='{:.5g}' r='{:.5g}' fill='{}'/>", at.x, -at.y, spec.radius, colour);
}

}  // namespace

std::string map_picture(const WorldFile& world) {
  constexpr double kMargin = 0.3;
  const double width = world.bounds.width() + 2.0 * kMargin;
  const double height = world.bounds.height() + 2.0 * kMargin;
  std::string picture = fmt::format(
      "<svg role='img' width='{:.0f}' height='{:.0f}' viewBox='{:.5g} {:.5g} {:.5g} {:.5g}'><title>{}</title>", kWidth,
      kWidth * height / width, world.bounds.low.x - kMargin, -world.bounds.high.y - kMargin, width, height,
      report::escaped(world.name));
  const double line = width / 250.0;
  std::string walls;
  for (const Segment& wall : world.walls) walls += path_of({wall.from, wall.to});
  picture += fmt::format(
      "<path d='{}' fill='none' stroke='currentColor' stroke-width='{:.3g}' stroke-linecap='round'/>", walls, line);
  for (const MoverSpec& spec : world.movers) picture += mover(spec, line);
  picture += box(position(world.start), kRobot, kRobot, world.start.heading, "#0072b2");
  if (world.goal) {
    picture += fmt::format("<circle cx='{:.5g}' cy='{:.5g}' r='0.3' fill='none' stroke='#009e73' stroke-width='0.12'/>",
                           world.goal->x, -world.goal->y);
  }
  return picture + "</svg>";
}

}  // namespace ctn::case_studies
