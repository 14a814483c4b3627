// The GL node: where the robot is in the map's frame, from all scans since its last run.
//
// Odometry predicts the pose. A scan taken near the last keyframe tells the map nothing new and is skipped (mode
// kSkip): of such scans the newest alone is looked at, to find the pose within a few centimetres of the prediction.
// What it finds holds until the next scan, so that errors of these small searches do not add up.
//
// A scan taken farther on is matched against the keyframes around in a wider window (mode kMatch), which corrects the
// pose, and becomes a keyframe. Where the robot comes back to a place that it left long ago, the scan is matched
// against the keyframes of that time as well, in a wider window still. If it fits, a loop is closed: the poses of all
// keyframes are adjusted (pose_graph.h).
//
// GM gets the keyframes. They are shared, with poses as of the newest loop closure. Of those that look at a place from
// nearly the same pose, the newest few count: what has moved is forgotten, and GM's cost is bounded by the area.
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
  bool outdated = false;  // newer ones show the same place from the same side: GM leaves it out
};
using SharedKeyframes = std::shared_ptr<const std::vector<Keyframe>>;

struct Localization {
  std::chrono::nanoseconds stamp{};  // of the newest scan that was used
  Pose correction;  // of the odometry's frame in the map's: transformed(correction, odometry's pose) is the robot's
  SharedKeyframes keyframes;  // never null
  std::uint64_t loops = 0;    // closed so far; each has moved keyframes
  SharedScan newest;          // the newest scan, keyframe or not; null before the first

  Pose pose_at(const Odometry& odometry) const { return transformed(correction, odometry.pose); }
};

class GlobalLocalizer {
 public:
  enum class Mode { kSkip, kMatch };  // the modes in the app file

  // Between keyframes: at full speed one and a half a second, which is what the case study's localisation passed on.
  static constexpr double kKeyframeDistance = 0.45;
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
  void outdate_oldest_like_newest(Work& work);
  // The field of the keyframes around `pose`.
  void draw_field(const Pose& pose);
  Pose tracked(const CleanScan& scan, Work& work);

  Pose correction_;  // by the newest keyframe
  Pose tracked_;     // by the newest scan
  SharedScan newest_;
  std::chrono::nanoseconds stamp_{};
  std::vector<Keyframe> keyframes_;
  std::vector<Constraint> constraints_;
  std::size_t last_loop_ = 0;  // the keyframe at which closing a loop was last attempted
  std::uint64_t loops_ = 0;
  Matcher matcher_;  // has the field around the newest keyframe, which is one of those that were drawn
  SharedKeyframes shared_;
};

}  // namespace ctn::navigation
