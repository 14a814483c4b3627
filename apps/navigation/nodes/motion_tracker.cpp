#include "motion_tracker.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace ctn::navigation {
namespace {

constexpr double kGap = 0.12;             // between neighbouring hits of one thing
constexpr double kMinChord = 0.1;         // the direction of a shorter line between the ends says nothing
constexpr double kFreshShare = 0.1;       // of a segment that begins a track
constexpr std::size_t kMinFresh = 3;      // beams
constexpr double kPlaceNoise = 0.015;     // standard deviation of a place that is near
constexpr double kPlaceNoiseFar = 0.008;  // more, per metre
constexpr double kAgility = 0.15;         // m^2/s^3: by so much the variance of a velocity grows in a second
constexpr double kFirstSpeed = 0.7;       // m/s: standard deviation of a velocity that is not known yet
constexpr double kGate = 0.3;             // how far from where it should be it is looked for
constexpr double kGateSpeed = 1.0;        // m/s: more, for each second since it was seen
constexpr double kWider = 0.35;           // a segment by so much wider than the track is something else
constexpr int kMinUpdates = 3;            // before a track counts
constexpr double kMoved = 0.06;           // since it was seen first
constexpr double kSureSpeed = 0.2;        // m/s
constexpr double kSure = 1.5;             // standard deviations
constexpr double kPaceTime = 0.3;         // seconds in which a higher speed is believed
constexpr double kPaceFade = 0.05;        // m/s for each second
constexpr double kGoneFor = 0.3;          // seconds for which its place was looked through

double length_of(Point point) { return std::hypot(point.x, point.y); }

}  // namespace

std::vector<MotionTracker::Segment> MotionTracker::segments_of(const CleanScan& scan, const std::vector<char>& fresh) {
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
      segment.fresh = static_cast<std::size_t>(std::count(fresh.begin() + static_cast<std::ptrdiff_t>(begin),
                                                          fresh.begin() + static_cast<std::ptrdiff_t>(end), 1));
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

MotionTracker::Place MotionTracker::place_of(const Segment& segment, Point robot, double known_width) {
  Point right = segment.right;
  Point left = segment.left;
  double width = distance(right, left);
  Point along;
  if (width >= kMinChord) {
    along = (left - right) * (1.0 / width);
  } else {
    const Point middle = (right + left) * 0.5;
    const double range = std::max(1e-6, distance(middle, robot));
    const Point away = (middle - robot) * (1.0 / range);
    along = {-away.y, away.x};
  }
  if (segment.right_hidden != segment.left_hidden && width < known_width) {
    width = known_width;
    if (segment.left_hidden) {
      left = right + along * width;
    } else {
      right = left - along * width;
    }
  }
  const Point away{along.y, -along.x};
  const double behind = std::max(0.0, width / 2.0 - segment.bulge);
  return {(right + left) * 0.5 + away * behind, std::hypot(width / 2.0, behind), width};
}

void MotionTracker::predict(Track& track, double seconds) {
  track.centre = track.centre + track.velocity * seconds;
  const double more = kAgility * seconds;
  track.variance_place +=
      2.0 * track.covariance * seconds + track.variance_velocity * seconds * seconds + more * seconds * seconds / 3.0;
  track.covariance += track.variance_velocity * seconds + more * seconds / 2.0;
  track.variance_velocity += more;
}

void MotionTracker::update(Track& track, const Place& place, double range) {
  const double noise = kPlaceNoise + kPlaceNoiseFar * range;
  const double total = track.variance_place + noise * noise;
  const double gain_place = track.variance_place / total;
  const double gain_velocity = track.covariance / total;
  const Point off = place.centre - track.centre;
  track.centre = track.centre + off * gain_place;
  track.velocity = track.velocity + off * gain_velocity;
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

void MotionTracker::follow(std::vector<Segment>& segments, const CleanScan& scan, double seconds) {
  const Point robot = position(scan.odometry.pose);
  for (Track& track : tracks_) {
    predict(track, seconds);
    Segment* nearest = nullptr;
    Place found{};
    double off = kGate + kGateSpeed * (track.unseen + seconds);
    for (Segment& segment : segments) {
      if (segment.used || (segment.right_hidden && segment.left_hidden)) continue;
      const Place place = place_of(segment, robot, track.width);
      if (place.width > track.width + kWider) continue;
      const double apart = distance(place.centre, track.centre);
      if (apart >= off) continue;
      off = apart;
      nearest = &segment;
      found = place;
    }
    if (nearest == nullptr) {
      track.unseen += seconds;
      continue;
    }
    nearest->used = true;
    track.unseen = 0.0;
    update(track, found, distance(found.centre, robot));
    // Larger at once, smaller slowly: what hides a part of it is not always noticed.
    const auto towards = [](double value, double seen) { return seen > value ? seen : value + 0.02 * (seen - value); };
    track.width = towards(track.width, found.width);
    track.radius = towards(track.radius, found.radius);
  }
}

std::vector<MovingObstacle> MotionTracker::run(const CleanScan& scan, const std::vector<char>& fresh, Work& work) {
  const double seconds = began_ ? std::max(0.0, std::chrono::duration<double>(scan.stamp - stamp_).count()) : 0.0;
  stamp_ = began_ ? std::max(stamp_, scan.stamp) : scan.stamp;
  began_ = true;
  work.beams += scan.ranges.size();
  std::vector<Segment> segments = segments_of(scan, fresh);
  follow(segments, scan, seconds);

  const Point robot = position(scan.odometry.pose);
  for (const Segment& segment : segments) {
    if (segment.used || (segment.right_hidden && segment.left_hidden)) continue;
    if (segment.fresh < kMinFresh ||
        static_cast<double>(segment.fresh) < kFreshShare * static_cast<double>(segment.beams))
      continue;
    const Place place = place_of(segment, robot, 0.0);
    const double noise = kPlaceNoise + kPlaceNoiseFar * distance(place.centre, robot);
    Track track;
    track.centre = track.born = place.centre;
    track.variance_place = noise * noise;
    track.variance_velocity = kFirstSpeed * kFirstSpeed;
    track.radius = place.radius;
    track.width = place.width;
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
    if (!track.confirmed || speed < kSlowest || track.unseen > 0.0) continue;
    track.pace += std::max(0.0, speed - track.pace) * std::min(1.0, seconds / kPaceTime);
    track.course = track.velocity * (1.0 / speed);
  }
  std::erase_if(tracks_, [&](const Track& track) {
    if (track.unseen > kUnseen || track.stopped > (track.confirmed ? kStopped : 1.0)) return true;
    return track.unseen > kGoneFor && seen_through(track, scan);
  });

  std::vector<MovingObstacle> moving;
  for (const Track& track : tracks_) {
    if (!track.confirmed) continue;
    const bool stopped = length_of(track.velocity) < kSlowest;
    moving.push_back({track.centre, track.radius, stopped ? Point{} : track.velocity, track.course, track.pace});
  }
  return moving;
}

}  // namespace ctn::navigation
