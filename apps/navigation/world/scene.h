// What stands and moves in a world, for rays and for contact. Box2D finds both.
//
//   walls   edges in a Box2D world, whose tree finds those that matter
//   movers  one shape each, put where it is at the time asked for: nothing has to be moved before a question is asked
//
// Questions may be asked of any time, in any order, and change nothing. Box2D computes in single precision: lengths are
// good to about 10 um in a world of 50 m.
//
// Units: metres, radians; times in seconds since the world began.
// Thread safety: cast() from any thread at any time. Clearances from one thread at a time in the whole process (Box2D
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

  // How far it is to the first thing, along rays.size() rays from `from.heading - field / 2` to
  // `from.heading + field / 2`; infinite where nothing is nearer than `range`. With one ray it goes straight ahead.
  void cast(const Pose& from, double time, double field, double range, std::span<float> rays) const;

  // Between a square with sides of `size` and the nearest wall; `limit` if that is not nearer. 0: they touch.
  double to_walls(const Pose& pose, double size, double limit) const;
  double to_mover(std::size_t mover, const Pose& pose, double size, double time) const;

 private:
  struct Shapes;
  std::unique_ptr<Shapes> shapes_;
  std::vector<Mover> movers_;
};

}  // namespace ctn::navigation::world
