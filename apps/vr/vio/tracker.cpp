#include "vio/tracker.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include "vio/motion_vote.h"

namespace ctn::vr {
namespace {

constexpr int kMargin = 6;  // pixels at the edge in which there are no features
constexpr int kMaxSearchSteps = 20;
constexpr double kSettled = 0.01;     // pixels: an iteration that moves a feature by less is the last one
constexpr double kMinTexture = 1e-4;  // smaller eigenvalue of a window, over its area: it is lost below
constexpr int kCornerBlock = 5;       // side of the square in which a corner's gradients are added up

Eigen::Vector2d to_eigen(const cv::Point2f& pixel) {
  return {static_cast<double>(pixel.x), static_cast<double>(pixel.y)};
}

}  // namespace

Tracker::Tracker(const CameraModel& model, const TrackerSettings& settings) : model_(model), settings_(settings) {
  cv::setNumThreads(1);
}

bool Tracker::inside(const cv::Point2f& pixel) const {
  return pixel.x >= kMargin && pixel.y >= kMargin && pixel.x < static_cast<float>(model_.width - kMargin) &&
         pixel.y < static_cast<float>(model_.height - kMargin);
}

Tracker::Result Tracker::run(const CameraFrame& frame, const Eigen::Quaterniond& now_from_before, bool keyframe) {
  Result result;
  const bool usable =
      !frame.pyramid.empty() && frame.picture().cols == model_.width && frame.picture().rows == model_.height;
  if (!usable) {
    features_.clear();
    keyframe_.clear();
    return result;
  }
  now_from_keyframe_ = now_from_before * now_from_keyframe_;
  if (!features_.empty()) follow(frame, now_from_before, result);
  if (keyframe || keyframe_.empty()) start_from(frame, result);
  result.observations.reserve(features_.size());
  for (const Feature& feature : features_) {
    result.observations.push_back({feature.id, pinhole_point(model_, to_eigen(feature.pixel))});
  }
  return result;
}

void Tracker::follow(const CameraFrame& frame, const Eigen::Quaterniond& now_from_before, Result& result) {
  std::vector<cv::Point2f> before;
  std::vector<cv::Point2f> now;
  std::vector<Feature> followed;
  for (const Feature& feature : features_) {
    const Eigen::Vector3d turned = now_from_before * pinhole_point(model_, to_eigen(feature.pixel)).homogeneous();
    if (!(turned.z() > 0.1)) continue;
    const Eigen::Vector2d guess = pinhole_pixel(model_, turned.hnormalized());
    const cv::Point2f guessed(static_cast<float>(guess.x()), static_cast<float>(guess.y()));
    if (!inside(guessed)) continue;
    followed.push_back(feature);
    before.push_back(feature.in_keyframe);
    now.push_back(guessed);
  }
  features_.clear();
  if (followed.empty()) return;
  std::vector<unsigned char> found;
  std::vector<float> residual;
  cv::calcOpticalFlowPyrLK(keyframe_, frame.pyramid, before, now, found, residual, cv::Size(kWindow, kWindow),
                           kPyramidLevels - 1,
                           cv::TermCriteria(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, kMaxSearchSteps, kSettled),
                           cv::OPTFLOW_USE_INITIAL_FLOW, kMinTexture);
  result.work.windows += followed.size() * static_cast<std::size_t>(kPyramidLevels);

  std::vector<Eigen::Vector2d> points_before;
  std::vector<Eigen::Vector2d> points_now;
  std::vector<std::size_t> of_points;
  for (std::size_t i = 0; i < followed.size(); ++i) {
    if (found[i] == 0 || !inside(now[i]) || static_cast<double>(residual[i]) > settings_.max_residual) continue;
    points_before.push_back(pinhole_point(model_, to_eigen(before[i])));
    points_now.push_back(pinhole_point(model_, to_eigen(now[i])));
    of_points.push_back(i);
  }
  const MotionVote vote =
      vr::vote(points_before, points_now, now_from_keyframe_, settings_.vote_tolerance / model_.fx, next_id_);
  result.work += vote.work;
  std::vector<double> ways;
  for (std::size_t point = 0; point < of_points.size(); ++point) {
    if (vote.inlier[point] == 0) continue;
    const std::size_t i = of_points[point];
    // Two features that have run into one are one.
    const bool alone = std::none_of(features_.begin(), features_.end(), [&](const Feature& other) {
      const cv::Point2f difference = other.pixel - now[i];
      return difference.dot(difference) < 0.25F * static_cast<float>(settings_.min_distance * settings_.min_distance);
    });
    if (!alone) continue;
    features_.push_back({followed[i].id, now[i], before[i]});
    ways.push_back((to_eigen(now[i]) - to_eigen(before[i])).norm());
  }
  if (ways.empty()) return;
  const auto middle = ways.begin() + static_cast<std::ptrdiff_t>(ways.size() / 2);
  std::nth_element(ways.begin(), middle, ways.end());
  result.displacement = *middle;
}

void Tracker::start_from(const CameraFrame& keyframe, Result& result) {
  add_corners(keyframe, result);
  for (Feature& feature : features_) feature.in_keyframe = feature.pixel;
  keyframe_ = keyframe.pyramid;
  now_from_keyframe_.setIdentity();
}

void Tracker::add_corners(const CameraFrame& frame, Result& result) {
  const cv::Mat& picture = frame.picture();
  const int columns = std::max(1, model_.width / settings_.cell);
  const int rows = std::max(1, model_.height / settings_.cell);
  const auto index = [&](const cv::Point2f& pixel) {
    const int column = std::clamp(static_cast<int>(pixel.x) * columns / model_.width, 0, columns - 1);
    const int row = std::clamp(static_cast<int>(pixel.y) * rows / model_.height, 0, rows - 1);
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(column);
  };
  std::vector<int> filled(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows), 0);
  for (const Feature& feature : features_) ++filled[index(feature.pixel)];

  const cv::Rect whole(kMargin, kMargin, model_.width - 2 * kMargin, model_.height - 2 * kMargin);
  cv::Mat strength;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const std::size_t here =
          static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(column);
      const int missing = settings_.features_in_cell - filled[here];
      if (missing <= 0) continue;
      const cv::Point begin(column * model_.width / columns, row * model_.height / rows);
      const cv::Point end((column + 1) * model_.width / columns, (row + 1) * model_.height / rows);
      const cv::Rect cell = cv::Rect(begin, end) & whole;
      if (cell.area() <= 0) continue;
      cv::cornerMinEigenVal(picture(cell), strength, kCornerBlock);
      result.work.cornered += static_cast<std::size_t>(cell.area());
      for (const Feature& feature : features_) {
        const cv::Point at(cvRound(feature.pixel.x) - cell.x, cvRound(feature.pixel.y) - cell.y);
        cv::circle(strength, at, settings_.min_distance, cv::Scalar(0.0), cv::FILLED);
      }
      for (int i = 0; i < missing; ++i) {
        double best = 0.0;
        cv::Point at;
        cv::minMaxLoc(strength, nullptr, &best, nullptr, &at);
        if (!(best >= settings_.min_corner)) break;
        cv::circle(strength, at, settings_.min_distance, cv::Scalar(0.0), cv::FILLED);
        const cv::Point2f pixel(static_cast<float>(at.x + cell.x), static_cast<float>(at.y + cell.y));
        features_.push_back({next_id_++, pixel, pixel});
      }
    }
  }
}

}  // namespace ctn::vr
