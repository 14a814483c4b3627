#include "detector/letterbox.h"

#include <gtest/gtest.h>

namespace ctn::navigation {
namespace {

TEST(Letterbox, IsNothingWhereThePictureHasTheInputsSize) {
  const Letterbox same({768, 576}, {768, 576});
  EXPECT_EQ(same.content(), cv::Rect(0, 0, 768, 576));
  EXPECT_FALSE(same.scales());
  EXPECT_FALSE(same.pads());
  EXPECT_EQ(same.to_picture({10.5, 20.25, 30.0, 40.0}), cv::Rect2d(10.5, 20.25, 30.0, 40.0));
}

TEST(Letterbox, PadsAboveAndBelowAWidePicture) {
  const Letterbox wide({768, 576}, {320, 320});
  EXPECT_EQ(wide.content(), cv::Rect(0, 40, 320, 240));
  EXPECT_TRUE(wide.scales());
  EXPECT_TRUE(wide.pads());
}

TEST(Letterbox, PadsBesideATallPicture) {
  const Letterbox tall({300, 600}, {416, 416});
  EXPECT_EQ(tall.content(), cv::Rect(104, 0, 208, 416));
}

TEST(Letterbox, EnlargesASmallPicture) {
  const Letterbox small({10, 5}, {320, 320});
  EXPECT_EQ(small.content(), cv::Rect(0, 80, 320, 160));
  EXPECT_EQ(small.to_picture({32.0, 96.0, 64.0, 32.0}), cv::Rect2d(1.0, 0.5, 2.0, 1.0));
}

TEST(Letterbox, ContentIsTheWholePictureExactly) {
  // Sizes that no scale divides evenly, down to a line of pixels.
  for (const cv::Size picture : {cv::Size(640, 424), {641, 479}, {1, 999}, {1999, 3}, {33, 32}}) {
    for (const cv::Size input : {cv::Size(320, 320), {416, 224}, {768, 576}, {32, 608}}) {
      const Letterbox fit(picture, input);
      EXPECT_EQ(fit.content() & cv::Rect({}, input), fit.content());
      EXPECT_EQ(fit.to_picture(cv::Rect2d(fit.content())), cv::Rect2d({}, cv::Size2d(picture)))
          << picture << " in " << input;
    }
  }
}

TEST(Letterbox, CutsBoxesOffAtThePicturesEdges) {
  const Letterbox wide({768, 576}, {320, 320});
  EXPECT_EQ(wide.to_picture({-50.0, 0.0, 500.0, 320.0}), cv::Rect2d(0.0, 0.0, 768.0, 576.0));
  EXPECT_TRUE(wide.to_picture({10.0, 0.0, 50.0, 30.0}).empty());  // in the filling
}

}  // namespace
}  // namespace ctn::navigation
