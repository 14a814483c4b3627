// What the headset's Int, Camera and VIO nodes cost, and how far VIO's pose is from the true one: a head moves in a
// room (made up, or a sequence of the EuRoC data set), each run of a node is measured (CPU time of the thread). Prints
//
//   - the absolute and the relative error of VIO's trajectory;
//   - mean, median and 95th percentile of each node beside what the authors of the paper worked with, and beside what
//     cost() (apps/vr/vio/cost.h) computes, and how far off that is;
//   - factors for cost.h, fitted to these runs: for each node those that are nowhere negative and leave the least sum
//     of squared relative errors.
//
//   vio_bench [--euroc FOLDER] [--seconds N] [--seed N] [--size WxH] [--hz HZ]
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <Eigen/Dense>
#include <opencv2/imgcodecs.hpp>

#include "base/statistics.h"
#include "program/slowed.h"
#include "vio/cost.h"
#include "vio/integrator.h"
#include "vio/testing/painted_room.h"
#include "vio/testing/synthetic.h"
#include "vio/trajectory_error.h"
#include "vio/vio.h"
#include "world/euroc.h"

namespace {

using namespace ctn::vr;

constexpr std::size_t kNodes = kTrackingNodeNames.size();
constexpr std::size_t kKinds = 9;                                  // a run, and the kinds of work
constexpr std::array<double, kNodes> kPublished{0.04, 3.5, 19.3};  // ms

struct Sample {
  double time;  // seconds
  Work work;
};

struct Measured {
  std::array<std::vector<Sample>, kNodes> runs;
  std::vector<StampedPose> estimated;
  std::vector<StampedPose> truth;
  std::size_t features = 0;
  std::size_t used = 0;
};

double cpu_time() { return std::chrono::duration<double>(ctn::program::thread_cpu_time()).count(); }

std::array<double, kKinds> kinds(const Work& work) {
  return {1.0,
          static_cast<double>(work.samples),
          static_cast<double>(work.moved),
          static_cast<double>(work.smoothed),
          static_cast<double>(work.cornered),
          static_cast<double>(work.windows),
          static_cast<double>(work.votes),
          static_cast<double>(work.observations),
          static_cast<double>(work.multiply_adds)};
}

// Least squares of relative errors without negative factors, by coordinate descent: the problem is convex.
TrackingFactors fitted(const std::vector<Sample>& samples) {
  std::array<std::array<double, kKinds>, kKinds> matrix{};
  std::array<double, kKinds> right{};
  for (const Sample& sample : samples) {
    std::array<double, kKinds> row = kinds(sample.work);
    for (double& value : row) value /= sample.time;
    for (std::size_t i = 0; i < kKinds; ++i) {
      right[i] += row[i];
      for (std::size_t k = 0; k < kKinds; ++k) matrix[i][k] += row[i] * row[k];
    }
  }
  std::array<double, kKinds> factors{};
  for (int round = 0; round < 20'000; ++round) {
    for (std::size_t i = 0; i < kKinds; ++i) {
      if (matrix[i][i] == 0.0) continue;
      double rest = right[i];
      for (std::size_t k = 0; k < kKinds; ++k) rest -= k == i ? 0.0 : matrix[i][k] * factors[k];
      factors[i] = std::max(0.0, rest / matrix[i][i]);
    }
  }
  for (double& factor : factors) factor *= 1e9;
  return {factors[0], factors[1], factors[2], factors[3], factors[4], factors[5], factors[6], factors[7], factors[8]};
}

struct Nodes {
  explicit Nodes(const CameraModel& model) : camera(model), vio(model) {}

  Camera camera;
  Vio vio;
  Integrator integrator;
};

void take(Nodes& nodes, const ImuSample& sample, Measured& measured) {
  nodes.vio.add(sample);
  const double begin = cpu_time();
  const Work work = nodes.integrator.add(sample);
  const double time = cpu_time() - begin;
  if (work.samples > 0) measured.runs[0].push_back({time, work});
}

bool take(Nodes& nodes, const cv::Mat& picture, double time, Measured& measured) {
  const double begin = cpu_time();
  const ctn::Result<CameraFrame> frame = nodes.camera.run(picture, time);
  const double taken = cpu_time();
  if (!frame) {
    fmt::print(stderr, "{}\n", frame.error().message());
    return false;
  }
  const Vio::Result result = nodes.vio.run(*frame);
  const double tracked = cpu_time();
  measured.runs[1].push_back({taken - begin, frame->work});
  measured.runs[2].push_back({tracked - taken, result.work});
  measured.features += result.features;
  measured.used += result.used;
  if (!result.state) return true;
  measured.estimated.push_back({time, result.state->pose});
  const double rebase_begin = cpu_time();
  const Work work = nodes.integrator.rebase(*result.state);
  measured.runs[0].push_back({cpu_time() - rebase_begin, work});
  return true;
}

int print(const Measured& measured) {
  const TrajectoryError error = absolute_error(measured.estimated, measured.truth);
  const TrajectoryError drift = relative_error(measured.estimated, measured.truth, 1.0);
  fmt::print(
      "{} poses: absolute trajectory error {:.3f} m (largest {:.3f} m, {:.2f} degrees), in 1 s {:.3f} m, {:.2f} "
      "degrees\n",
      error.poses, error.position_rmse, error.position_max, error.rotation_rmse * 180.0 / M_PI, drift.position_rmse,
      drift.rotation_rmse * 180.0 / M_PI);
  const auto frames = static_cast<double>(measured.runs[2].size());
  fmt::print("{:.0f} features in a picture, {:.1f} used\n\n", static_cast<double>(measured.features) / frames,
             static_cast<double>(measured.used) / frames);
  fmt::print("ms      runs     mean   median      p95   paper    cost(): mean   median      p95   off by, median\n");
  for (std::size_t node = 0; node < kNodes; ++node) {
    std::vector<double> times;
    std::vector<double> costs;
    std::vector<double> errors;
    for (const Sample& sample : measured.runs[node]) {
      const double computed = cost(static_cast<TrackingNode>(node), sample.work);
      times.push_back(sample.time * 1e3);
      costs.push_back(computed * 1e3);
      errors.push_back(std::abs(computed - sample.time) / sample.time);
    }
    const ctn::Summary time = ctn::summarize(times);
    const ctn::Summary cost_ms = ctn::summarize(costs);
    fmt::print("{:<6} {:>5} {:>8.4f} {:>8.4f} {:>8.4f} {:>7.2f} {:>16.4f} {:>8.4f} {:>8.4f} {:>14.0f} %\n",
               kTrackingNodeNames[node], time.count, time.mean, time.p50, time.p95, kPublished[node], cost_ms.mean,
               cost_ms.p50, cost_ms.p95, ctn::summarize(errors).p50 * 100.0);
  }
  fmt::print("\nfitted to these runs, in ns:\n");
  for (std::size_t node = 0; node < kNodes; ++node) {
    const TrackingFactors factors = fitted(measured.runs[node]);
    fmt::print("    {{{:.0f}, {:.1f}, {:.3f}, {:.3f}, {:.3f}, {:.1f}, {:.2f}, {:.2f}, {:.4f}}},  // {}\n", factors.run,
               factors.sample, factors.moved, factors.smoothed, factors.cornered, factors.window, factors.vote,
               factors.observation, factors.multiply_add, kTrackingNodeNames[node]);
  }
  return 0;
}

int run_euroc(const std::string& folder) {
  const ctn::Result<world::Euroc> euroc = world::read_euroc(folder);
  if (!euroc) {
    fmt::print(stderr, "{}\n", euroc.error().message());
    return 1;
  }
  Measured measured;
  for (const State& state : euroc->truth) measured.truth.push_back({state.time, state.pose});
  Nodes nodes(euroc->camera);
  std::size_t next = 0;
  for (const world::PictureFile& picture : euroc->pictures) {
    for (; next < euroc->imu.size() && euroc->imu[next].time <= picture.time; ++next) {
      take(nodes, euroc->imu[next], measured);
    }
    if (!take(nodes, cv::imread(picture.path, cv::IMREAD_GRAYSCALE), picture.time, measured)) return 1;
  }
  return print(measured);
}

int run_room(double seconds, std::uint64_t seed, int width, int height, double hz) {
  testing::SyntheticOptions options;
  options.seed = seed;
  testing::SyntheticHead head(options);
  const CameraModel model = testing::camera_of(width, height);
  const testing::PaintedRoom room(seed);
  Measured measured;
  Nodes nodes(model);
  const int frames = static_cast<int>(seconds * hz);
  double sampled = -1.0;
  for (int frame = 0; frame < frames; ++frame) {
    const double time = (frame + 1) / hz - testing::SyntheticHead::kImuPeriod;
    while (sampled < time - 1e-9) {
      const ImuSample sample = head.next_sample();
      sampled = sample.time;
      take(nodes, sample, measured);
    }
    const Pose truth = head.truth(time).pose;
    measured.truth.push_back({time, truth});
    if (!take(nodes, room.picture(model, truth, 2.0, static_cast<std::uint64_t>(frame)), time, measured)) return 1;
  }
  return print(measured);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("What the headset's tracking nodes cost, and how far off they are.");
  std::string euroc;
  double seconds = 30.0;
  std::uint64_t seed = 1;
  std::string size = "640x480";
  app.add_option("--euroc", euroc,
                 "A sequence of the EuRoC data set: the folder that has mav0; default: a made-up room");
  app.add_option("--seconds", seconds, "In the made-up room")->capture_default_str();
  app.add_option("--seed", seed, "Of the made-up room, the head's way and noise")->capture_default_str();
  app.add_option("--size", size, "Of the pictures of the made-up room")->capture_default_str();
  double hz = 20.0;
  app.add_option("--hz", hz, "Pictures a second of the made-up room")
      ->check(CLI::Range(1.0, 100.0))
      ->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  if (!euroc.empty()) return run_euroc(euroc);
  int width = 0;
  int height = 0;
  if (std::sscanf(size.c_str(), "%dx%d", &width, &height) != 2 || width < 64 || height < 64 || width > 4096 ||
      height > 4096) {
    fmt::print(stderr, "--size {}: write a width and a height from 64 to 4096, such as 640x480\n", size);
    return 2;
  }
  return run_room(seconds, seed, width, height, hz);
}
