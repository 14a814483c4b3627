// Where the face is: a walk along a square around the camera, as a pure function of time.
//
// The camera stands at the centre of the square. The face goes along the sides at a constant linear speed and turns
// round at random moments, 1 s to 3 s apart. Without them a tracker that has learnt the speed would stay on target
// however late it sees; each turn asks for a fresh reaction. The moments come from the seed alone: every scheduler can
// be given the same walk.
//
// Units: seconds, radians. Bearings grow counter-clockwise and are not wrapped. Thread safety: immutable.
#pragma once

#include <cstdint>
#include <vector>

namespace ctn::face_tracking {

class Path {
 public:
  // `speed` is the mean rate of the bearing, in rad/s: a straight walk goes all round in 2 pi / speed. Because the
  // linear speed is constant, the bearing's rate is 4/pi times that in the middle of a side and 2/pi at a corner.
  Path(double speed, std::uint64_t seed);

  double bearing(double time) const;

 private:
  struct Leg {
    double begin;      // seconds
    double walked;     // sides of the square walked at `begin`, signed
    double direction;  // 1 or -1
  };

  double sides_per_second_;
  std::vector<Leg> legs_;  // never empty; the last goes on for ever
};

// The bearing of a point that walked `sides` sides along the square, from the middle of the side at bearing 0.
double bearing_on_square(double sides);

// The same angle in [-pi, pi).
double wrapped(double angle);

}  // namespace ctn::face_tracking
