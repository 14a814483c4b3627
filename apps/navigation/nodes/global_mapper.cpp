#include "global_mapper.h"

#include <mrpt/maps/COccupancyGridMap2D.h>
#include <mrpt/obs/CObservation2DRangeScan.h>

#include <algorithm>
#include <cmath>

namespace ctn::navigation {
namespace {

// A hit outweighs almost two beams that graze the cell: a wall stays, and the trace of what moved is soon seen through.
constexpr float kSureOfHit = 0.75F;
constexpr float kSureOfPassing = 0.65F;
constexpr float kFreeFrom = 0.55F;  // MRPT's cells are probabilities to be free
constexpr float kObstacleBelow = 0.45F;
constexpr double kBorder = 0.4;

Box seen_from(const std::vector<Keyframe>& keyframes, Work& work) {
  const Point start = position(keyframes.front().pose);
  Box box{start, start};
  const auto include = [&box](const Point& point) {
    box.low = {std::min(box.low.x, point.x), std::min(box.low.y, point.y)};
    box.high = {std::max(box.high.x, point.x), std::max(box.high.y, point.y)};
  };
  for (const Keyframe& keyframe : keyframes) {
    if (keyframe.outdated) continue;
    include(position(keyframe.pose));
    for (std::size_t beam = 0; beam < keyframe.scan->ranges.size(); ++beam) {
      const double range = std::min(static_cast<double>(keyframe.scan->ranges[beam]), GlobalMapper::kReach);
      const double angle = keyframe.scan->angle(beam);
      include(transformed(keyframe.pose, Point{range * std::cos(angle), range * std::sin(angle)}));
    }
    work.beams += keyframe.scan->ranges.size();
  }
  return box;
}

mrpt::obs::CObservation2DRangeScan observation_of(const CleanScan& scan) {
  mrpt::obs::CObservation2DRangeScan observation;
  observation.aperture = static_cast<float>(scan.field);
  observation.rightToLeft = true;
  observation.maxRange = static_cast<float>(scan.max_range);
  observation.resizeScan(scan.ranges.size());
  for (std::size_t beam = 0; beam < scan.ranges.size(); ++beam) {
    const bool hit = std::isfinite(scan.ranges[beam]);
    observation.setScanRange(beam, hit ? scan.ranges[beam] : observation.maxRange);
    observation.setScanRangeValidity(beam, hit);
  }
  return observation;
}

Cell cell_of(float probability_free) {
  if (probability_free >= kFreeFrom) return Cell::kFree;
  return probability_free < kObstacleBelow ? Cell::kObstacle : Cell::kUnknown;
}

// The cells in which, or beside which, a point lies that did not move.
std::vector<bool> with_still_points(const GridFrame& frame, const std::vector<Keyframe>& keyframes,
                                    const StillPoints& still, Work& work) {
  std::vector<bool> cells(frame.cells());
  for (std::size_t i = 0; i < keyframes.size(); ++i) {
    if (keyframes[i].outdated) continue;
    for (const Point& point : still[i]) {
      const Point at = transformed(keyframes[i].pose, point);
      const int column = frame.column(at.x);
      const int row = frame.row(at.y);
      for (int y = row - 1; y <= row + 1; ++y) {
        for (int x = column - 1; x <= column + 1; ++x) {
          if (frame.inside(x, y)) cells[frame.index(x, y)] = true;
        }
      }
    }
    work.cells += 9 * still[i].size();
  }
  return cells;
}

}  // namespace

GlobalMapper::GlobalMapper() : map_(std::make_shared<const GlobalMap>()) {}

GlobalMapper::Result GlobalMapper::run(const Localization& localization) {
  Work work;
  if (localization.keyframes == used_ || localization.keyframes->empty()) return {map_, work};
  const std::vector<Keyframe>& keyframes = *localization.keyframes;

  const Box box = seen_from(keyframes, work);
  mrpt::maps::COccupancyGridMap2D grid;
  grid.setSize(static_cast<float>(box.low.x - kBorder), static_cast<float>(box.high.x + kBorder),
               static_cast<float>(box.low.y - kBorder), static_cast<float>(box.high.y + kBorder),
               static_cast<float>(kCell));
  grid.insertionOptions.maxDistanceInsertion = static_cast<float>(kReach);
  grid.insertionOptions.maxOccupancyUpdateCertainty = kSureOfHit;
  grid.insertionOptions.maxFreenessUpdateCertainty = kSureOfPassing;
  grid.insertionOptions.maxFreenessInvalidRanges = kSureOfPassing;
  grid.insertionOptions.wideningBeamsWithDistance = true;
  for (const Keyframe& keyframe : keyframes) {
    if (keyframe.outdated) continue;
    const mrpt::poses::CPose3D pose(keyframe.pose.x, keyframe.pose.y, 0.0, keyframe.pose.heading, 0.0, 0.0);
    grid.insertObservation(observation_of(*keyframe.scan), pose);
    for (const float range : keyframe.scan->ranges) {
      work.cells += static_cast<std::uint64_t>(std::min(static_cast<double>(range), kReach) / kCell);
    }
  }

  auto map = std::make_shared<GlobalMap>();
  map->stamp = localization.stamp;
  map->anchor = {keyframes.size(), keyframes.back().pose};
  map->frame = {static_cast<int>(std::lround(static_cast<double>(grid.getXMin()) / kCell)),
                static_cast<int>(std::lround(static_cast<double>(grid.getYMin()) / kCell)),
                static_cast<int>(grid.getSizeX()), static_cast<int>(grid.getSizeY())};
  Work seen;
  still_.add(keyframes, seen);
  work.cells += seen.beams;  // which cost far less than those of a scan that is drawn
  const std::vector<bool> has_still_points = with_still_points(map->frame, keyframes, still_, work);
  map->cells.resize(map->frame.cells());
  for (int row = 0; row < map->frame.height; ++row) {
    for (int column = 0; column < map->frame.width; ++column) {
      const std::size_t index = map->frame.index(column, row);
      const Cell cell = cell_of(grid.getCell(column, row));
      map->cells[index] = cell == Cell::kObstacle && !has_still_points[index] ? Cell::kFree : cell;
    }
  }
  work.cells += map->frame.cells();
  used_ = localization.keyframes;
  map_ = std::move(map);
  return {map_, work};
}

}  // namespace ctn::navigation
