// What the nodes drive in tests and benchmarks: a robot in some world.
//
// Units: metres, radians, seconds; instants in nanoseconds since the world began. Thread safety: one thread an object.
#pragma once

#include <chrono>

#include "geometry.h"
#include "sensors.h"

namespace ctn::navigation::testing {

class Plant {
 public:
  Plant() = default;
  Plant(const Plant&) = delete;
  Plant& operator=(const Plant&) = delete;
  virtual ~Plant() = default;

  virtual Scan scan() = 0;
  virtual Odometry odometry() = 0;
  // The base takes up the velocity as fast as it can and keeps it.
  virtual void advance(double seconds, const Velocity& wanted) = 0;
  virtual std::chrono::nanoseconds now() const = 0;

  double time() const { return std::chrono::duration<double>(now()).count(); }
};

}  // namespace ctn::navigation::testing
