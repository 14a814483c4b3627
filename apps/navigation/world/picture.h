// A picture of a world, for people: walls, movers and their paths, the robot, its way and its newest scan; and what has
// been seen, if the robot explores.
//
// Thread safety: as World.
#pragma once

#include <string>

#include "catan/result.h"
#include "world.h"

namespace ctn::navigation::world {

// Writes PNG, or another format that the ending of the name says. Errors: kEnvironment, the picture cannot be written;
// kCaller, there is no such format.
Status write_picture(World& world, const std::string& path);

}  // namespace ctn::navigation::world
