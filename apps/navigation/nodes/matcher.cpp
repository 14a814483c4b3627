#include "matcher.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

namespace ctn::navigation {
namespace {

constexpr double kMargin = 1.5;       // of the grid beyond the reach: as far as the windows may move a point
constexpr double kSmear = 0.06;       // standard deviation of a hit
constexpr int kKernel = 4;            // cells to each side
constexpr double kCoarseStep = 0.04;  // a cell: a larger step could pass over the best pose
constexpr double kCoarseTurn = 0.02;  // at 3 m, what a step is
constexpr double kFineStep = 0.01;    // what the laser errs by
constexpr double kFineTurn = 0.004;   // a beam
constexpr std::uint64_t kCellsInterpolated = 4;
constexpr double kPenalty = 0.1;  // of the score, at the window's edge

using Kernel = std::array<std::uint8_t, (2 * kKernel + 1) * (2 * kKernel + 1)>;

Kernel make_kernel() {
  Kernel kernel{};
  std::size_t at = 0;
  for (int row = -kKernel; row <= kKernel; ++row) {
    for (int column = -kKernel; column <= kKernel; ++column) {
      const double squared = (row * row + column * column) * kCell * kCell;
      kernel[at++] = static_cast<std::uint8_t>(std::lround(255.0 * std::exp(-squared / (2.0 * kSmear * kSmear))));
    }
  }
  return kernel;
}

int steps_to_each_side(double extent, double step) { return static_cast<int>(std::ceil(extent / step - 1e-9)); }

}  // namespace

void Matcher::start(const Pose& expected) {
  expected_ = expected;
  const int half = static_cast<int>(std::lround((kReach + kMargin) / kCell));
  frame_ = {static_cast<int>(std::floor(expected.x / kCell)) - half,
            static_cast<int>(std::floor(expected.y / kCell)) - half, 2 * half, 2 * half};
  field_.assign(frame_.cells(), 0);
  work_.cells += frame_.cells();
}

void Matcher::add(const Pose& pose, const std::vector<Point>& points) {
  static const Kernel kOfPoint = make_kernel();
  const double c = std::cos(pose.heading);
  const double s = std::sin(pose.heading);
  for (const Point& point : points) {
    const int column = frame_.column(pose.x + c * point.x - s * point.y);
    const int row = frame_.row(pose.y + s * point.x + c * point.y);
    if (!frame_.inside(column - kKernel, row - kKernel) || !frame_.inside(column + kKernel, row + kKernel)) continue;
    if (field_[frame_.index(column, row)] == 255) continue;  // a point is there already
    std::size_t at = 0;
    for (int y = row - kKernel; y <= row + kKernel; ++y) {
      std::uint8_t* cell = field_.data() + frame_.index(column - kKernel, y);
      for (int x = 0; x <= 2 * kKernel; ++x, ++cell, ++at) *cell = std::max(*cell, kOfPoint[at]);
    }
    work_.cells += kOfPoint.size();
  }
}

void Matcher::turn_points(double heading) {
  const double c = std::cos(heading);
  const double s = std::sin(heading);
  turned_.x.resize(near_.size());
  turned_.y.resize(near_.size());
  for (std::size_t i = 0; i < near_.size(); ++i) {
    turned_.x[i] = (c * near_[i].x - s * near_[i].y) / kCell - frame_.left;
    turned_.y[i] = (s * near_[i].x + c * near_[i].y) / kCell - frame_.bottom;
  }
}

double Matcher::coarse_score(double x, double y) const {
  const double at_x = x / kCell;
  const double at_y = y / kCell;
  std::uint64_t sum = 0;
  for (std::size_t i = 0; i < turned_.x.size(); ++i) {
    // Never outside the grid: it is larger than the reach by more than any window.
    const int column = static_cast<int>(turned_.x[i] + at_x);
    const int row = static_cast<int>(turned_.y[i] + at_y);
    if (frame_.inside(column, row)) sum += field_[frame_.index(column, row)];
  }
  return static_cast<double>(sum) / (255.0 * static_cast<double>(turned_.x.size()));
}

double Matcher::fine_score(double x, double y) const {
  const double at_x = x / kCell - 0.5;  // between the centres of cells
  const double at_y = y / kCell - 0.5;
  const auto width = static_cast<std::size_t>(frame_.width);
  float sum = 0.0F;
  for (std::size_t i = 0; i < turned_.x.size(); ++i) {
    const double column = turned_.x[i] + at_x;
    const double row = turned_.y[i] + at_y;
    const int left = static_cast<int>(column);
    const int below = static_cast<int>(row);
    if (!frame_.inside(left, below) || !frame_.inside(left + 1, below + 1)) continue;
    const std::uint8_t* cell = field_.data() + frame_.index(left, below);
    const auto right_share = static_cast<float>(column - left);
    const auto upper_share = static_cast<float>(row - below);
    const auto lower_left = static_cast<float>(cell[0]);
    const auto upper_left = static_cast<float>(cell[width]);
    const float lower = lower_left + right_share * (static_cast<float>(cell[1]) - lower_left);
    const float upper = upper_left + right_share * (static_cast<float>(cell[width + 1]) - upper_left);
    sum += lower + upper_share * (upper - lower);
  }
  return static_cast<double>(sum) / (255.0 * static_cast<double>(turned_.x.size()));
}

Matcher::Match Matcher::best_of(const Poses& poses, bool fine, const Window& window) {
  const Pose& centre = poses.centre;
  const int offsets = steps_to_each_side(poses.offset, poses.offset_step);
  const int turns = steps_to_each_side(poses.turn, poses.turn_step);
  Match best;
  best.score = -1.0;
  double best_judged = -1.0;
  for (int k = -turns; k <= turns; ++k) {
    const double heading = centre.heading + k * poses.turn_step;
    turn_points(heading);
    for (int j = -offsets; j <= offsets; ++j) {
      for (int i = -offsets; i <= offsets; ++i) {
        const Pose pose{centre.x + i * poses.offset_step, centre.y + j * poses.offset_step, heading};
        const double score = fine ? fine_score(pose.x, pose.y) : coarse_score(pose.x, pose.y);
        const double away = distance(position(pose), position(expected_)) / window.offset;
        const double turned = wrapped(heading - expected_.heading) / window.turn;
        const double judged = score * (1.0 - kPenalty * std::min(1.0, 0.5 * (away * away + turned * turned)));
        if (judged <= best_judged) continue;
        best_judged = judged;
        best = {pose, score};
      }
    }
  }
  const std::uint64_t side = 2 * static_cast<std::uint64_t>(offsets) + 1;
  const std::uint64_t lookups = side * side * (2 * static_cast<std::uint64_t>(turns) + 1) * near_.size();
  work_.candidates += fine ? kCellsInterpolated * lookups : lookups;
  best.pose.heading = wrapped(best.pose.heading);
  return best;
}

void Matcher::take_near(const std::vector<Point>& points) {
  near_.clear();
  std::copy_if(points.begin(), points.end(), std::back_inserter(near_),
               [](const Point& point) { return std::hypot(point.x, point.y) <= kReach; });
}

Matcher::Match Matcher::match(const std::vector<Point>& points, const Window& window) {
  take_near(points);
  if (near_.empty()) return {expected_, 0.0};
  const Match coarse = best_of({expected_, window.offset, kCoarseStep, window.turn, kCoarseTurn}, false, window);
  return best_of({coarse.pose, kCoarseStep, kFineStep, kCoarseTurn, kFineTurn}, true, window);
}

Matcher::Match Matcher::refine(const std::vector<Point>& points, const Pose& around, const Window& window) {
  take_near(points);
  if (near_.empty()) return {around, 0.0};
  expected_ = around;
  return best_of({around, window.offset, kFineStep, window.turn, kFineTurn}, true, window);
}

}  // namespace ctn::navigation
