// What moves near the robot, how fast, and how large it is: obstacles tracked from scan to scan.
//
// A scan is cut into segments, where neighbouring hits are apart. A track begins with a segment that hits where a
// moment ago nothing was (LocalMapper tells which beams do), so that walls, which a turning or drifting robot sees anew
// all the time, begin none. It goes on with the segment that is nearest to where it should be; a Kalman filter with
// constant velocity gives place and speed (Bar-Shalom, Li and Kirubarajan, "Estimation with applications to tracking
// and navigation", 2001, chapter 6). All of this is in the odometry's frame, so the robot's own motion is corrected
// for.
//
// Where a thing is, is told by the two ends of its segment: for a box that shows two sides they are the ends of a
// diagonal, for one that shows one side, or for something round, the middle lies behind the line between them by as
// much as what is seen of it does not bulge towards the robot. So the place does not jump when another side comes into
// view. Where something nearer hides one end, or the edge of the laser's view cuts it off, the place is as far from the
// other end as the radius that was seen before tells (the robot's own, if none was): behind the middle of the side that
// begins there or, if hardly any of it is seen, where it was expected, but on the hidden side of the beam to that end.
// Where a thing has kept to a straight course, such a place tells how far along it is, and little of how far beside:
// that is corrected slowly, as the course may have been learnt wrongly, and the odometry's frame turns.
//
// What is no longer seen goes on as it did, for a while, unless the laser looks through the place. What has stopped is
// remembered, since it may go on. Where a thing turned back, its course is taken to end the next time, too, until it
// goes beyond: so what goes away from the robot need not be feared to turn back at once.
//
// Units: metres, m/s, seconds. Thread safety: one thread an object.
#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "geometry.h"
#include "scan_filter.h"
#include "work.h"

namespace ctn::navigation {

struct MovingObstacle {
  Point centre;         // at the scan's stamp, in the odometry's frame
  double radius = 0.0;  // of a circle around all of it
  Point velocity;       // zero: it has stopped
  Point course;         // of length one: where it goes, or went last
  double pace = 0.0;    // how fast it was lately; it may take this up again, in either direction
  // How far it is along its course, and back, to where it turned before; infinite: it never did.
  double ahead = std::numeric_limits<double>::infinity();
  double behind = std::numeric_limits<double>::infinity();
  double unseen = 0.0;  // seconds since it was seen last; where it is now is then only what is expected

  bool moves() const { return velocity.x != 0.0 || velocity.y != 0.0; }
  double speed() const { return std::hypot(velocity.x, velocity.y); }
  // If it goes on as it does, until its course ends.
  Point at(double seconds) const { return moves() ? along(speed() * seconds) : centre; }
  // If it has gone that way at its pace since it was seen last: what has just turned back, or started, is slower than
  // it will be by what was measured of it.
  Point at_its_pace(double seconds) const {
    return will_be_faster() ? along(pace * (unseen + seconds) - speed() * unseen) : at(seconds);
  }
  bool will_be_faster() const { return moves() && pace > speed(); }

 private:
  Point along(double way) const { return centre + velocity * (std::min(way, ahead) / speed()); }
};

class MotionTracker {
 public:
  static constexpr double kView = 5.0;          // farther away, nothing is tracked
  static constexpr double kMaxWidth = 1.3;      // what is wider is a wall
  static constexpr double kUnseen = 3.5;        // seconds for which a track goes on unseen
  static constexpr double kUnseenComing = 8.0;  // likewise, while it comes towards the robot
  static constexpr double kStopped = 6.0;       // seconds after which what has stopped is forgotten
  static constexpr double kSlowest = 0.12;      // what is slower has stopped
  static constexpr std::size_t kMinBeams = 4;   // of a segment

  // What a beam hit, as far as the map knows.
  enum class Hit : std::uint8_t {
    kOther,
    kFresh,  // something where a moment ago nothing was
    kOld,    // what has been there for seconds
  };

  // `hits`: one a beam. Scans should come in the order of their stamps.
  std::vector<MovingObstacle> run(const CleanScan& scan, const std::vector<Hit>& hits, Work& work);

 private:
  struct Segment {
    Point right;  // the first beam's hit
    Point left;
    bool right_hidden = false;
    bool left_hidden = false;
    double bulge = 0.0;  // how far it comes towards the robot from the line between its ends
    std::size_t beams = 0;
    std::size_t fresh = 0;
    std::size_t old = 0;
    bool used = false;

    // Both ends hidden tell nothing.
    bool tells() const { return !used && !(right_hidden && left_hidden) && 2 * old < beams; }
  };
  struct Place {
    Point centre;
    double radius;
  };
  struct Track {
    Point centre;
    Point velocity;
    // Covariance of place and velocity, the same along x and y.
    double variance_place = 0.0;
    double covariance = 0.0;
    double variance_velocity = 0.0;
    double radius = 0.0;
    Point born;
    int updates = 0;
    bool confirmed = false;  // it has moved
    Point course;
    double pace = 0.0;
    double unseen = 0.0;
    double stopped = 0.0;
    // Its course: a line through `born`, along which it goes up or down; where it turned back last, and how far it has
    // been since.
    Point line;
    std::optional<double> low;
    std::optional<double> high;
    double farthest = 0.0;
    double on_line = 0.0;  // seconds

    double along() const;
    bool goes_up() const;
    // It went along its line for so long that it will hardly leave it.
    bool keeps_to_line() const;
  };

  static std::vector<Segment> segments_of(const CleanScan& scan, const std::vector<Hit>& hits);
  static Place place_of(const Segment& segment, Point robot);
  static Place place_of_hidden(const Segment& segment, Point robot, Point expected, double radius);
  static void predict(Track& track, double seconds);
  static void update(Track& track, const Place& place, bool hidden, double range);
  static bool seen_through(const Track& track, const CleanScan& scan);
  static void learn_course(Track& track, Point course, double seconds);
  static void learn_place(Track& track);
  static void stop_at_end(Track& track);
  static MovingObstacle as_obstacle(const Track& track);
  void follow(std::vector<Segment>& segments, const CleanScan& scan, double seconds);

  std::vector<Track> tracks_;
  bool began_ = false;
  std::chrono::nanoseconds stamp_{};
};

}  // namespace ctn::navigation
