#include "motion_tracker.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "robot.h"

namespace ctn::navigation {
namespace {

constexpr double kGap = 0.12;             // between neighbouring hits of one thing
constexpr double kMinChord = 0.1;         // the direction of a shorter line between the ends says nothing
constexpr double kFreshShare = 0.1;       // of a segment that begins a track
constexpr std::size_t kMinFresh = 3;      // beams
constexpr double kPlaceNoise = 0.015;     // standard deviation of a place that is near
constexpr double kPlaceNoiseFar = 0.008;  // more, per metre
constexpr double kNoiseIfHidden = 4.0;
constexpr double kNoiseOfRadius = 15.0;
constexpr double kAgility = 0.15;    // m^2/s^3: by so much the variance of a velocity grows in a second
constexpr double kFirstSpeed = 0.7;  // m/s: standard deviation of a velocity that is not known yet
constexpr double kGate = 0.3;        // how far from where it should be it is looked for
constexpr double kGateSpeed = 0.5;   // m/s: more, for each second since it was seen
constexpr double kWider = 0.35;      // a segment by so much wider than the track is something else
constexpr double kMinFace = 0.15;    // of a box, of which the rest is hidden, to tell which way it lies
constexpr double kMaxBehind = std::numbers::pi / 4.0;  // place_of_hidden()
constexpr double kMinRadius = 0.12;                    // what is smaller is noise
constexpr double kMaxSpeed = 1.5;                      // m/s: what seems to be faster was mistaken for something else
constexpr double kRadiusGain = 0.1;                    // of what is seen anew
constexpr int kMinUpdates = 3;                         // before a track counts
constexpr double kMoved = 0.06;                        // since it was seen first
constexpr double kSureSpeed = 0.2;                     // m/s
constexpr double kSure = 1.5;                          // standard deviations
constexpr double kPaceTime = 0.3;                      // seconds in which a higher speed is believed
constexpr double kPaceFade = 0.02;                     // m/s for each second
constexpr double kGoneFor = 0.3;                       // seconds for which its place was looked through
constexpr double kCourseShare = 0.7;                   // of its pace: what is slower does not tell its course
constexpr double kSameLine = 0.9;                      // cosine of the angle between courses on one line
constexpr double kSameEnd = 0.3;                       // metres
constexpr double kKeepsToLine = 0.5;                   // seconds of going along a line
constexpr double kBesideShare = 0.2;                   // of how far beside its line a hidden thing seems to be
constexpr double kLineTime = 1.0;                      // seconds in which a line turns to where a thing goes

double length_of(Point point) { return std::hypot(point.x, point.y); }

double dot(Point a, Point b) { return a.x * b.x + a.y * b.y; }

}  // namespace

double MotionTracker::Track::along() const { return dot(centre - born, line); }

bool MotionTracker::Track::goes_up() const { return dot(course, line) > 0.0; }

bool MotionTracker::Track::keeps_to_line() const { return on_line >= kKeepsToLine; }

std::vector<MotionTracker::Segment> MotionTracker::segments_of(const CleanScan& scan, const std::vector<Hit>& hits) {
  const Pose& pose = scan.odometry.pose;
  const auto near = [&](std::size_t beam) { return static_cast<double>(scan.ranges[beam]) <= kView; };
  const auto hit = [&](std::size_t beam) {
    const double angle = pose.heading + scan.angle(beam);
    const auto range = static_cast<double>(scan.ranges[beam]);
    return Point{pose.x + range * std::cos(angle), pose.y + range * std::sin(angle)};
  };
  std::vector<Segment> segments;
  std::vector<Point> points;
  for (std::size_t begin = 0; begin < scan.ranges.size();) {
    if (!near(begin)) {
      ++begin;
      continue;
    }
    points.assign(1, hit(begin));
    std::size_t end = begin + 1;
    for (; end < scan.ranges.size() && near(end); ++end) {
      const Point next = hit(end);
      if (distance(next, points.back()) > kGap) break;
      points.push_back(next);
    }
    Segment segment;
    segment.right = points.front();
    segment.left = points.back();
    segment.beams = points.size();
    const double width = distance(segment.right, segment.left);
    if (segment.beams >= kMinBeams && width <= kMaxWidth) {
      segment.right_hidden = begin == 0 || scan.ranges[begin - 1] < scan.ranges[begin];
      segment.left_hidden = end == scan.ranges.size() || scan.ranges[end] < scan.ranges[end - 1];
      for (std::size_t beam = begin; beam < end; ++beam) {
        segment.fresh += hits[beam] == Hit::kFresh ? 1 : 0;
        segment.old += hits[beam] == Hit::kOld ? 1 : 0;
      }
      if (width >= kMinChord) {
        // From the right end to the left one the robot is on the left.
        const Point along = (segment.left - segment.right) * (1.0 / width);
        for (const Point& point : points) {
          const Point from = point - segment.right;
          segment.bulge = std::max(segment.bulge, along.x * from.y - along.y * from.x);
        }
      }
      segments.push_back(segment);
    }
    begin = end;
  }
  return segments;
}

MotionTracker::Place MotionTracker::place_of(const Segment& segment, Point robot) {
  const Point middle = (segment.right + segment.left) * 0.5;
  const double width = distance(segment.right, segment.left);
  Point away;
  if (width >= kMinChord) {
    const Point along = (segment.left - segment.right) * (1.0 / width);
    away = {along.y, -along.x};
  } else {
    away = (middle - robot) * (1.0 / std::max(1e-6, distance(middle, robot)));
  }
  const double behind = std::max(0.0, width / 2.0 - segment.bulge);
  return {middle + away * behind, std::hypot(width / 2.0, behind)};
}

MotionTracker::Place MotionTracker::place_of_hidden(const Segment& segment, Point robot, Point expected,
                                                    double radius) {
  const Point end = segment.right_hidden ? segment.left : segment.right;
  const Point other = segment.right_hidden ? segment.right : segment.left;
  const double side = segment.right_hidden ? -1.0 : 1.0;  // on which of the beam to the end the rest is: left is 1
  const double width = distance(end, other);
  if (width >= kMinFace) {
    const Point along = (other - end) * (1.0 / width);
    const Point away{side * along.y, -side * along.x};
    return {end + (along + away) * (radius / std::numbers::sqrt2), radius};
  }
  const Point ray = (end - robot) * (1.0 / std::max(1e-6, distance(end, robot)));
  const Point aside{-side * ray.y, side * ray.x};
  const Point from = expected - end;
  const double behind = std::atan2(from.x * ray.x + from.y * ray.y, from.x * aside.x + from.y * aside.y);
  const double angle = std::clamp(behind, -kMaxBehind, kMaxBehind);
  return {end + (aside * std::cos(angle) + ray * std::sin(angle)) * radius, radius};
}

void MotionTracker::predict(Track& track, double seconds) {
  track.centre = track.centre + track.velocity * seconds;
  const double more = kAgility * seconds;
  track.variance_place +=
      2.0 * track.covariance * seconds + track.variance_velocity * seconds * seconds + more * seconds * seconds / 3.0;
  track.covariance += track.variance_velocity * seconds + more * seconds / 2.0;
  track.variance_velocity += more;
}

void MotionTracker::update(Track& track, const Place& place, bool hidden, double range) {
  // Another radius than before: a part of it was missed.
  const double doubt = 1.0 + kNoiseOfRadius * std::abs(place.radius / track.radius - 1.0);
  const double noise = (kPlaceNoise + kPlaceNoiseFar * range) * doubt * (hidden ? kNoiseIfHidden : 1.0);
  const double total = track.variance_place + noise * noise;
  const double gain_place = track.variance_place / total;
  const double gain_velocity = track.covariance / total;
  const Point off = place.centre - track.centre;
  if (hidden && track.keeps_to_line()) {
    const Point along = track.line * dot(off, track.line);
    track.centre = track.centre + (along + (off - along) * kBesideShare) * gain_place;
    track.velocity = track.line * dot(track.velocity, track.line) + along * gain_velocity;
  } else {
    track.centre = track.centre + off * gain_place;
    track.velocity = track.velocity + off * gain_velocity;
  }
  track.variance_velocity -= gain_velocity * track.covariance;
  track.covariance *= 1.0 - gain_place;
  track.variance_place *= 1.0 - gain_place;
  ++track.updates;
}

// Whether the laser sees something beyond the place, which it should not.
bool MotionTracker::seen_through(const Track& track, const CleanScan& scan) {
  const Point from = transformed(inverse(scan.odometry.pose), track.centre);
  const double range = length_of(from);
  const double share = std::atan2(from.y, from.x) / scan.field + 0.5;
  if (share < 0.0 || share > 1.0 || scan.ranges.empty()) return false;
  const auto beam = static_cast<std::size_t>(std::lround(share * static_cast<double>(scan.ranges.size() - 1)));
  return static_cast<double>(scan.ranges[beam]) > range + track.radius;
}

// It went along `course`, of length one, for so long.
void MotionTracker::learn_course(Track& track, Point course, double seconds) {
  double cosine = dot(course, track.line);
  if (std::abs(cosine) < kSameLine) {
    cosine = 1.0;
    track.line = course;
    track.low.reset();
    track.high.reset();
    track.farthest = track.along();
    track.on_line = 0.0;
  } else if (dot(course, track.course) < 0.0) {  // it turned back
    (cosine > 0.0 ? track.low : track.high) = track.farthest;
    track.farthest = track.along();
  }
  track.course = course;
  track.on_line += seconds;
  const Point turned =
      track.line + (course * (cosine < 0.0 ? -1.0 : 1.0) - track.line) * std::min(1.0, seconds / kLineTime);
  track.line = turned * (1.0 / length_of(turned));
}

// It was seen where it is.
void MotionTracker::learn_place(Track& track) {
  const double along = track.along();
  if (track.goes_up()) {
    track.farthest = std::max(track.farthest, along);
    if (track.high && along > *track.high + kSameEnd) track.high.reset();
  } else {
    track.farthest = std::min(track.farthest, along);
    if (track.low && along < *track.low - kSameEnd) track.low.reset();
  }
}

// What is not seen waits where its course ends.
void MotionTracker::stop_at_end(Track& track) {
  const double speed = dot(track.velocity, track.line);
  const std::optional<double>& end = speed > 0.0 ? track.high : track.low;
  if (!end) return;
  const double beyond = track.along() - *end;
  if (beyond * speed <= 0.0) return;
  track.centre = track.centre - track.line * beyond;
  track.velocity = {};
}

void MotionTracker::follow(std::vector<Segment>& segments, const CleanScan& scan, double seconds) {
  const Point robot = position(scan.odometry.pose);
  for (Track& track : tracks_) {
    predict(track, seconds);
    Segment* nearest = nullptr;
    Place found{};
    double off = kGate + kGateSpeed * (track.unseen + seconds);
    for (Segment& segment : segments) {
      if (!segment.tells()) continue;
      const bool hidden = segment.right_hidden || segment.left_hidden;
      const Place place =
          hidden ? place_of_hidden(segment, robot, track.centre, track.radius) : place_of(segment, robot);
      if (distance(segment.right, segment.left) > 2.0 * track.radius + kWider) continue;
      const double apart = distance(place.centre, track.centre);
      if (apart >= off) continue;
      off = apart;
      nearest = &segment;
      found = place;
    }
    if (nearest == nullptr) {
      track.unseen += seconds;
      if (length_of(track.velocity) < kSlowest) track.velocity = {};
      if (track.confirmed) stop_at_end(track);
      continue;
    }
    nearest->used = true;
    track.unseen = 0.0;
    update(track, found, nearest->right_hidden || nearest->left_hidden, distance(found.centre, robot));
    track.radius += kRadiusGain * (found.radius - track.radius);
  }
}

MovingObstacle MotionTracker::as_obstacle(const Track& track) {
  // Its velocity says little of its course while it slows down.
  const Point course = track.keeps_to_line() ? track.line * (track.goes_up() ? 1.0 : -1.0) : track.course;
  MovingObstacle thing{track.centre, track.radius, {}, course, track.pace};
  thing.unseen = track.unseen;
  const double speed = length_of(track.velocity);
  if (speed >= kSlowest) {
    thing.velocity = track.velocity;
    if (dot(track.velocity, course) < 0.0) thing.course = course * -1.0;
    const double on_line = dot(track.velocity, track.line);
    if (std::abs(on_line) < kSameLine * speed) return thing;
    if (track.keeps_to_line()) thing.velocity = track.line * on_line;
  }
  const double along = track.along();
  const bool up = dot(thing.course, track.line) > 0.0;
  const std::optional<double>& ahead = up ? track.high : track.low;
  const std::optional<double>& behind = up ? track.low : track.high;
  if (ahead) thing.ahead = std::max(0.0, up ? *ahead - along : along - *ahead);
  if (behind) thing.behind = std::max(0.0, up ? along - *behind : *behind - along);
  return thing;
}

std::vector<MovingObstacle> MotionTracker::run(const CleanScan& scan, const std::vector<Hit>& hits, Work& work) {
  const double seconds = began_ ? std::max(0.0, std::chrono::duration<double>(scan.stamp - stamp_).count()) : 0.0;
  stamp_ = began_ ? std::max(stamp_, scan.stamp) : scan.stamp;
  began_ = true;
  work.beams += scan.ranges.size();
  std::vector<Segment> segments = segments_of(scan, hits);
  follow(segments, scan, seconds);

  const Point robot = position(scan.odometry.pose);
  for (const Segment& segment : segments) {
    if (!segment.tells()) continue;
    if (segment.fresh < kMinFresh ||
        static_cast<double>(segment.fresh) < kFreshShare * static_cast<double>(segment.beams))
      continue;
    Place place = place_of(segment, robot);
    if (segment.right_hidden || segment.left_hidden) {
      const double radius = std::max(place.radius, kOuterRadius);
      place = place_of_hidden(segment, robot, place.centre, radius);
    }
    if (place.radius < kMinRadius) continue;
    const double noise = kPlaceNoise + kPlaceNoiseFar * distance(place.centre, robot);
    Track track;
    track.centre = track.born = place.centre;
    track.variance_place = noise * noise;
    track.variance_velocity = kFirstSpeed * kFirstSpeed;
    track.radius = place.radius;
    track.updates = 1;
    tracks_.push_back(track);
  }

  for (Track& track : tracks_) {
    const double speed = length_of(track.velocity);
    if (!track.confirmed && track.updates >= kMinUpdates && distance(track.centre, track.born) >= kMoved &&
        speed >= kSureSpeed && speed >= kSure * std::sqrt(track.variance_velocity)) {
      track.confirmed = true;
    }
    track.stopped = speed < kSlowest ? track.stopped + seconds : 0.0;
    track.pace = std::max(0.0, track.pace - kPaceFade * seconds);
    if (!track.confirmed || track.unseen > 0.0) continue;
    learn_place(track);
    if (speed < kSlowest) continue;
    track.pace += std::max(0.0, speed - track.pace) * std::min(1.0, seconds / kPaceTime);
    if (speed < kCourseShare * track.pace) continue;
    learn_course(track, track.velocity * (1.0 / speed), seconds);
  }
  std::erase_if(tracks_, [&](const Track& track) {
    const bool comes = dot(robot - track.centre, track.velocity) > 0.0;
    if (length_of(track.velocity) > kMaxSpeed || track.unseen > (comes ? kUnseenComing : kUnseen) ||
        track.stopped > (track.confirmed ? kStopped : 1.0))
      return true;
    return track.unseen > kGoneFor && seen_through(track, scan);
  });

  std::vector<MovingObstacle> moving;
  for (const Track& track : tracks_) {
    if (!track.confirmed) continue;
    moving.push_back(as_obstacle(track));
  }
  return moving;
}

}  // namespace ctn::navigation
