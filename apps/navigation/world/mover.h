// A thing that moves along its path whatever happens. Where it is, is a pure function of time.
//
// It goes along straight lines from point to point at one speed, waits at each point, and then goes back the same way
// or, if its path is closed, round again. It never turns: a box keeps its heading.
//
// Units: metres, seconds, m/s, radians. Thread safety: immutable.
#pragma once

#include <optional>
#include <vector>

#include "geometry.h"

namespace ctn::navigation::world {

struct MoverSpec {
  std::vector<Point> path;  // two points or more
  double speed = 0.0;
  double length = 0.0;  // of a box, along its heading
  double width = 0.0;
  double heading = 0.0;
  double radius = 0.0;                // above 0: it is round, not a box
  bool closed = false;                // from the last point on to the first one
  double pause = 0.0;                 // at each point
  std::optional<double> phase = 0.0;  // seconds along its timetable at time 0; none: drawn from the seed

  // The radius of the circle around it.
  double reach() const { return radius > 0.0 ? radius : std::hypot(length, width) / 2.0; }
  friend bool operator==(const MoverSpec&, const MoverSpec&) = default;
};

class Mover {
 public:
  // `drawn` in [0, 1) is its phase as a share of its timetable, where the specification has none.
  Mover(MoverSpec spec, double drawn);

  Point at(double seconds) const;
  // How long until it is where it was again, going the same way.
  double cycle() const { return cycle_; }
  const MoverSpec& spec() const { return spec_; }

 private:
  struct Leg {
    double begin;
    double end;
    Point from;
    Point to;
  };

  MoverSpec spec_;
  std::vector<Leg> legs_;
  double cycle_ = 0.0;
  double phase_ = 0.0;
};

}  // namespace ctn::navigation::world
