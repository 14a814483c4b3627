// The textures of the room (room.h), made from a seed.
//
// Thread safety: pure.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "world/room.h"

namespace ctn::vr::world {

// In the order in which textures() has them. There are several posters.
enum class Surface : std::size_t {
  kPlanks,
  kCeiling,
  kBricks,
  kWallpaper,
  kPlaster,
  kPanels,
  kBooks,
  kFabric,
  kWood,
  kRug,
  kWindow,
  kScreen,
  kDoor,
  kLeaves,
  kPoster,
};
inline constexpr std::size_t kPosters = 4;
inline constexpr std::size_t kTextures = static_cast<std::size_t>(Surface::kPoster) + kPosters;

std::vector<Texture> textures(std::uint64_t seed);

}  // namespace ctn::vr::world
