#include "global_localizer.h"

#include <algorithm>
#include <cmath>

namespace ctn::navigation {
namespace {

constexpr std::size_t kRecent = 40;               // keyframes that a scan is matched against: the last dozen metres
constexpr Matcher::Window kTracking{0.04, 0.02};  // what odometry errs by, from one keyframe to the next
constexpr std::size_t kSameView = 5;              // keyframes from nearly the same pose that count
constexpr double kSameViewDistance = 0.25;
constexpr double kSameViewTurn = 0.25;
constexpr double kFits = 0.35;             // the lowest score of a match that is used
constexpr std::size_t kLoopLength = 40;    // the fewest keyframes of a loop
constexpr std::size_t kLoopPause = 4;      // keyframes between attempts to close one
constexpr double kLoopDistance = 3.0;      // how near the old keyframes must be
constexpr double kLoopTurn = 1.0;          // how nearly they must look the same way
constexpr std::size_t kLoopKeyframes = 7;  // that the scan is matched against

}  // namespace

GlobalLocalizer::GlobalLocalizer() : shared_(std::make_shared<const std::vector<Keyframe>>()) {}

bool GlobalLocalizer::tells_news(const Odometry& odometry) const {
  if (keyframes_.empty()) return true;
  const Pose moved = between(keyframes_.back().scan->odometry.pose, odometry.pose);
  return std::hypot(moved.x, moved.y) >= kKeyframeDistance || std::abs(moved.heading) >= kKeyframeTurn;
}

void GlobalLocalizer::match(const SharedScan& scan, Work& work) {
  const Pose expected = transformed(correction_, scan->odometry.pose);
  keyframes_.push_back({expected, scan});
  const std::size_t newest = keyframes_.size() - 1;
  draw_field(expected, newest);
  if (newest > 0) {
    const Pose& before = keyframes_[newest - 1].pose;
    PoseMatrix information = inverse(odometry_error_.covariance());
    const Matcher::Match found = matcher_.match(scan->points, {}, turned(information, before.heading));
    if (found.score >= kFits) {
      keyframes_[newest].pose = found.pose;
      information = information + turned(inverse(found.covariance), -before.heading);
    }
    constraints_.push_back({newest - 1, newest, between(before, keyframes_[newest].pose), information});
  }
  still_.add(keyframes_, work);
  matcher_.add(keyframes_[newest].pose, still_[newest]);
  work += matcher_.take_work();
  odometry_error_.start(scan->odometry.pose);
  outdate_oldest_like_newest(work);
  close_loop(work);
  correction_ = transformed(keyframes_.back().pose, inverse(scan->odometry.pose));
}

void GlobalLocalizer::draw_field(const Pose& pose, std::size_t end) {
  matcher_.start(pose);
  for (std::size_t i = end - std::min(kRecent, end); i < end; ++i) {
    if (distance(position(keyframes_[i].pose), position(pose)) > Matcher::kReach) continue;
    matcher_.add(keyframes_[i].pose, still_[i]);
  }
}

Pose GlobalLocalizer::tracked(const CleanScan& scan, Work& work) {
  const Pose expected = transformed(correction_, scan.odometry.pose);
  const PoseMatrix known = turned(inverse(odometry_error_.covariance()), keyframes_.back().pose.heading);
  const Matcher::Match found = matcher_.refine(scan.points, expected, kTracking, known);
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

std::optional<std::size_t> GlobalLocalizer::nearest_of_long_ago(Work& work) const {
  const Pose& here = keyframes_.back().pose;
  std::optional<std::size_t> nearest;
  double how_near = kLoopDistance;
  for (std::size_t i = 0; i + kLoopLength < keyframes_.size(); ++i) {
    const Pose& there = keyframes_[i].pose;
    const double away = distance(position(there), position(here));
    if (away >= how_near || std::abs(wrapped(there.heading - here.heading)) >= kLoopTurn) continue;
    nearest = i;
    how_near = away;
  }
  work.expanded += keyframes_.size();
  return nearest;
}

Sight GlobalLocalizer::sight(std::size_t keyframe) const {
  return {keyframes_[keyframe].pose, *keyframes_[keyframe].scan, still_[keyframe]};
}

void GlobalLocalizer::close_loop(Work& work) {
  const std::size_t newest = keyframes_.size() - 1;
  if (newest < kLoopLength || newest - last_loop_ < kLoopPause) return;
  const std::optional<std::size_t> old = nearest_of_long_ago(work);
  if (!old) return;

  last_loop_ = newest;
  std::vector<Pose> poses;
  poses.reserve(keyframes_.size());
  for (const Keyframe& keyframe : keyframes_) poses.push_back(keyframe.pose);
  const PoseMatrix drift = turned(covariance_between(poses, constraints_, *old, newest), poses[*old].heading);
  work.expanded += constraints_.size();
  std::vector<Sight> sights{sight(*old)};
  const std::size_t first = *old - std::min(*old, kLoopKeyframes / 2);
  for (std::size_t i = first; i < first + kLoopKeyframes && i < newest; ++i) {
    if (i != *old) sights.push_back(sight(i));
  }
  const std::optional<Recognised> found = recognise(sights, sight(newest), drift, work);
  if (!found) return;

  constraints_.push_back({*old, newest, between(poses[*old], found->pose),
                          turned(inverse(found->covariance), -poses[*old].heading), true});
  const Relaxed relaxed = relax(poses, constraints_);
  work.expanded += relaxed.steps * constraints_.size();
  for (std::size_t i = 0; i < poses.size(); ++i) keyframes_[i].pose = poses[i];
  ++loops_;
  draw_field(keyframes_.back().pose, keyframes_.size());
  work += matcher_.take_work();
}

GlobalLocalizer::Result GlobalLocalizer::run(const std::vector<SharedScan>& scans) {
  Result result;
  for (const SharedScan& scan : scans) {
    ++result.work.expanded;
    stamp_ = scan->stamp;
    odometry_error_.follow(scan->odometry.pose);
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
