// The display: at each tick of its clock the newest picture that was finished by then is shown, and its photons reach
// the eye, all at once. What it showed is kept, for figures and pictures.
//
// Times are nanoseconds since the first inertial sample. Poses are those of the eye's camera. Thread safety: one
// thread.
#pragma once

#include <chrono>
#include <optional>
#include <vector>

#include "run/clock.h"
#include "sensors.h"

namespace ctn::vr::run {

// What Timewarp made.
struct Picture {
  std::chrono::nanoseconds finished{};
  Pose drawn;   // at which Render drew it
  Pose warped;  // to which it was warped
  Pose known;   // where the headset took the eye to be at `warped_stamp`
  // The newest inertial sample behind each, and the exposure of the camera's picture behind the newer one.
  std::chrono::nanoseconds warped_stamp{};
  std::chrono::nanoseconds drawn_stamp{};
  std::optional<std::chrono::nanoseconds> exposure;
};

// What a tick showed.
struct Photon {
  std::chrono::nanoseconds tick{};
  Picture picture;
  bool fresh = false;  // it was not shown before; else nothing was finished since the last tick, which was missed
};

class Display {
 public:
  explicit Display(const Clock& clock) : clock_(clock), next_(clock.next(std::chrono::nanoseconds(0))) {}

  // Pictures in the order in which they were finished. One that is finished at the instant of a tick is shown by it.
  void finished(const Picture& picture);
  // Lets all ticks up to `until` pass.
  void advance(std::chrono::nanoseconds until);

  // From the first picture on, in order.
  const std::vector<Photon>& photons() const { return photons_; }

 private:
  Clock clock_;
  std::chrono::nanoseconds next_;
  std::optional<Picture> newest_;
  bool fresh_ = false;
  std::vector<Photon> photons_;
};

}  // namespace ctn::vr::run
