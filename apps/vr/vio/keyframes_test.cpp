#include "vio/keyframes.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <vector>

namespace ctn::vr {
namespace {

// The numbers of the keyframes among the first 13 of so many pictures a second.
std::vector<int> keyframes_at(double rate) {
  Keyframes keyframes;
  std::vector<int> taken;
  for (int picture = 0; picture < 13; ++picture) {
    if (keyframes.take(3.0 + picture / rate)) taken.push_back(picture);
  }
  return taken;
}

TEST(Keyframes, AreAllPicturesUpToTheUsualRateAndNearestTo65MillisecondsAbove) {
  const std::vector<int> all{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12};
  EXPECT_EQ(keyframes_at(10.0), all);
  EXPECT_EQ(keyframes_at(20.0), all);
  EXPECT_EQ(keyframes_at(23.0), all);
  EXPECT_EQ(keyframes_at(25.0), (std::vector<int>{0, 2, 4, 6, 8, 10, 12}));
  EXPECT_EQ(keyframes_at(31.0), (std::vector<int>{0, 2, 4, 6, 8, 10, 12}));
  EXPECT_EQ(keyframes_at(45.0), (std::vector<int>{0, 3, 6, 9, 12}));
  EXPECT_EQ(keyframes_at(60.0), (std::vector<int>{0, 4, 8, 12}));
}

TEST(Keyframes, AreAllOf20PicturesASecondThatAreLateOrEarlyByThreeMilliseconds) {
  Keyframes keyframes;
  for (int picture = 0; picture < 100; ++picture) {
    EXPECT_TRUE(keyframes.take(0.05 * picture + (picture * 7 % 3 - 1) * 0.003)) << picture;
  }
}

RC_GTEST_PROP(Keyframes, AreNeitherCloseNorFarApartWhateverTheIntervals, ()) {
  const auto milliseconds = *rc::gen::container<std::vector<int>>(rc::gen::inRange(1, 150));
  Keyframes keyframes;
  double time = 0.0;
  double keyframe = time;
  RC_ASSERT(keyframes.take(time));
  for (const int interval : milliseconds) {
    time += 1e-3 * interval;
    if (keyframes.take(time)) {
      RC_ASSERT(time - keyframe > 2.0 / 3.0 * kKeyframeSpacing - 1e-9);
      keyframe = time;
    }
    // What is not one is nearer to the last one than its spacing, by half an interval: the next picture will do.
    RC_ASSERT(time == keyframe || time + 0.5e-3 * interval < keyframe + kKeyframeSpacing + 1e-9);
  }
}

}  // namespace
}  // namespace ctn::vr
