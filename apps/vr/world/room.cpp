#include "world/room.h"

#include <array>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

#include "program/random.h"
#include "world/textures.h"

namespace ctn::vr::world {
namespace {

constexpr std::uint64_t kFurniture = 90;  // stream of random numbers

// Puts rectangles together to walls and furniture.
class Builder {
 public:
  explicit Builder(std::uint64_t seed) : draws_(seed, kFurniture) {}

  std::vector<Rectangle> build() {
    shell();
    for (int wall = 0; wall < 4; ++wall) furnish(wall);
    lamps();
    return std::move(rectangles_);
  }

 private:
  using Vector = Eigen::Vector3f;

  // Walls are numbered from the one at +x on, anticlockwise. As seen from the room, at(wall, s, z, d) is s metres to
  // the right of the wall's middle, z above the floor, d in front of it.
  struct Wall {
    Vector middle;
    Vector right;
    Vector inwards;
    float length;
  };
  static Wall wall_of(int number) {
    const auto half_length = static_cast<float>(Room::kLength / 2.0);
    const auto half_width = static_cast<float>(Room::kWidth / 2.0);
    switch (number) {
      case 0:
        return {{half_length, 0, 0}, {0, -1, 0}, {-1, 0, 0}, 2 * half_width};
      case 1:
        return {{0, half_width, 0}, {1, 0, 0}, {0, -1, 0}, 2 * half_length};
      case 2:
        return {{-half_length, 0, 0}, {0, 1, 0}, {1, 0, 0}, 2 * half_width};
      default:
        return {{0, -half_width, 0}, {-1, 0, 0}, {0, 1, 0}, 2 * half_length};
    }
  }
  static Vector at(const Wall& wall, float s, float z, float d) {
    return wall.middle + s * wall.right + d * wall.inwards + Vector(0, 0, z);
  }

  // Light comes from above and, a little, from the window.
  static float shade_of(const Vector& outwards) {
    const Vector light = Vector(0.25F, 0.35F, 0.9F).normalized();
    return 0.78F + 0.22F * outwards.normalized().dot(light);
  }
  void add(const Vector& origin, const Vector& right, const Vector& down, Surface surface, float metres,
           std::size_t variant = 0) {
    // metres: the side of the texture; 0: it is stretched over the whole rectangle.
    const Eigen::Vector2f repeats =
        metres > 0.0F ? Eigen::Vector2f(right.norm() / metres, down.norm() / metres) : Eigen::Vector2f(1.0F, 1.0F);
    rectangles_.push_back(
        {origin, right, down, static_cast<std::size_t>(surface) + variant, repeats, shade_of(down.cross(right))});
  }

  // Something upright against a wall, or in front of it.
  void panel(const Wall& wall, float s, float z, float width, float height, float d, Surface surface, float metres,
             std::size_t variant = 0) {
    add(at(wall, s - width / 2, z + height, d), width * wall.right, {0, 0, -height}, surface, metres, variant);
  }

  // A box whose back is `d` in front of the wall; `front` is the texture of its front, `rest` of its other sides.
  void box(const Wall& wall, float s, float z, float width, float height, float d, float depth, Surface front,
           Surface rest, float metres, bool stretched_front = false) {
    const float left = s - width / 2;
    const float near = d + depth;
    const Vector across = width * wall.right;
    const Vector out = depth * wall.inwards;
    const Vector fall(0, 0, -height);
    add(at(wall, left, z + height, near), across, fall, front, stretched_front ? 0.0F : metres);
    add(at(wall, left + width, z + height, near), -out, fall, rest, metres);
    add(at(wall, left, z + height, d), out, fall, rest, metres);
    add(at(wall, left + width, z + height, d), -across, fall, rest, metres);
    add(at(wall, left, z + height, d), across, out, rest, metres);
    add(at(wall, left, z, near), across, -out, rest, metres);
  }
  void legs(const Wall& wall, float s, float width, float height, float d, float depth) {
    constexpr float kLeg = 0.06F;
    for (const float x : {s - width / 2 + kLeg, s + width / 2 - kLeg}) {
      for (const float y : {d + 0.02F, d + depth - kLeg - 0.02F}) {
        box(wall, x, 0, kLeg, height, y, kLeg, Surface::kWood, Surface::kWood, 0.4F);
      }
    }
  }

  void shell() {
    const auto length = static_cast<float>(Room::kLength);
    const auto width = static_cast<float>(Room::kWidth);
    const auto height = static_cast<float>(Room::kHeight);
    add({-length / 2, width / 2, 0}, {length, 0, 0}, {0, -width, 0}, Surface::kPlanks, 1.6F);
    add({-length / 2, -width / 2, height}, {length, 0, 0}, {0, width, 0}, Surface::kCeiling, 1.2F);
    constexpr std::array kWalls{Surface::kBricks, Surface::kWallpaper, Surface::kPlaster, Surface::kPanels};
    for (int i = 0; i < 4; ++i) {
      const Wall wall = wall_of(i);
      panel(wall, 0, 0, wall.length, height, 0, kWalls[static_cast<std::size_t>(i)], 1.9F);
      box(wall, 0, 0, wall.length, 0.09F, 0, 0.015F, Surface::kWood, Surface::kWood, 0.5F);
    }
    add({-1.3F, 0.9F, 0.006F}, {2.6F, 0, 0}, {0, -1.8F, 0}, Surface::kRug, 0.0F);
  }

  void lamps() {
    for (const float x : {-1.6F, 1.6F}) {
      const Wall middle{{x, 0, 0}, {1, 0, 0}, {0, -1, 0}, 1.0F};
      box(middle, 0, 2.86F, 0.9F, 0.14F, -0.15F, 0.3F, Surface::kPanels, Surface::kPanels, 0.6F);
    }
  }

  void poster(const Wall& wall, float s, float z) {
    const auto size = static_cast<float>(draws_.between(0.55, 0.85));
    const auto variant = static_cast<std::size_t>(draws_.between(0, static_cast<int>(kPosters) - 1));
    panel(wall, s, z, size, size, 0.012F, Surface::kPoster, 0.0F, variant);
  }

  void furnish(int number) {
    const Wall wall = wall_of(number);
    const auto shift = static_cast<float>(draws_.between(-0.15, 0.15));  // no two rooms alike
    switch (number) {
      case 0:  // a desk with screens and a chair, a shelf
        box(wall, -1.2F + shift, 0.70F, 1.8F, 0.04F, 0.02F, 0.8F, Surface::kWood, Surface::kWood, 0.8F);
        legs(wall, -1.2F + shift, 1.8F, 0.70F, 0.02F, 0.8F);
        for (const float s : {-1.65F + shift, -0.85F + shift}) {
          box(wall, s, 0.86F, 0.62F, 0.38F, 0.2F, 0.05F, Surface::kScreen, Surface::kPanels, 0.6F, true);
          box(wall, s, 0.74F, 0.06F, 0.14F, 0.18F, 0.06F, Surface::kPanels, Surface::kPanels, 0.3F);
        }
        box(wall, 1.5F + shift, 0, 1.2F, 2.1F, 0.01F, 0.35F, Surface::kBooks, Surface::kWood, 1.1F);
        poster(wall, 0.4F + shift, 1.5F);
        poster(wall, -1.2F + shift, 1.7F);
        break;
      case 1:  // a sofa below the window, a plant
        box(wall, 0.2F + shift, 0.1F, 2.0F, 0.35F, 0.05F, 0.75F, Surface::kFabric, Surface::kFabric, 0.7F);
        box(wall, 0.2F + shift, 0.45F, 2.0F, 0.4F, 0.05F, 0.2F, Surface::kFabric, Surface::kFabric, 0.7F);
        for (const float s : {-0.9F + shift, 1.3F + shift}) {
          box(wall, s, 0.1F, 0.18F, 0.6F, 0.05F, 0.75F, Surface::kFabric, Surface::kFabric, 0.6F);
        }
        panel(wall, 0.2F + shift, 1.1F, 1.9F, 1.5F, 0.02F, Surface::kWindow, 0.0F);
        box(wall, 2.6F, 0, 0.35F, 0.4F, 0.2F, 0.35F, Surface::kBricks, Surface::kBricks, 0.9F);
        box(wall, 2.6F, 0.4F, 0.6F, 0.9F, 0.08F, 0.6F, Surface::kLeaves, Surface::kLeaves, 0.7F);
        poster(wall, -2.4F + shift, 1.3F);
        break;
      case 2:  // a door, a cabinet with boxes on it
        panel(wall, 2.2F, 0, 0.95F, 2.05F, 0.02F, Surface::kDoor, 0.0F);
        box(wall, -1.3F + shift, 0.08F, 2.2F, 0.8F, 0.02F, 0.5F, Surface::kPanels, Surface::kWood, 0.9F);
        box(wall, -1.9F + shift, 0.88F, 0.4F, 0.3F, 0.1F, 0.3F, Surface::kPoster, Surface::kPanels, 0.5F);
        box(wall, -1.2F + shift, 0.88F, 0.5F, 0.22F, 0.1F, 0.35F, Surface::kFabric, Surface::kFabric, 0.4F);
        box(wall, -0.6F + shift, 0.88F, 0.25F, 0.45F, 0.1F, 0.25F, Surface::kBooks, Surface::kBooks, 0.7F);
        poster(wall, 0.8F + shift, 1.35F);
        poster(wall, -1.5F + shift, 1.75F);
        break;
      default:  // shelves, a low table with a plant
        for (const float s : {-2.2F, -0.9F}) {
          box(wall, s + shift, 0, 1.1F, 1.9F, 0.01F, 0.35F, Surface::kBooks, Surface::kWood, 1.0F);
        }
        box(wall, 1.6F + shift, 0.42F, 1.2F, 0.05F, 0.05F, 0.6F, Surface::kWood, Surface::kWood, 0.7F);
        legs(wall, 1.6F + shift, 1.2F, 0.42F, 0.05F, 0.6F);
        box(wall, 1.4F + shift, 0.47F, 0.3F, 0.5F, 0.2F, 0.3F, Surface::kLeaves, Surface::kLeaves, 0.5F);
        box(wall, 1.9F + shift, 0.47F, 0.35F, 0.08F, 0.2F, 0.25F, Surface::kBooks, Surface::kPoster, 0.35F);
        poster(wall, 0.6F + shift, 1.4F);
        poster(wall, 1.8F + shift, 1.6F);
        break;
    }
  }

  program::Draws draws_;
  std::vector<Rectangle> rectangles_;
};

}  // namespace

Room::Room(std::uint64_t seed) : textures_(world::textures(seed)), rectangles_(Builder(seed).build()) {}

std::optional<double> Room::distance(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const {
  constexpr double kOnIt = 1e-9;  // a ray that starts on a surface does not meet it
  std::optional<double> nearest;
  for (const Rectangle& rectangle : rectangles_) {
    const Eigen::Vector3d right = rectangle.right.cast<double>();
    const Eigen::Vector3d down = rectangle.down.cast<double>();
    const Eigen::Vector3d normal = right.cross(down);
    const double slope = normal.dot(direction);
    if (std::abs(slope) < 1e-15) continue;
    const Eigen::Vector3d from = rectangle.origin.cast<double>() - origin;
    const double way = normal.dot(from) / slope;
    if (way < kOnIt || (nearest && way >= *nearest)) continue;
    const Eigen::Vector3d on = way * direction - from;
    const double s = on.dot(right) / right.squaredNorm();
    const double t = on.dot(down) / down.squaredNorm();
    if (s >= 0.0 && s <= 1.0 && t >= 0.0 && t <= 1.0) nearest = way;
  }
  return nearest;
}

}  // namespace ctn::vr::world
