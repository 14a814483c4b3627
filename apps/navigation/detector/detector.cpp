#include "detector/detector.h"

#include <algorithm>
#include <tuple>

namespace ctn::navigation {

void sort_by_confidence(std::vector<Detection>& things) {
  std::ranges::sort(things, {}, [](const Detection& thing) {
    const cv::Rect2d& box = thing.box;
    return std::make_tuple(-thing.confidence, thing.label, box.x, box.y, box.width, box.height);
  });
}

}  // namespace ctn::navigation
