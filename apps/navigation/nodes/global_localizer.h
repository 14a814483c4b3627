// The GL node: where the robot is in the map's frame, from all scans since its last run.
//
// Odometry predicts the pose. A scan taken near the last keyframe tells nothing new and is skipped (mode kSkip, cheap).
// One taken farther on is matched against the keyframes around (mode kMatch), which corrects the pose, and becomes a
// keyframe. Where the robot comes back to a place that it left long ago, the scan is matched against the keyframes of
// that time as well, in a wider window. If it fits, a loop is closed: the poses of all keyframes are adjusted
// (pose_graph.h).
//
// GM gets the keyframes. They are shared, with poses as of the newest loop closure.
//
// Units: metres, radians, nanoseconds. Thread safety: one thread an object.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <vector>

#include "geometry.h"
#include "matcher.h"
#include "pose_graph.h"
#include "scan_filter.h"
#include "sensors.h"
#include "work.h"

namespace ctn::navigation {

struct Keyframe {
  Pose pose;  // in the map's frame
  SharedScan scan;
};
using SharedKeyframes = std::shared_ptr<const std::vector<Keyframe>>;

struct Localization {
  std::chrono::nanoseconds stamp{};  // of the newest scan that was used
  Pose correction;  // of the odometry's frame in the map's: transformed(correction, odometry's pose) is the robot's
  SharedKeyframes keyframes;  // never null
  std::uint64_t loops = 0;    // closed so far; each has moved keyframes

  Pose pose_at(const Odometry& odometry) const { return transformed(correction, odometry.pose); }
};

class GlobalLocalizer {
 public:
  enum class Mode { kSkip, kMatch };  // the modes in the app file

  static constexpr double kKeyframeDistance = 0.45;  // between keyframes
  static constexpr double kKeyframeTurn = 0.35;

  struct Result {
    Localization localization;
    Mode mode = Mode::kSkip;
    bool news = false;  // keyframes were added: GM has something to do
    Work work;
  };

  GlobalLocalizer();

  // `scans`: in the order of their stamps, none older than those of earlier runs; may be empty.
  Result run(const std::vector<SharedScan>& scans);

 private:
  bool tells_news(const Odometry& odometry) const;
  void match(const SharedScan& scan, Work& work);
  void close_loop(Work& work);

  Pose correction_;
  std::chrono::nanoseconds stamp_{};
  std::vector<Keyframe> keyframes_;
  std::vector<Constraint> constraints_;
  std::size_t last_loop_ = 0;  // the keyframe at which closing a loop was last attempted
  std::uint64_t loops_ = 0;
  Matcher matcher_;
  SharedKeyframes shared_;
};

}  // namespace ctn::navigation
