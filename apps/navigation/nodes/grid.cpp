#include "grid.h"

#include <algorithm>
#include <limits>

namespace ctn::navigation {
namespace {

constexpr float kFar = 1e12F;  // squared cells

// The lower envelope of parabolas over one line (Felzenszwalb and Huttenlocher): `values` become squared distances.
class Envelope {
 public:
  explicit Envelope(std::size_t longest) : centres_(longest), borders_(longest + 1), line_(longest) {}

  void run(float* values, std::size_t count, std::size_t stride) {
    for (std::size_t i = 0; i < count; ++i) line_[i] = values[i * stride];
    std::size_t last = 0;
    bool any = false;
    for (std::size_t i = 0; i < count; ++i) {
      if (line_[i] >= kFar) continue;
      if (!any) {
        any = true;
        centres_[0] = i;
        borders_[0] = -std::numeric_limits<double>::infinity();
        continue;
      }
      double from = crossing(centres_[last], i);
      while (from <= borders_[last]) {
        --last;
        from = crossing(centres_[last], i);
      }
      ++last;
      centres_[last] = i;
      borders_[last] = from;
    }
    if (!any) return;
    std::size_t at = 0;
    for (std::size_t i = 0; i < count; ++i) {
      while (at < last && borders_[at + 1] < static_cast<double>(i)) ++at;
      const float offset = static_cast<float>(i) - static_cast<float>(centres_[at]);
      values[i * stride] = offset * offset + line_[centres_[at]];
    }
  }

 private:
  double crossing(std::size_t a, std::size_t b) const {
    const auto x = static_cast<double>(a);
    const auto y = static_cast<double>(b);
    return (static_cast<double>(line_[b]) + y * y - static_cast<double>(line_[a]) - x * x) / (2.0 * (y - x));
  }

  std::vector<std::size_t> centres_;
  std::vector<double> borders_;
  std::vector<float> line_;
};

}  // namespace

std::vector<float> clearance(const GridFrame& frame, const std::vector<std::uint8_t>& obstacles, double limit) {
  std::vector<float> distances(frame.cells());
  for (std::size_t i = 0; i < distances.size(); ++i) distances[i] = obstacles[i] != 0 ? 0.0F : kFar;
  const auto width = static_cast<std::size_t>(frame.width);
  const auto height = static_cast<std::size_t>(frame.height);
  Envelope envelope(std::max(width, height));
  for (std::size_t row = 0; row < height; ++row) envelope.run(distances.data() + row * width, width, 1);
  for (std::size_t column = 0; column < width; ++column) envelope.run(distances.data() + column, height, width);
  for (float& value : distances) {
    value = static_cast<float>(std::min(limit, std::sqrt(static_cast<double>(value)) * kCell));
  }
  return distances;
}

}  // namespace ctn::navigation
