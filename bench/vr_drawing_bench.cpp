// What it costs to draw the VR app's pictures, in CPU time of the thread that draws: median and 95th percentile of
// Render, of both kinds of Timewarp and of the camera's pictures, beside what the authors of the paper worked with
// (apps/vr/vr.costs.yaml; their drawing was done by a GPU). On a machine without a GPU all of it is done by the CPU.
//
//   vr_drawing_bench [--runs N] [--seed N] [--pictures FOLDER]
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "drawing/cameras.h"
#include "drawing/timewarp.h"
#include "drawing/views.h"
#include "program/slowed.h"
#include "world/room.h"
#include "world/trajectory.h"

namespace {

using namespace ctn::vr;
using namespace ctn::vr::drawing;

constexpr double kMargin = 0.05;
constexpr double kAhead = 0.01;  // seconds between the poses of a frame and its warp

Pose forwards() { return {looking_forward(), Eigen::Vector3d::Zero()}; }

void measure(const std::string& what, int runs, const std::string& published, const std::function<void(int)>& run) {
  std::vector<double> times;
  run(0);  // compiles what is compiled at the first use
  for (int i = 0; i < runs; ++i) {
    const auto begin = ctn::program::thread_cpu_time();
    run(i);
    times.push_back(std::chrono::duration<double, std::milli>(ctn::program::thread_cpu_time() - begin).count());
  }
  std::sort(times.begin(), times.end());
  const auto rank = [&](std::size_t percent) { return times[(times.size() * percent + 99) / 100 - 1]; };
  fmt::print("{:<34} {:>8.3f} {:>8.3f}   {}\n", what, rank(50), rank(95), published);
}

void write_picture(const std::string& folder, const std::string& name, std::vector<std::uint8_t>& pixels, int width,
                   int height, int type) {
  if (folder.empty()) return;
  cv::Mat picture(height, width, type, pixels.data());
  if (type == CV_8UC4) cv::cvtColor(picture, picture, cv::COLOR_RGBA2BGR);
  const std::string file = folder + "/" + name + ".png";
  if (!cv::imwrite(file, picture)) fmt::print(stderr, "no picture {}\n", file);
}

struct Settings {
  int runs = 200;
  std::uint64_t seed = 1;
  std::string pictures;
};

ctn::Status measure_size(const Settings& settings, const world::Room& room, const world::Trajectory& head, int width,
                         int height) {
  const CameraModel eye = eye_of(width, height);
  const CameraModel frames = with_margin(eye, kMargin);
  const auto pose_at = [&](double time) { return transformed(head.at(time).pose, forwards()); };
  const auto time_of = [&](int run) { return head.duration() * (run + 0.5) / (settings.runs + 1); };
  auto view = EyeView::open(room, frames, Screen::kFirst);
  if (!view) return view.error();
  auto rotational = Timewarp::open(eye, frames, Warp::kRotational, Screen::kSecond);
  if (!rotational) return rotational.error();
  auto translational = Timewarp::open(eye, frames, Warp::kTranslational, Screen::kSecond);
  if (!translational) return translational.error();
  fmt::print("{} x {}, drawn {} x {}, by {}\n", width, height, frames.width, frames.height, (*view)->renderer());
  Frame frame;
  measure("  Render, and read back", settings.runs, "0.115 (its part on the CPU)",
          [&](int run) { (*view)->draw(pose_at(time_of(run)), frame); });
  for (const auto& [name, timewarp] :
       {std::pair{"rotational", rotational->get()}, {"translational", translational->get()}}) {
    // Each run has a frame of its own, as where Render keeps up with the display.
    std::vector<Frame> drawn(8);
    for (std::size_t i = 0; i < drawn.size(); ++i)
      (*view)->draw(pose_at(time_of(static_cast<int>(i) * settings.runs / 8)), drawn[i]);
    measure(fmt::format("  Timewarp, {}", name), settings.runs, "0.15", [&](int run) {
      const auto i = static_cast<std::size_t>(run) % drawn.size();
      timewarp->take(drawn[i]);
      timewarp->warp(pose_at(time_of(static_cast<int>(i) * settings.runs / 8) + kAhead));
    });
    std::vector<std::uint8_t> pixels;
    timewarp->read(pixels);
    write_picture(settings.pictures, fmt::format("{}-{}", name, width), pixels, width, height, CV_8UC4);
  }
  write_picture(settings.pictures, fmt::format("frame-{}", width), frame.pixels, frames.width, frames.height, CV_8UC4);
  return ctn::Done{};
}

ctn::Status measure_all(const Settings& settings) {
  const world::Room room(settings.seed);
  world::HeadOptions options;
  options.seed = settings.seed;
  const world::HeadTrajectory head(options);
  fmt::print("{:<34} {:>8} {:>8}   published\n", "ms of CPU time", "median", "p95");
  for (const auto& [width, height] : {std::pair{640, 480}, {480, 360}, {320, 240}}) {
    if (const ctn::Status measured = measure_size(settings, room, head, width, height); !measured) return measured;
  }
  CameraModel camera;
  camera.k1 = -0.28;
  camera.k2 = 0.07;
  camera.body_from_camera = forwards();
  auto view = CameraView::open(room, camera, Screen::kFirst);
  if (!view) return view.error();
  std::vector<std::uint8_t> picture;
  measure("camera's picture, 640 x 480", settings.runs, "none (pictures are made beforehand)",
          [&](int run) { (*view)->draw(head.at(head.duration() * run / settings.runs).pose, picture); });
  write_picture(settings.pictures, "camera", picture, camera.width, camera.height, CV_8UC1);
  return ctn::Done{};
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("What it costs to draw the VR app's pictures.");
  Settings settings;
  app.add_option("--runs", settings.runs, "Of each kind")->check(CLI::Range(1, 100'000))->capture_default_str();
  app.add_option("--seed", settings.seed, "Of the room and the head's way")->capture_default_str();
  app.add_option("--pictures", settings.pictures, "Write the last picture of each kind into this folder");
  CLI11_PARSE(app, argc, argv);
  const ctn::Status measured = measure_all(settings);
  if (measured) return 0;
  fmt::print(stderr, "{}\n", measured.error().message());
  return measured.error().kind() == ctn::ErrorKind::kCaller ? 2 : 1;
}
