// The VIO node: from inertial samples and the Camera node's frames to where the headset is.
//
// Puts together the tracker (tracker.h) and the filter (filter.h), and says to both which pictures are keyframes
// (keyframes.h). It starts by itself once the body has stood still
// for half a second (standstill.h), in an own world: z is up, and where it started are position and yaw zero. Or it is
// given a state to start from.
//
// A frame that is not later than the one before is left out. Units: sensors.h. Thread safety: one thread an object.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "sensors.h"
#include "vio/camera_frame.h"
#include "vio/filter.h"
#include "vio/keyframes.h"
#include "vio/tracker.h"
#include "vio/work.h"

namespace ctn::vr {

struct VioSettings {
  FilterSettings filter{};
  TrackerSettings tracker{};
};

class Vio {
 public:
  explicit Vio(const CameraModel& model, const VioSettings& settings = {});

  // Starts anew from a state that is known, such as one of a test; `state` is finite.
  void start(const State& state, const Uncertainty& uncertainty) { filter_.start(state, uncertainty); }

  // All samples up to a frame's time should be added before the frame. One that cannot be true is left out.
  void add(const ImuSample& sample) { filter_.add(sample); }

  struct Result {
    std::optional<State> state;  // at the frame's time; nothing while not started, or if the frame was left out
    std::size_t features = 0;    // in the picture
    std::size_t used = 0;        // that corrected the state
    Work work;
  };
  Result run(const CameraFrame& frame);

  const Filter& filter() const { return filter_; }

 private:
  Eigen::Quaterniond turned_since(double before, double now) const;
  void start_if_at_rest(double time, const std::optional<double>& displacement);

  CameraModel model_;
  Filter filter_;
  Tracker tracker_;
  Keyframes keyframes_;
  std::optional<double> frame_time_;
  std::optional<double> resting_since_;  // by the pictures
};

}  // namespace ctn::vr
