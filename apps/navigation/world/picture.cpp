#include "picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace ctn::navigation::world {
namespace {

constexpr double kPixelsMax = 1600.0;  // of the longer side
constexpr double kScaleMax = 50.0;     // pixels a metre
constexpr double kMargin = 12.0;
constexpr int kSubpixelBits = 4;  // OpenCV draws at fractions of pixels

// Colours as blue, green, red.
const cv::Scalar kPaper(255, 255, 255);
const cv::Scalar kUnseen(225, 225, 225);
const cv::Scalar kBlock(190, 190, 190);
const cv::Scalar kWall(40, 40, 40);
const cv::Scalar kPath(220, 190, 150);
const cv::Scalar kMover(200, 120, 30);
const cv::Scalar kView(215, 245, 250);
const cv::Scalar kHit(40, 40, 220);
const cv::Scalar kWay(90, 170, 60);
const cv::Scalar kRobot(60, 130, 30);
const cv::Scalar kGoal(160, 40, 160);
const cv::Scalar kBelieved(230, 140, 90);
const cv::Scalar kPlanned(40, 160, 240);

class Drawing {
 public:
  explicit Drawing(const Box& bounds)
      : bounds_(bounds),
        scale_(std::min(kScaleMax, kPixelsMax / std::max(bounds.width(), bounds.height()))),
        image_(static_cast<int>(bounds.height() * scale_ + 2.0 * kMargin),
               static_cast<int>(bounds.width() * scale_ + 2.0 * kMargin), CV_8UC3, kPaper) {}

  void line(Point from, Point to, const cv::Scalar& colour, int thickness) {
    cv::line(image_, pixel(from), pixel(to), colour, thickness, cv::LINE_AA, kSubpixelBits);
  }
  void fill(const std::vector<Point>& corners, const cv::Scalar& colour) {
    std::vector<cv::Point> pixels;
    for (const Point corner : corners) pixels.push_back(pixel(corner));
    cv::fillPoly(image_, std::vector<std::vector<cv::Point>>{pixels}, colour, cv::LINE_AA, kSubpixelBits);
  }
  void disc(Point centre, double radius, const cv::Scalar& colour, int thickness) {
    cv::circle(image_, pixel(centre), static_cast<int>(radius * scale_ * (1 << kSubpixelBits)), colour, thickness,
               cv::LINE_AA, kSubpixelBits);
  }
  double pixels(double count) const { return count / scale_; }  // in metres
  const cv::Mat& image() const { return image_; }

 private:
  cv::Point pixel(Point at) const {
    const double one = 1 << kSubpixelBits;
    return {static_cast<int>(std::lround((kMargin + (at.x - bounds_.low.x) * scale_) * one)),
            static_cast<int>(std::lround((kMargin + (bounds_.high.y - at.y) * scale_) * one))};
  }

  Box bounds_;
  double scale_;
  cv::Mat image_;
};

std::vector<Point> box_at(Point centre, double length, double width, double heading) {
  const Point along{std::cos(heading) * length / 2.0, std::sin(heading) * length / 2.0};
  const Point across{-std::sin(heading) * width / 2.0, std::cos(heading) * width / 2.0};
  return {centre - along - across, centre + along - across, centre + along + across, centre - along + across};
}

Point end_of(const Pose& from, const Scan& scan, std::size_t ray) {
  const double angle = from.heading + scan.angle(ray);
  const double length = std::min(scan.max_range, static_cast<double>(scan.ranges[ray]));
  return position(from) + Point{std::cos(angle), std::sin(angle)} * length;
}

void draw_movers(Drawing& drawing, const std::vector<Mover>& movers, std::chrono::nanoseconds at) {
  const double time = std::chrono::duration<double>(at).count();
  for (const Mover& mover : movers) {
    const MoverSpec& spec = mover.spec();
    for (std::size_t i = 0; i + 1 < spec.path.size(); ++i) drawing.line(spec.path[i], spec.path[i + 1], kPath, 1);
    if (spec.closed) drawing.line(spec.path.back(), spec.path.front(), kPath, 1);
  }
  for (const Mover& mover : movers) {
    const MoverSpec& spec = mover.spec();
    if (spec.radius > 0.0) {
      drawing.disc(mover.at(time), spec.radius, kMover, cv::FILLED);
    } else {
      drawing.fill(box_at(mover.at(time), spec.length, spec.width, spec.heading), kMover);
    }
  }
}

void draw_belief(Drawing& drawing, const Belief& belief) {
  const double side = std::max(belief.cell, drawing.pixels(1.0));
  for (const Point obstacle : belief.obstacles) drawing.fill(box_at(obstacle, side, side, 0.0), kBelieved);
  for (std::size_t i = 0; i + 1 < belief.path.size(); ++i) {
    drawing.line(belief.path[i], belief.path[i + 1], kPlanned, 2);
  }
}

}  // namespace

Shot take_shot(World& world) {
  Shot shot;
  shot.at = world.now();
  shot.robot = world.truth();
  shot.scan = world.scan_at(world.now());
  shot.scanned_from = world.truth_at(shot.scan.stamp);
  for (std::chrono::nanoseconds at{}; at <= world.now(); at += kSensorPeriod) {
    shot.way.push_back(position(world.truth_at(at)));
  }
  for (const Contact& contact : world.contacts()) shot.contacts.push_back(position(contact.pose));
  if (world.explored()) {
    const Grid& grid = world.explored()->grid();
    for (std::size_t cell = 0; cell < grid.size(); ++cell) {
      if (!world.explored()->seen(cell)) shot.unseen.push_back(grid.centre(cell));
    }
  }
  return shot;
}

Status write_picture(const WorldFile& file, const std::vector<Mover>& movers, const Shot& shot, const Belief& belief,
                     const std::string& path) {
  if (!cv::haveImageWriter(path)) {
    return Error::caller(fmt::format("{} does not end in a format of pictures", path), "name it FILE.png");
  }
  Drawing drawing(file.bounds);
  for (const Point cell : shot.unseen) drawing.fill(box_at(cell, kSeenCell, kSeenCell, 0.0), kUnseen);
  std::vector<Point> view{position(shot.scanned_from)};
  for (std::size_t ray = 0; ray < shot.scan.ranges.size(); ++ray) {
    view.push_back(end_of(shot.scanned_from, shot.scan, ray));
  }
  drawing.fill(view, kView);
  for (const auto& block : file.blocks) drawing.fill(block, kBlock);
  for (const Segment& wall : file.walls) drawing.line(wall.from, wall.to, kWall, 2);
  draw_movers(drawing, movers, shot.at);
  draw_belief(drawing, belief);
  for (std::size_t ray = 0; ray < shot.scan.ranges.size(); ++ray) {
    if (std::isfinite(shot.scan.ranges[ray])) drawing.disc(view[ray + 1], drawing.pixels(1.0), kHit, cv::FILLED);
  }
  for (std::size_t i = 0; i + 1 < shot.way.size(); ++i) drawing.line(shot.way[i], shot.way[i + 1], kWay, 1);
  if (file.goal) {
    drawing.disc(*file.goal, kGoalRadius, kGoal, 2);
    drawing.disc(*file.goal, drawing.pixels(2.0), kGoal, cv::FILLED);
  }
  const Pose& robot = shot.robot;
  drawing.fill(box_at(position(robot), kRobotSide, kRobotSide, robot.heading), kRobot);
  drawing.line(position(robot), position(along_arc(robot, kRobotSide * 0.4, 0.0)), kPaper, 2);
  for (const Point contact : shot.contacts) drawing.disc(contact, kRobotSide, kHit, 1);
  try {
    if (cv::imwrite(path, drawing.image())) return Done{};
  } catch (const cv::Exception&) {  // as below
  }
  return Error::environment(fmt::format("the picture {} cannot be written", path),
                            "name a file in a folder that exists");
}

Status write_picture(World& world, const std::string& path) {
  return write_picture(world.file(), world.scene().movers(), take_shot(world), {}, path);
}

}  // namespace ctn::navigation::world
