#include "image_outline.h"

namespace ctn::navigation::world {

std::vector<Segment> outline_of(const cv::Mat& image, double scale, Point origin, double dark) {
  const int width = image.cols;
  const int height = image.rows;
  const auto is_dark = [&](int column, int row) {
    return column >= 0 && row >= 0 && column < width && row < height &&
           static_cast<double>(image.at<unsigned char>(height - 1 - row, column)) < dark;
  };
  const auto corner = [&](int column, int row) { return origin + Point{column * scale, row * scale}; };
  std::vector<Segment> walls;
  const auto runs = [&](int lines, int length, auto&& differs, auto&& segment) {
    for (int line = 0; line <= lines; ++line) {
      for (int at = 0; at < length; ++at) {
        if (!differs(line, at)) continue;
        const int begin = at;
        while (at < length && differs(line, at)) ++at;
        walls.push_back(segment(line, begin, at));
      }
    }
  };
  runs(
      height, width, [&](int row, int column) { return is_dark(column, row) != is_dark(column, row - 1); },
      [&](int row, int begin, int end) {
        return Segment{corner(begin, row), corner(end, row)};
      });
  runs(
      width, height, [&](int column, int row) { return is_dark(column, row) != is_dark(column - 1, row); },
      [&](int column, int begin, int end) {
        return Segment{corner(column, begin), corner(column, end)};
      });
  return walls;
}

}  // namespace ctn::navigation::world
