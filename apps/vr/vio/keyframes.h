// Which pictures are keyframes: those whose poses stay in the filter's window, and from which features are followed.
//
// The window has so many poses, and the less time they span the less they tell of the motion. So however many pictures
// come, keyframes are some kKeyframeSpacing apart: a picture is one if it is nearer to that than the next picture will
// be, taken to come as long after it as it came after the one before. With up to 23 pictures a second all are; with
// more, keyframes are 52 to 87 ms apart.
//
// Units: seconds. Thread safety: one thread an object.
#pragma once

#include <optional>

namespace ctn::vr {

// More than the 50 ms of the usual 20 pictures a second, so that those may be late or early by an eighth.
inline constexpr double kKeyframeSpacing = 0.065;

class Keyframes {
 public:
  // Whether the picture of `time`, which is later than those before, is one.
  bool take(double time) {
    const bool due = !keyframe_ || time + 0.5 * (time - *picture_) >= *keyframe_ + kKeyframeSpacing;
    picture_ = time;
    if (due) keyframe_ = time;
    return due;
  }

 private:
  std::optional<double> picture_;   // the last one
  std::optional<double> keyframe_;  // the last one
};

}  // namespace ctn::vr
