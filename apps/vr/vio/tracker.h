// Follows features from picture to picture.
//
// The picture is divided into cells. Where a cell has too few features, its best corners (Shi and Tomasi) become new
// ones, so that features are all over the picture and their number is bounded. A feature is looked for in the next
// picture by pyramidal Lucas-Kanade, from where the rotation that gyroscopes measured would have moved it: a head turns
// by 10 degrees from picture to picture. Tracks that no single motion of the camera explains are dropped
// (motion_vote.h). A feature that was lost does not come back; the corner may become a new one.
//
// What is looked for is what the feature looked like in the last keyframe (keyframes.h), and only keyframes are
// searched for new corners. So the small errors of following add up from keyframe to keyframe, however many pictures
// lie between.
//
// What a picture costs depends on it: the number of features that are followed, and of cells that have too few.
//
// Units: pixels. Thread safety: one thread an object. Sets OpenCV to use one thread.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <opencv2/core.hpp>

#include "sensors.h"
#include "vio/camera_frame.h"
#include "vio/feature_track.h"
#include "vio/work.h"

namespace ctn::vr {

struct TrackerSettings {
  int cell = 80;                // side of a cell
  int features_in_cell = 2;     // that it is filled up to
  int min_distance = 15;        // between features
  double min_corner = 5e-4;     // the smaller eigenvalue of a corner (cv::cornerMinEigenVal)
  double max_residual = 25.0;   // grey levels, mean over the window
  double vote_tolerance = 2.0;  // from where the camera's motion allows a feature to be
};

class Tracker {
 public:
  explicit Tracker(const CameraModel& model, const TrackerSettings& settings = {});

  struct Result {
    std::vector<Observation> observations;
    // Median way of the features that were followed, since the last keyframe; nothing if there were none.
    std::optional<double> displacement;
    Work work;
  };
  // `now_from_before`: how the camera turned since the picture before (motion_vote.h). A picture that is not of the
  // model's size is taken for one without features. After such a one, and at first, any picture is a keyframe.
  Result run(const CameraFrame& frame, const Eigen::Quaterniond& now_from_before, bool keyframe = true);

 private:
  struct Feature {
    std::uint64_t id = 0;
    cv::Point2f pixel;
    cv::Point2f in_keyframe;
  };

  void follow(const CameraFrame& frame, const Eigen::Quaterniond& now_from_before, Result& result);
  void start_from(const CameraFrame& keyframe, Result& result);
  void add_corners(const CameraFrame& frame, Result& result);
  bool inside(const cv::Point2f& pixel) const;

  CameraModel model_;
  TrackerSettings settings_;
  std::vector<cv::Mat> keyframe_;  // the pyramid of the last one
  Eigen::Quaterniond now_from_keyframe_ = Eigen::Quaterniond::Identity();
  std::vector<Feature> features_;
  std::uint64_t next_id_ = 1;
};

}  // namespace ctn::vr
