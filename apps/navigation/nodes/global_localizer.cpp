#include "global_localizer.h"

#include <algorithm>
#include <cmath>

namespace ctn::navigation {
namespace {

constexpr std::size_t kRecent = 30;               // keyframes that a scan is matched against: the last dozen metres
constexpr Matcher::Window kTracking{0.04, 0.02};  // what odometry errs by, from one keyframe to the next
constexpr std::size_t kSameView = 5;              // keyframes from nearly the same pose that count
constexpr double kSameViewDistance = 0.25;
constexpr double kSameViewTurn = 0.25;
constexpr double kFits = 0.35;             // the lowest score of a match that is used
constexpr std::size_t kLoopLength = 40;    // the fewest keyframes of a loop
constexpr std::size_t kLoopPause = 8;      // keyframes between attempts to close one
constexpr double kLoopDistance = 3.0;      // how near the old keyframes must be
constexpr std::size_t kLoopKeyframes = 7;  // that the scan is matched against
constexpr double kLoopFits = 0.6;
constexpr Matcher::Window kLoopWindow{0.8, 0.15};  // a heading drifts less, and a wrong one bends the whole map

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
  draw_field(expected);
  if (!keyframes_.empty()) {
    const Matcher::Match found = matcher_.match(scan->points, {});
    if (found.score >= kFits) pose = found.pose;
    constraints_.push_back({keyframes_.size() - 1, keyframes_.size(), between(keyframes_.back().pose, pose), 1.0});
  }
  keyframes_.push_back({pose, scan});
  matcher_.add(pose, scan->points);
  work += matcher_.take_work();
  outdate_oldest_like_newest(work);
  close_loop(work);
  correction_ = transformed(keyframes_.back().pose, inverse(scan->odometry.pose));
}

void GlobalLocalizer::draw_field(const Pose& pose) {
  matcher_.start(pose);
  const std::size_t first = keyframes_.size() - std::min(kRecent, keyframes_.size());
  for (std::size_t i = first; i < keyframes_.size(); ++i) {
    if (distance(position(keyframes_[i].pose), position(pose)) > Matcher::kReach) continue;
    matcher_.add(keyframes_[i].pose, keyframes_[i].scan->points);
  }
}

Pose GlobalLocalizer::tracked(const CleanScan& scan, Work& work) {
  const Pose expected = transformed(correction_, scan.odometry.pose);
  const Matcher::Match found = matcher_.refine(scan.points, expected, kTracking);
  work += matcher_.take_work();
  return transformed(found.score >= kFits ? found.pose : expected, inverse(scan.odometry.pose));
}

void GlobalLocalizer::outdate_oldest_like_newest(Work& work) {
  const Pose& newest = keyframes_.back().pose;
  std::size_t alike = 0;
  Keyframe* oldest = nullptr;
  for (Keyframe& keyframe : keyframes_) {
    if (keyframe.outdated || distance(position(keyframe.pose), position(newest)) > kSameViewDistance ||
        std::abs(wrapped(keyframe.pose.heading - newest.heading)) > kSameViewTurn) {
      continue;
    }
    if (oldest == nullptr) oldest = &keyframe;
    ++alike;
  }
  if (alike > kSameView) oldest->outdated = true;
  work.expanded += keyframes_.size();
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
  Matcher matcher;
  matcher.start(keyframes_[newest].pose);
  const std::size_t first = nearest - std::min(nearest, kLoopKeyframes / 2);
  for (std::size_t i = first; i < first + kLoopKeyframes && i < newest; ++i) {
    matcher.add(keyframes_[i].pose, keyframes_[i].scan->points);
  }
  const Matcher::Match found = matcher.match(keyframes_[newest].scan->points, kLoopWindow);
  work += matcher.take_work();
  if (found.score < kLoopFits) return;

  constraints_.push_back({nearest, newest, between(keyframes_[nearest].pose, found.pose), 4.0});
  std::vector<Pose> poses;
  poses.reserve(keyframes_.size());
  for (const Keyframe& keyframe : keyframes_) poses.push_back(keyframe.pose);
  relax(poses, constraints_);
  for (std::size_t i = 0; i < poses.size(); ++i) keyframes_[i].pose = poses[i];
  work.expanded += 10 * poses.size();
  ++loops_;
  draw_field(keyframes_.back().pose);
  work += matcher_.take_work();
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
  if (result.mode == Mode::kSkip && !scans.empty()) tracked_ = tracked(*scans.back(), result.work);
  if (result.mode == Mode::kMatch) tracked_ = correction_;
  result.localization = {stamp_, tracked_, shared_, loops_, scans.empty() ? newest_ : scans.back()};
  newest_ = result.localization.newest;
  return result;
}

}  // namespace ctn::navigation
