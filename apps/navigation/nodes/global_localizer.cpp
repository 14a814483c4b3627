#include "global_localizer.h"

#include <algorithm>
#include <cmath>

namespace ctn::navigation {
namespace {

constexpr std::size_t kRecent = 15;        // keyframes that a scan is matched against
constexpr double kFits = 0.35;             // the lowest score of a match that is used
constexpr std::size_t kLoopLength = 40;    // the fewest keyframes of a loop
constexpr std::size_t kLoopPause = 8;      // keyframes between attempts to close one
constexpr double kLoopDistance = 3.0;      // how near the old keyframes must be
constexpr std::size_t kLoopKeyframes = 7;  // that the scan is matched against
constexpr double kLoopFits = 0.55;
constexpr Matcher::Window kLoopWindow{0.8, 0.3};

}  // namespace

GlobalLocalizer::GlobalLocalizer() : shared_(std::make_shared<const std::vector<Keyframe>>()) {}

bool GlobalLocalizer::tells_news(const Odometry& odometry) const {
  if (keyframes_.empty()) return true;
  const Pose moved = between(keyframes_.back().scan->odometry.pose, odometry.pose);
  return std::hypot(moved.x, moved.y) >= kKeyframeDistance || std::abs(moved.heading) >= kKeyframeTurn;
}

void GlobalLocalizer::match(const SharedScan& scan, Work& work) {
  const Pose expected = transformed(correction_, scan->odometry.pose);
  Pose pose = expected;
  if (!keyframes_.empty()) {
    matcher_.start(expected);
    const std::size_t first = keyframes_.size() - std::min(kRecent, keyframes_.size());
    for (std::size_t i = first; i < keyframes_.size(); ++i) {
      if (distance(position(keyframes_[i].pose), position(expected)) > Matcher::kReach) continue;
      matcher_.add(keyframes_[i].pose, keyframes_[i].scan->points);
    }
    const Matcher::Match found = matcher_.match(scan->points, {});
    if (found.score >= kFits) pose = found.pose;
    work += matcher_.work();
    constraints_.push_back({keyframes_.size() - 1, keyframes_.size(), between(keyframes_.back().pose, pose), 1.0});
  }
  keyframes_.push_back({pose, scan});
  close_loop(work);
  correction_ = transformed(keyframes_.back().pose, inverse(scan->odometry.pose));
}

void GlobalLocalizer::close_loop(Work& work) {
  const std::size_t newest = keyframes_.size() - 1;
  if (newest < kLoopLength || newest - last_loop_ < kLoopPause) return;
  const Point here = position(keyframes_[newest].pose);
  std::size_t nearest = 0;
  double how_near = kLoopDistance;
  for (std::size_t i = 0; i + kLoopLength <= newest; ++i) {
    const double away = distance(position(keyframes_[i].pose), here);
    const bool same_view = std::abs(wrapped(keyframes_[i].pose.heading - keyframes_[newest].pose.heading)) < 1.0;
    if (away >= how_near || !same_view) continue;
    nearest = i;
    how_near = away;
  }
  work.expanded += newest;
  if (how_near >= kLoopDistance) return;

  last_loop_ = newest;
  matcher_.start(keyframes_[newest].pose);
  const std::size_t first = nearest - std::min(nearest, kLoopKeyframes / 2);
  for (std::size_t i = first; i < first + kLoopKeyframes && i < newest; ++i) {
    matcher_.add(keyframes_[i].pose, keyframes_[i].scan->points);
  }
  const Matcher::Match found = matcher_.match(keyframes_[newest].scan->points, kLoopWindow);
  work += matcher_.work();
  if (found.score < kLoopFits) return;

  constraints_.push_back({nearest, newest, between(keyframes_[nearest].pose, found.pose), 4.0});
  std::vector<Pose> poses;
  poses.reserve(keyframes_.size());
  for (const Keyframe& keyframe : keyframes_) poses.push_back(keyframe.pose);
  relax(poses, constraints_);
  for (std::size_t i = 0; i < poses.size(); ++i) keyframes_[i].pose = poses[i];
  work.expanded += 10 * poses.size();
  ++loops_;
}

GlobalLocalizer::Result GlobalLocalizer::run(const std::vector<SharedScan>& scans) {
  Result result;
  for (const SharedScan& scan : scans) {
    ++result.work.expanded;
    stamp_ = scan->stamp;
    if (!tells_news(scan->odometry)) continue;
    match(scan, result.work);
    result.news = true;
    result.mode = Mode::kMatch;
  }
  if (result.news) shared_ = std::make_shared<const std::vector<Keyframe>>(keyframes_);
  result.localization = {stamp_, correction_, shared_, loops_};
  return result;
}

}  // namespace ctn::navigation
