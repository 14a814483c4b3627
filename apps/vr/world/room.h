// The room that the wearer is in: walls, floor, furniture and pictures on the walls, as rectangles with textures.
//
// The textures are made here, from the seed: planks, bricks, book spines, posters and the like, with sharp edges and
// corners at all distances from which they are seen, so that a feature tracker finds something wherever it looks. The
// furniture stands along the walls; the middle is free to walk about.
//
// distance() finds what a ray meets, by arithmetic alone: the true depth, for measures and for tests of what is drawn.
//
// Units: metres; the origin is in the middle of the floor, z is up. Thread safety: immutable.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

namespace ctn::vr::world {

// A square picture that repeats: kSide rows of kSide pixels of three bytes (red, green, blue), the first row on top.
struct Texture {
  static constexpr int kSide = 256;
  std::vector<std::uint8_t> rgb;
};

// The points origin + s right + t down, s and t from 0 to 1, as seen from its front: right x down points into it.
struct Rectangle {
  Eigen::Vector3f origin;
  Eigen::Vector3f right;
  Eigen::Vector3f down;
  std::size_t texture = 0;
  Eigen::Vector2f repeats{1.0F, 1.0F};  // of the texture, along right and down
  float shade = 1.0F;                   // how much light falls on it, 0 to 1
};

class Room {
 public:
  static constexpr double kLength = 7.6;  // along x
  static constexpr double kWidth = 7.2;   // along y
  static constexpr double kHeight = 3.0;
  // Nothing stands within this distance of the middle, along x and y.
  static constexpr double kFree = 2.75;

  explicit Room(std::uint64_t seed);

  const std::vector<Texture>& textures() const { return textures_; }
  const std::vector<Rectangle>& rectangles() const { return rectangles_; }

  // How far it is to what a ray meets first, in lengths of `direction`, which need not be 1. None: nothing, which can
  // only be outside of the room.
  std::optional<double> distance(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const;

 private:
  std::vector<Texture> textures_;
  std::vector<Rectangle> rectangles_;
};

}  // namespace ctn::vr::world
