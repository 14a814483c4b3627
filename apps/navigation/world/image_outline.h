// Walls from an image: the outlines of its dark pixels, so that a wall is exactly where its pixels are.
//
// Units: metres. Thread safety: pure functions.
#pragma once

#include <vector>

#include <opencv2/core.hpp>

#include "geometry.h"

namespace ctn::navigation::world {

// The sides of pixels between dark and bright ones, those in a row joined; all around the image is bright. `image`: one
// byte a pixel, those below `dark` are; row 0 is its top. `scale`: metres a pixel. `origin`: of its lower left corner.
std::vector<Segment> outline_of(const cv::Mat& image, double scale, Point origin, double dark);

}  // namespace ctn::navigation::world
