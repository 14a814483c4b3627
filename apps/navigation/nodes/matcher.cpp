#include "matcher.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>

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
constexpr double kPointsPerFact = 2.0;  // neighbouring points err alike: so many tell as much as one that is alone
constexpr double kUnlikely = 10.0;      // of the logarithm: poses that are less likely by more do not count
// What every match may be off by, however sharp its peak: the earlier poses are not exact.
constexpr double kOffsetFloor = 0.01;
constexpr double kTurnFloor = 0.002;

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

double Matcher::judged(const Pose& pose, double score, const PoseMatrix& known) const {
  const Pose off{pose.x - expected_.x, pose.y - expected_.y, wrapped(pose.heading - expected_.heading)};
  return static_cast<double>(near_.size()) / kPointsPerFact * score - 0.5 * squared(known, off);
}

Matcher::Match Matcher::best_of(const Poses& poses, bool fine, const PoseMatrix& known) {
  const Pose& centre = poses.centre;
  const int offsets = steps_to_each_side(poses.offset, poses.offset_step);
  const int turns = steps_to_each_side(poses.turn, poses.turn_step);
  scores_.clear();
  Match best;
  double most_likely = -std::numeric_limits<double>::infinity();
  for (int k = -turns; k <= turns; ++k) {
    const double heading = centre.heading + k * poses.turn_step;
    turn_points(heading);
    for (int j = -offsets; j <= offsets; ++j) {
      for (int i = -offsets; i <= offsets; ++i) {
        const Pose pose{centre.x + i * poses.offset_step, centre.y + j * poses.offset_step, heading};
        const double score = fine ? fine_score(pose.x, pose.y) : coarse_score(pose.x, pose.y);
        scores_.push_back(static_cast<float>(score));
        const double likely = judged(pose, score, known);
        if (likely <= most_likely) continue;
        most_likely = likely;
        best.pose = pose;
        best.score = score;
      }
    }
  }
  const std::uint64_t side = 2 * static_cast<std::uint64_t>(offsets) + 1;
  const std::uint64_t lookups = side * side * (2 * static_cast<std::uint64_t>(turns) + 1) * near_.size();
  work_.candidates += fine ? kCellsInterpolated * lookups : lookups;
  best.pose.heading = wrapped(best.pose.heading);
  return best;
}

Matcher::Match Matcher::polished(Match match, const PoseMatrix& known) {
  constexpr int kRounds = 2;  // an offset and a turn may make up for one another
  const auto judge = [&](const Pose& pose) {
    turn_points(pose.heading);
    match.score = fine_score(pose.x, pose.y);
    work_.candidates += kCellsInterpolated * near_.size();
    return judged(pose, match.score, known);
  };
  double likely = judge(match.pose);
  const auto move = [&](double Pose::*axis, double step) {
    Pose before = match.pose;
    Pose after = match.pose;
    before.*axis -= step;
    after.*axis += step;
    const double falls_before = likely - judge(before);
    const double falls_after = likely - judge(after);
    const double curvature = falls_before + falls_after;
    if (curvature <= 0.0) return;
    Pose peak = match.pose;
    peak.*axis += step * std::clamp(0.5 * (falls_before - falls_after) / curvature, -1.0, 1.0);
    const double at_peak = judge(peak);
    if (at_peak <= likely) return;
    likely = at_peak;
    match.pose = peak;
  };
  for (int round = 0; round < kRounds; ++round) {
    move(&Pose::heading, kFineTurn);
    move(&Pose::x, kFineStep);
    move(&Pose::y, kFineStep);
  }
  judge(match.pose);
  match.pose.heading = wrapped(match.pose.heading);
  return match;
}

PoseMatrix Matcher::spread_of(const Poses& poses) const {
  const int offsets = steps_to_each_side(poses.offset, poses.offset_step);
  const int turns = steps_to_each_side(poses.turn, poses.turn_step);
  const double facts = static_cast<double>(near_.size()) / kPointsPerFact;
  const auto best = static_cast<double>(*std::max_element(scores_.begin(), scores_.end()));
  double sum = 0.0;
  Pose mean;
  PoseMatrix squares;
  std::size_t at = 0;
  for (int k = -turns; k <= turns; ++k) {
    for (int j = -offsets; j <= offsets; ++j) {
      for (int i = -offsets; i <= offsets; ++i) {
        const double less_likely = facts * (best - static_cast<double>(scores_[at++]));
        if (less_likely > kUnlikely) continue;
        const double weight = std::exp(-less_likely);
        const Pose off{i * poses.offset_step, j * poses.offset_step, k * poses.turn_step};
        sum += weight;
        mean = {mean.x + weight * off.x, mean.y + weight * off.y, mean.heading + weight * off.heading};
        squares = squares + PoseMatrix{weight * off.x * off.x,       weight * off.x * off.y,
                                       weight * off.x * off.heading, weight * off.y * off.y,
                                       weight * off.y * off.heading, weight * off.heading * off.heading};
      }
    }
  }
  mean = {mean.x / sum, mean.y / sum, mean.heading / sum};
  return {squares.xx / sum - mean.x * mean.x,       squares.xy / sum - mean.x * mean.y,
          squares.xh / sum - mean.x * mean.heading, squares.yy / sum - mean.y * mean.y,
          squares.yh / sum - mean.y * mean.heading, squares.hh / sum - mean.heading * mean.heading};
}

void Matcher::take_near(const std::vector<Point>& points) {
  near_.clear();
  std::copy_if(points.begin(), points.end(), std::back_inserter(near_),
               [](const Point& point) { return std::hypot(point.x, point.y) <= kReach; });
}

Matcher::Match Matcher::match(const std::vector<Point>& points, const Window& window, const PoseMatrix& known) {
  take_near(points);
  if (near_.empty()) return {expected_, 0.0, {}};
  const Poses all{expected_, window.offset, kCoarseStep, window.turn, kCoarseTurn};
  const Match coarse = best_of(all, false, known);
  const PoseMatrix places = spread_of(all);
  const Poses around{coarse.pose, kCoarseStep, kFineStep, kCoarseTurn, kFineTurn};
  Match fine = best_of(around, true, known);
  fine.covariance = places + spread_of(around) + covariance_of(kOffsetFloor, kOffsetFloor, kTurnFloor);
  return polished(fine, known);
}

Matcher::Match Matcher::refine(const std::vector<Point>& points, const Pose& around, const Window& window,
                               const PoseMatrix& known) {
  take_near(points);
  if (near_.empty()) return {around, 0.0, {}};
  expected_ = around;
  const Poses all{around, window.offset, kFineStep, window.turn, kFineTurn};
  Match fine = best_of(all, true, known);
  fine.covariance = spread_of(all) + covariance_of(kOffsetFloor, kOffsetFloor, kTurnFloor);
  return polished(fine, known);
}

}  // namespace ctn::navigation
