#include "run/album.h"

#include <fmt/format.h>

#include <filesystem>
#include <system_error>
#include <utility>

#include "nodes/grid.h"

namespace ctn::navigation::run {
namespace {

// The map's frame begins as the world's, so that the robot's error shows.
world::Belief belief_of(const Planned& plan) {
  world::Belief belief;
  belief.cell = kCell;
  if (plan.path) belief.path = plan.path->points;
  if (!plan.map) return belief;
  const GlobalMap& map = *plan.map;
  for (int row = 0; row < map.frame.height; ++row) {
    for (int column = 0; column < map.frame.width; ++column) {
      if (map.cells[map.frame.index(column, row)] != Cell::kObstacle) continue;
      belief.obstacles.push_back(map.frame.centre(column, row));
    }
  }
  return belief;
}

}  // namespace

Moment moment_of(Drive& drive) { return {world::take_shot(drive.world()), drive.plan()}; }

Album::Album(std::string folder, world::WorldFile file, std::vector<world::Mover> movers)
    : folder_(std::move(folder)), file_(std::move(file)), movers_(std::move(movers)) {}

Result<Album> Album::open(const std::string& folder, const world::WorldFile& file,
                          const std::vector<world::Mover>& movers) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) {
    return Error::environment(fmt::format("the folder {} cannot be made", folder), "name another with --pictures");
  }
  return Album(folder, file, movers);
}

Status Album::draw(const Moment& moment) const {
  const auto second = std::chrono::duration_cast<std::chrono::seconds>(moment.shot.at).count();
  const std::filesystem::path path = std::filesystem::path(folder_) / fmt::format("second-{:04}.png", second);
  return world::write_picture(file_, movers_, moment.shot, belief_of(moment.plan), path.string());
}

}  // namespace ctn::navigation::run
