#include "vio/motion_vote.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace ctn::vr {
namespace {

constexpr int kMaxDirections = 60;  // finds an all-inlier pair among 40 % of outliers with a probability of 1 - 1e-11
constexpr double kEnoughInliers = 0.95;  // of all tracks: no need to try further directions

// SplitMix64.
std::uint64_t next_draw(std::uint64_t& state) {
  state += 0x9E3779B97F4A7C15U;
  std::uint64_t mixed = state;
  mixed = (mixed ^ (mixed >> 30U)) * 0xBF58476D1CE4E5B9U;
  mixed = (mixed ^ (mixed >> 27U)) * 0x94D049BB133111EBU;
  return mixed ^ (mixed >> 31U);
}

struct Pair {
  Eigen::Vector3d turned;  // the direction of before, as the rotation alone would have it now
  Eigen::Vector3d now;
};

// From the feature to the line that the translation would move it along.
double distance_of(const Pair& pair, const Eigen::Vector3d& translation) {
  const Eigen::Vector3d line = translation.cross(pair.turned);
  const double scale = line.head<2>().norm();
  const double to_turned = (pair.now.head<2>() / pair.now.z() - pair.turned.head<2>() / pair.turned.z()).norm();
  // Next to the point that the camera moves towards there is no line.
  if (scale < 1e-9) return to_turned;
  return std::min(to_turned, std::abs(pair.now.dot(line)) / (scale * pair.now.z()));
}

}  // namespace

MotionVote vote(const std::vector<Eigen::Vector2d>& before, const std::vector<Eigen::Vector2d>& now,
                const Eigen::Quaterniond& now_from_before, double tolerance, std::uint64_t seed) {
  MotionVote result;
  std::vector<Pair> pairs;
  pairs.reserve(before.size());
  for (std::size_t i = 0; i < before.size(); ++i) {
    pairs.push_back({now_from_before * before[i].homogeneous(), now[i].homogeneous()});
  }
  result.inlier.assign(pairs.size(), 0);
  if (pairs.empty()) return result;

  std::size_t largest = 0;
  std::uint64_t draws = seed;
  for (int round = 0; round < kMaxDirections; ++round) {
    const Pair& one = pairs[next_draw(draws) % pairs.size()];
    const Pair& other = pairs[next_draw(draws) % pairs.size()];
    // Perpendicular to the plane of each of the two features' motion; of two that did not move, any direction will do.
    Eigen::Vector3d translation = one.turned.cross(one.now).cross(other.turned.cross(other.now));
    const double length = translation.norm();
    translation = length > 1e-12 ? Eigen::Vector3d(translation / length) : Eigen::Vector3d::UnitX();
    std::vector<char> inlier(pairs.size());
    std::transform(pairs.begin(), pairs.end(), inlier.begin(), [&](const Pair& pair) {
      return static_cast<char>(pair.turned.z() > 0.0 && distance_of(pair, translation) < tolerance);
    });
    result.work.votes += pairs.size();
    const auto inliers = static_cast<std::size_t>(std::count(inlier.begin(), inlier.end(), 1));
    if (inliers <= largest) continue;
    largest = inliers;
    result.inlier = std::move(inlier);
    if (static_cast<double>(largest) >= kEnoughInliers * static_cast<double>(pairs.size())) break;
  }
  return result;
}

}  // namespace ctn::vr
