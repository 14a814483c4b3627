// A picture of a world, for looking at: walls, movers and their paths, the robot, its way and its newest scan; what has
// been seen, where it explores.
//
// Thread safety: as World.
#pragma once

#include <string>

#include "catan/result.h"
#include "world.h"

namespace ctn::navigation::world {

// As PNG, or another format that the name's ending asks for. Errors: kEnvironment, it cannot be written; kCaller, there
// is no such format.
Status write_picture(World& world, const std::string& path);

}  // namespace ctn::navigation::world
