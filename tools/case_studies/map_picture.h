// A world of the navigation study from above, as SVG in the page's own colours.
//
// Thread safety: a pure function.
#pragma once

#include <string>

#include "world/world_file.h"

namespace ctn::case_studies {

// Walls, what moves with its path, where the robot starts, its goal.
std::string map_picture(const navigation::world::WorldFile& world);

}  // namespace ctn::case_studies
