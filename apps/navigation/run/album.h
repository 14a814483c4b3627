// Pictures of a run, one for each second of it: the world, and what the robot believes of it.
//
// Thread safety: one thread; draw() uses no world.
#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "catan/result.h"
#include "run/drive.h"
#include "run/hardware.h"
#include "world/mover.h"
#include "world/picture.h"
#include "world/world_file.h"

namespace ctn::navigation::run {

inline constexpr std::chrono::nanoseconds kPicturePeriod = std::chrono::seconds(1);

// What is needed to draw an instant of a drive.
struct Moment {
  world::Shot shot;
  Planned plan;
};
// At the instant that the drive has come to.
Moment moment_of(Drive& drive);

class Album {
 public:
  // Makes the folder. Errors (kEnvironment): it cannot be made.
  static Result<Album> open(const std::string& folder, const world::WorldFile& file,
                            const std::vector<world::Mover>& movers);

  // Writes `second-0007.png`. Errors (kEnvironment): it cannot be written.
  Status draw(const Moment& moment) const;

 private:
  Album(std::string folder, world::WorldFile file, std::vector<world::Mover> movers);

  std::string folder_;
  world::WorldFile file_;
  std::vector<world::Mover> movers_;
};

}  // namespace ctn::navigation::run
