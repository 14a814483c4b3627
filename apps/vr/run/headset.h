// The headset as its nodes see it: an inertial unit, a camera, and a display whose clock is known. One interface for
// the headset in virtual time and for the one in real time. The nodes also tell it what they did, for the figures of
// the run (findings.h).
//
// Times are nanoseconds since the first inertial sample. Thread safety: exposure(), finished() and tracked() from one
// thread at a time, each from its own; the rest from any. No call waits for another thread.
#pragma once

#include <chrono>
#include <cstddef>

#include "catan/result.h"
#include "run/clock.h"
#include "run/display.h"
#include "run/exposures.h"
#include "sensors.h"

namespace ctn::vr::run {

// In life a sample is there so long before IMU looks, as if it had woken its driver.
inline constexpr std::chrono::microseconds kSampleLead{200};

// VIO knows where the headset was.
struct Tracked {
  std::chrono::nanoseconds at{};        // when VIO said so
  std::chrono::nanoseconds exposure{};  // of when
  Pose pose;                            // world from body
  std::chrono::nanoseconds cost{};      // CPU time that Camera and VIO took for it
};

class Headset {
 public:
  virtual ~Headset() = default;

  virtual std::chrono::nanoseconds now() const = 0;
  // How many inertial samples there are, and one of them.
  virtual std::size_t samples() const = 0;
  virtual ImuSample sample(std::size_t index) const = 0;
  virtual Result<Exposure> exposure() = 0;
  virtual const Clock& display() const = 0;

  // What happened just now; `finished` and `at` are filled in.
  virtual void finished(Picture picture) = 0;
  virtual void tracked(Tracked tracked) = 0;
};

}  // namespace ctn::vr::run
