// What the navigation app's nodes cost, and whether they find their way: a robot drives in one of the case study's
// worlds, all nodes in a loop at fixed rates in virtual time, and each run of a node is measured (CPU time of the
// thread). Prints
//
//   - how the drive went: contacts, time to the goal or to 90 % explored, way, error of the localisation;
//   - mean and 95th percentile of each node beside the figures that the authors of the paper worked with;
//   - how far cost() (nodes/cost.h) is from what was measured;
//   - factors for cost.h, fitted to these runs: for each node those that are nowhere negative and leave the least sum
//     of squared relative errors.
//
//   navigation_nodes_bench [--map FILE] [--seconds N] [--seed N] [--no-movers] [--pictures FOLDER]
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <Eigen/Dense>

#include "base/statistics.h"
#include "nodes/cost.h"
#include "nodes/testing/closed_loop.h"
#include "nodes/testing/simulated_world.h"
#include "program/slowed.h"
#include "world/picture.h"

namespace {

using namespace ctn::navigation;

constexpr std::size_t kNodes = kNodeNames.size();

struct Sample {
  double time;  // seconds
  Work work;
};

struct Published {
  double mean;  // ms
  double p95;
};
constexpr std::array<Published, kNodes> kPublished{
    {{1.2, 1.2}, {1.2, 1.2}, {1.0, 1.0}, {2.52, 9.18}, {143, 291}, {140, 197.5}, {1.2, 1.2}}};

double cpu_time() { return std::chrono::duration<double>(ctn::program::thread_cpu_time()).count(); }

constexpr std::size_t kFeatures = 6;

std::array<double, kFeatures> features(const Work& work) {
  return {1.0,
          static_cast<double>(work.beams),
          static_cast<double>(work.cells),
          static_cast<double>(work.candidates),
          static_cast<double>(work.expanded),
          static_cast<double>(work.poses)};
}

// All subsets of the factors are tried, since there are few: the best one without a negative factor is the fit.
CostFactors fitted(const std::vector<Sample>& samples) {
  const auto rows = static_cast<Eigen::Index>(samples.size());
  double smallest_error = -1.0;
  std::array<double, kFeatures> best{};
  for (unsigned subset = 1; subset < 1U << kFeatures; ++subset) {
    std::vector<std::size_t> used;
    for (std::size_t i = 0; i < kFeatures; ++i) {
      if ((subset >> i & 1U) != 0) used.push_back(i);
    }
    Eigen::MatrixXd matrix(rows, static_cast<Eigen::Index>(used.size()));
    for (Eigen::Index row = 0; row < rows; ++row) {
      const Sample& sample = samples[static_cast<std::size_t>(row)];
      for (std::size_t i = 0; i < used.size(); ++i) {
        matrix(row, static_cast<Eigen::Index>(i)) = features(sample.work)[used[i]] / sample.time;
      }
    }
    const Eigen::VectorXd ones = Eigen::VectorXd::Ones(rows);
    const Eigen::VectorXd factors = matrix.colPivHouseholderQr().solve(ones);
    if (factors.minCoeff() < 0.0) continue;
    const double error = (matrix * factors - ones).squaredNorm();
    if (smallest_error >= 0.0 && error > smallest_error * (1.0 - 1e-6)) continue;
    smallest_error = error;
    best = {};
    for (std::size_t i = 0; i < used.size(); ++i) best[used[i]] = factors[static_cast<Eigen::Index>(i)] * 1e9;
  }
  return {best[0], best[1], best[2], best[3], best[4], best[5]};
}

struct Misfit {
  double median;  // of the relative error
  double p95;
  double sum;  // of all costs, relative to that of all times
};

Misfit misfit_of(const CostFactors& factors, const std::vector<Sample>& samples) {
  std::vector<double> errors;
  double costs = 0.0;
  double times = 0.0;
  for (const Sample& sample : samples) {
    const double computed = cost(factors, sample.work);
    errors.push_back(std::abs(computed - sample.time) / sample.time);
    costs += computed;
    times += sample.time;
  }
  const ctn::Summary error = ctn::summarize(errors);
  return {error.p50, error.p95, costs / times};
}

// Unknown cells grey, free ones white, obstacles black; the path and the robot's pose as it knows it darker grey.
void write_map(const testing::ClosedLoop& loop, const Odometry& odometry, const std::string& name) {
  const GlobalMap& map = loop.map();
  std::vector<char> pixels(map.frame.cells());
  std::transform(map.cells.begin(), map.cells.end(), pixels.begin(), [](Cell cell) {
    return static_cast<char>(cell == Cell::kUnknown ? 200 : cell == Cell::kFree ? 255 : 0);
  });
  const auto mark = [&](const Point& point, int size) {
    for (int row = map.frame.row(point.y) - size; row <= map.frame.row(point.y) + size; ++row) {
      for (int column = map.frame.column(point.x) - size; column <= map.frame.column(point.x) + size; ++column) {
        if (map.frame.inside(column, row)) pixels[map.frame.index(column, row)] = 90;
      }
    }
  };
  for (const Point& point : loop.path().points) mark(point, 1);
  for (const Keyframe& keyframe : *loop.localization().keyframes) mark(position(keyframe.pose), 0);
  mark(position(loop.localization().pose_at(odometry)), 5);
  std::ofstream out(name, std::ios::binary);
  out << "P5\n" << map.frame.width << " " << map.frame.height << "\n255\n";
  for (int row = map.frame.height - 1; row >= 0; --row) {
    out.write(pixels.data() + map.frame.index(0, row), map.frame.width);
  }
}

void print_costs(const std::array<std::vector<Sample>, kNodes>& measured) {
  fmt::print("\nnode   runs  mean ms   p95 ms  published mean, p95   cost() off by: median    p95    sum\n");
  for (std::size_t node = 0; node < kNodes; ++node) {
    const std::vector<Sample>& samples = measured[node];
    std::vector<double> times;
    for (const Sample& sample : samples) times.push_back(sample.time * 1e3);
    const ctn::Summary time = ctn::summarize(times);
    const Misfit misfit = misfit_of(kCostFactors[node], samples);
    fmt::print("{:<5} {:>5} {:>8.3f} {:>8.3f} {:>12.2f} {:>7.2f} {:>23.0f} % {:>4.0f} % {:>+4.0f} %\n",
               kNodeNames[node], samples.size(), time.mean, time.p95, kPublished[node].mean, kPublished[node].p95,
               misfit.median * 100.0, misfit.p95 * 100.0, (misfit.sum - 1.0) * 100.0);
  }
  fmt::print("\nfitted to these runs, in ns:\n");
  for (std::size_t node = 0; node < kNodes; ++node) {
    const CostFactors factors = fitted(measured[node]);
    const Misfit misfit = misfit_of(factors, measured[node]);
    fmt::print(
        "    {{{:.0f}, {:.2f}, {:.3f}, {:.3f}, {:.2f}, {:.2f}}},  // {}; off by {:.0f} %, p95 {:.0f} %, sum {:+.0f} "
        "%\n",
        factors.run, factors.beam, factors.cell, factors.candidate, factors.expanded, factors.pose, kNodeNames[node],
        misfit.median * 100.0, misfit.p95 * 100.0, (misfit.sum - 1.0) * 100.0);
  }
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("What the navigation app's nodes cost, and whether they find their way.");
  std::string map = "apps/navigation/worlds/map2.yaml";
  std::string pictures;
  double seconds = 900.0;
  bool no_movers = false;
  world::WorldOptions options;
  app.add_option("--map", map, "File of a world")->capture_default_str();
  app.add_option("--seconds", seconds, "The longest drive, in virtual time")->capture_default_str();
  app.add_option("--seed", options.seed, "Of noise, drift and phases")->capture_default_str();
  app.add_flag("--no-movers", no_movers, "Leave out what moves");
  app.add_option("--pictures", pictures, "Every 20 s, draw the world (PNG) and the robot's map (PGM) into this folder");
  CLI11_PARSE(app, argc, argv);
  ctn::Result<world::WorldFile> file = world::read_world(map);
  if (!file) {
    fmt::print(stderr, "{}\n", file.error().message());
    return file.error().kind() == ctn::ErrorKind::kCaller ? 2 : 1;
  }
  if (no_movers) file->movers.clear();

  std::array<std::vector<Sample>, kNodes> measured;
  testing::SimulatedWorld plant(*file, options);
  testing::ClosedLoop loop(plant, file->goal, [&](const char* name, const std::function<Work()>& run) {
    const auto node = static_cast<std::size_t>(std::find(kNodeNames.begin(), kNodeNames.end(), std::string(name)) -
                                               kNodeNames.begin());
    const double begin = cpu_time();
    const Work work = run();
    const double time = cpu_time() - begin;
    if (!(work == Work{})) measured[node].push_back({time, work});
  });

  world::World& world = plant.world();
  std::optional<double> explored_at;
  double next_picture = 1.0;
  std::vector<double> errors;  // of the pose, each second
  loop.run(seconds, [&] {
    if (plant.time() + 1e-9 >= next_picture) {
      const world::Score score = world.score();
      const double error = distance(position(loop.localization().pose_at(plant.odometry())), position(world.truth()));
      errors.push_back(error);
      if (file->explore() && !explored_at && score.explored >= 0.9) explored_at = plant.time();
      if (!pictures.empty() && std::fmod(next_picture, 20.0) < 1.5 && std::fmod(next_picture, 20.0) > 0.5) {
        const std::string name = fmt::format("{}/{:04.0f}", pictures, next_picture);
        if (!ctn::navigation::world::write_picture(world, name + ".png")) fmt::print(stderr, "no picture {}\n", name);
        write_map(loop, plant.odometry(), name + ".pgm");
        fmt::print(stderr, "{:.0f} s, {:.1f} % seen, {} contacts, {:.0f} m, off by {:.2f} m, {} keyframes, {} loops\n",
                   plant.time(), score.explored * 100.0, score.contacts.size(), score.travelled, error,
                   loop.localization().keyframes->size(), loop.localization().loops);
      }
      next_picture += 1.0;
    }
    return world.score().reached_at.has_value();
  });

  const world::Score score = world.score();
  const ctn::Summary error = ctn::summarize(errors);
  fmt::print(
      "{}, seed {}: {:.0f} s, {:.0f} m driven, {} contacts, {} keyframes, {} loops closed\n"
      "pose off by {:.2f} m on average, p95 {:.2f} m, at most {:.2f} m\n",
      file->name, options.seed, plant.time(), score.travelled, score.contacts.size(),
      loop.localization().keyframes->size(), loop.localization().loops, error.mean, error.p95, error.max);
  for (const world::Contact& contact : score.contacts) {
    fmt::print("contact with {} at {:.1f} s, {:.2f} {:.2f}, robot at {:.2f} m/s\n",
               contact.mover ? fmt::format("mover {}", *contact.mover) : "a wall",
               std::chrono::duration<double>(contact.at).count(), contact.pose.x, contact.pose.y, contact.speed);
  }
  if (file->explore()) {
    fmt::print("{:.1f} % seen{}{}\n", score.explored * 100.0,
               explored_at ? fmt::format(", 90 % after {:.0f} s", *explored_at) : "",
               loop.explored() ? ", nothing left that GP knows of" : "");
  } else {
    fmt::print("{}\n", score.reached_at ? "goal reached" : "goal not reached");
  }
  print_costs(measured);
  return 0;
}
