// The GL node: where the robot is in the map's frame, from all scans since its last run.
//
// Odometry predicts the pose, and how far it may be off. A scan taken near the last keyframe tells the map nothing new
// and is skipped (mode kSkip): of such scans the newest alone is looked at, to find the pose within a few centimetres
// of the prediction. What it finds holds until the next scan, so that errors of these small searches do not add up.
//
// A scan taken farther on is matched against the keyframes around in a wider window (mode kMatch), which corrects the
// pose, and becomes a keyframe. Odometry and match count by their covariances: along a corridor, where a match says
// nothing, the pose is odometry's. What moves is left out: points where another keyframe shortly before or after saw
// through.
//
// Where the robot comes back to a place that it left long ago, the scan is matched against the keyframes of that time
// as well. If that holds what loop_closure.h asks for, a loop is closed.
// The poses of all keyframes are then adjusted by a robust method, which may still leave a closed loop out where others
// contradict it (pose_graph.h). So the pose may jump. What was planned on a map from before the jump lies relative to
// the keyframes of that time: Anchor says how to find the robot there, until there is a new map.
//
// GM gets the keyframes. They are shared, with poses as of the newest loop closure. Of those that look at a place from
// nearly the same pose, the newest few count: what has moved is forgotten, and GM's cost is bounded by the area.
//
// Units: metres, radians, nanoseconds. Thread safety: one thread an object.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "geometry.h"
#include "keyframe.h"
#include "loop_closure.h"
#include "matcher.h"
#include "odometry_error.h"
#include "pose_graph.h"
#include "scan_filter.h"
#include "sensors.h"
#include "visibility.h"
#include "work.h"

namespace ctn::navigation {

// Where the newest keyframe of a map was when the map was made. Closing a loop may have moved it since.
struct Anchor {
  std::size_t keyframes = 0;  // that there were; 0: none, nothing has moved
  Pose newest;                // of them
};

struct Localization {
  std::chrono::nanoseconds stamp{};  // of the newest scan that was used
  Pose correction;  // of the odometry's frame in the map's: transformed(correction, odometry's pose) is the robot's
  SharedKeyframes keyframes;  // never null
  std::uint64_t loops = 0;    // closed so far; each has moved keyframes
  SharedScan newest;          // the newest scan, keyframe or not; null before the first

  Pose pose_at(const Odometry& odometry) const { return transformed(correction, odometry.pose); }

  // As `correction`, but in the frame of a map as it was made: what lies near the anchor's keyframe still does.
  Pose correction_on(const Anchor& anchor) const {
    if (anchor.keyframes == 0 || !keyframes || keyframes->size() < anchor.keyframes) return correction;
    const Pose moved_to = (*keyframes)[anchor.keyframes - 1].pose;
    return transformed(anchor.newest, between(moved_to, correction));
  }
  Pose pose_on(const Anchor& anchor, const Odometry& odometry) const {
    return transformed(correction_on(anchor), odometry.pose);
  }
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
  std::optional<std::size_t> nearest_of_long_ago(Work& work) const;
  Sight sight(std::size_t keyframe) const;
  void outdate_oldest_like_newest(Work& work);
  // The field of the newest keyframes before `end` that are around `pose`.
  void draw_field(const Pose& pose, std::size_t end);
  Pose tracked(const CleanScan& scan, Work& work);

  Pose correction_;  // by the newest keyframe
  Pose tracked_;     // by the newest scan
  SharedScan newest_;
  std::chrono::nanoseconds stamp_{};
  std::vector<Keyframe> keyframes_;
  StillPoints still_;
  OdometryError odometry_error_;  // since the newest keyframe
  std::vector<Constraint> constraints_;
  std::size_t last_loop_ = 0;  // the keyframe at which closing a loop was last attempted
  std::uint64_t loops_ = 0;
  Matcher matcher_;  // has the field around the newest keyframe, which is one of those that were drawn
  SharedKeyframes shared_;
};

}  // namespace ctn::navigation
