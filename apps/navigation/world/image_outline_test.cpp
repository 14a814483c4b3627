#include "image_outline.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace ctn::navigation::world {
namespace {

using ::testing::IsEmpty;
using ::testing::UnorderedElementsAre;

TEST(ImageOutline, JoinsSidesOfPixelsInARow) {
  const cv::Mat image = (cv::Mat_<unsigned char>(2, 3) << 0, 0, 255,  //
                         255, 255, 255);
  EXPECT_THAT(outline_of(image, 0.5, {10, 20}, 128.0),
              UnorderedElementsAre(Segment{{10, 20.5}, {11, 20.5}}, Segment{{10, 21}, {11, 21}},
                                   Segment{{10, 20.5}, {10, 21}}, Segment{{11, 20.5}, {11, 21}}))
      << "the first row is the top, and all around it is bright";
}

TEST(ImageOutline, WhatIsNotDarkHasNone) {
  const cv::Mat grey(4, 4, CV_8U, cv::Scalar(100));
  EXPECT_THAT(outline_of(grey, 1.0, {0, 0}, 100.0), IsEmpty());
  EXPECT_EQ(outline_of(grey, 1.0, {0, 0}, 100.5).size(), 4U);
}

}  // namespace
}  // namespace ctn::navigation::world
