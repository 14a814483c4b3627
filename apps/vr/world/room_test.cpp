#include "world/room.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "program/random.h"
#include "world/textures.h"

namespace ctn::vr::world {
namespace {

// Inside, a ray meets something wherever it goes, no farther than the walls are.
TEST(Room, IsClosed) {
  const Room room(1);
  program::Draws draws(1, 1);
  for (int i = 0; i < 3000; ++i) {
    const Eigen::Vector3d from(draws.between(-2.7, 2.7), draws.between(-2.7, 2.7), draws.between(0.1, 2.8));
    const double angle = draws.between(-3.2, 3.2);
    const Eigen::Vector3d direction =
        Eigen::Vector3d(std::cos(angle), std::sin(angle), draws.between(-2.0, 2.0)).normalized();
    const auto distance = room.distance(from, direction);
    ASSERT_TRUE(distance);
    const Eigen::Vector3d hit = from + *distance * direction;
    constexpr double kRounding = 1e-5;
    ASSERT_LE(std::abs(hit.x()), Room::kLength / 2.0 + kRounding);
    ASSERT_LE(std::abs(hit.y()), Room::kWidth / 2.0 + kRounding);
    ASSERT_GE(hit.z(), -kRounding);
    ASSERT_LE(hit.z(), Room::kHeight + kRounding);
  }
}

TEST(Room, KnowsHowFarItsWallsAre) {
  const Room room(1);
  // Above the furniture and the posters, below the lamps.
  EXPECT_NEAR(*room.distance({0.0, 0.0, 2.7}, {1.0, 0.0, 0.0}), 3.8, 1e-6);
  EXPECT_NEAR(*room.distance({0.5, 0.0, 2.7}, {0.0, -0.5, 0.0}), 7.2, 1e-6);
  EXPECT_NEAR(*room.distance({2.0, 2.0, 1.0}, {0.0, 0.0, -1.0}), 1.0, 1e-6);
  EXPECT_NEAR(*room.distance({0.0, 0.0, 1.0}, {0.0, 0.0, -1.0}), 0.994, 1e-6);  // the rug
  EXPECT_FALSE(room.distance({5.0, 0.0, 1.0}, {1.0, 0.0, 0.0}));
}

TEST(Room, IsFreeInTheMiddle) {
  for (const std::uint64_t seed : {1U, 2U, 3U, 4U}) {
    const Room room(seed);
    for (const Rectangle& rectangle : room.rectangles()) {
      for (const float s : {0.0F, 1.0F}) {
        for (const float t : {0.0F, 1.0F}) {
          const Eigen::Vector3f corner = rectangle.origin + s * rectangle.right + t * rectangle.down;
          const bool low = corner.z() < 0.01F;
          const bool high = corner.z() > 2.5F;
          EXPECT_TRUE(low || high || std::abs(corner.x()) > Room::kFree || std::abs(corner.y()) > Room::kFree)
              << corner.transpose();
        }
      }
    }
  }
}

TEST(Room, FacesTheInside) {
  const Room room(1);
  // Of the walls, the floor and the ceiling: right x down points away from the middle.
  for (std::size_t i = 0; i < 2; ++i) {
    const Rectangle& rectangle = room.rectangles()[i];
    const Eigen::Vector3f middle = rectangle.origin + 0.5F * (rectangle.right + rectangle.down);
    EXPECT_GT(rectangle.right.cross(rectangle.down).dot(middle - Eigen::Vector3f(0.0F, 0.0F, 1.5F)), 0.0F);
  }
}

TEST(Room, DependsOnTheSeedAlone) {
  const auto same = [](const Room& one, const Room& other) {
    return std::ranges::equal(one.textures(), other.textures(), {}, &Texture::rgb, &Texture::rgb) &&
           std::ranges::equal(one.rectangles(), other.rectangles(), [](const Rectangle& a, const Rectangle& b) {
             return a.origin == b.origin && a.right == b.right && a.down == b.down && a.texture == b.texture &&
                    a.repeats == b.repeats && a.shade == b.shade;
           });
  };
  EXPECT_TRUE(same(Room(1), Room(1)));
  EXPECT_FALSE(same(Room(1), Room(2)));
}

// What a feature tracker looks for: pixels where the picture changes much in all directions.
TEST(Textures, HaveCorners) {
  for (const Texture& texture : textures(1)) {
    ASSERT_EQ(texture.rgb.size(), std::size_t{3} * Texture::kSide * Texture::kSide);
    const auto level = [&](int x, int y) {
      return static_cast<int>(texture.rgb[3 * static_cast<std::size_t>(y * Texture::kSide + x) + 1]);
    };
    int corners = 0;
    for (int y = 4; y < Texture::kSide - 4; y += 4) {
      for (int x = 4; x < Texture::kSide - 4; x += 4) {
        double xx = 0.0;
        double xy = 0.0;
        double yy = 0.0;
        for (int j = -3; j <= 3; ++j) {
          for (int i = -3; i <= 3; ++i) {
            const double dx = level(x + i + 1, y + j) - level(x + i - 1, y + j);
            const double dy = level(x + i, y + j + 1) - level(x + i, y + j - 1);
            xx += dx * dx;
            xy += dx * dy;
            yy += dy * dy;
          }
        }
        const double smaller = (xx + yy) / 2.0 - std::hypot((xx - yy) / 2.0, xy);
        corners += smaller > 7.0 * 30.0 * 30.0 ? 1 : 0;  // steps of 30 of 255 along both axes
      }
    }
    EXPECT_GT(corners, 60);
  }
}

}  // namespace
}  // namespace ctn::vr::world
