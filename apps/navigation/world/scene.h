// What stands and moves in a world: what rays hit, and what the robot touches. Box2D finds both.
//
//   walls   edges in a Box2D world, whose tree finds those that matter
//   movers  one shape each, placed for every question where the mover is at that time
//
// Questions may be asked of any time, in any order, and change nothing. Box2D computes in single precision: lengths are
// good to about 10 um in a world of 50 m.
//
// Units: metres, radians; times in seconds since the world began.
// Thread safety: cast() from any thread at any time. Distances from one thread at a time in the whole process (Box2D
// counts its calls in globals).
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "geometry.h"
#include "mover.h"
#include "world_file.h"

namespace ctn::navigation::world {

class Scene {
 public:
  // The phases that the file leaves open are drawn from the seed.
  Scene(const WorldFile& world, std::uint64_t seed);
  ~Scene();
  Scene(Scene&&) noexcept;
  Scene& operator=(Scene&&) noexcept;

  const std::vector<Mover>& movers() const { return movers_; }

  // The distance to the nearest thing along each of rays.size() rays, from `from.heading - field / 2` to
  // `from.heading + field / 2`; infinite where nothing is nearer than `range`. A single ray goes straight ahead.
  void cast(const Pose& from, double time, double field, double range, std::span<float> rays) const;

  // The distance between a square with sides of `size` and the nearest wall, at most `limit`. 0: they touch.
  double to_walls(const Pose& pose, double size, double limit) const;
  double to_mover(std::size_t mover, const Pose& pose, double size, double time) const;

 private:
  struct Shapes;
  std::unique_ptr<Shapes> shapes_;
  std::vector<Mover> movers_;
};

}  // namespace ctn::navigation::world
