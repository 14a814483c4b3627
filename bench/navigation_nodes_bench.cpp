// What the navigation app's nodes cost: a robot explores an office floor of 46 m x 26 m in virtual time, and each run
// of a node is measured (CPU time of the thread). Prints mean and 95th percentile beside the figures that the authors
// of the paper worked with, the work of a run in units (cost.h) and the time that a unit took.
//
//   navigation_nodes_bench [SECONDS [SEED]]     of virtual time: 300, 1
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <ctime>
#include <map>
#include <string>
#include <vector>

#include "nodes/cost.h"
#include "nodes/testing/closed_loop.h"

namespace {

using namespace ctn::navigation;

struct Measured {
  std::vector<double> times;  // ms
  std::vector<double> units;
};

struct Published {
  const char* node;
  double mean;
  double p95;
};
constexpr Published kPublished[] = {{"scan", 1.2, 1.2}, {"LM", 1.2, 1.2},   {"LP", 1.0, 1.0}, {"GL", 2.52, 9.18},
                                    {"GM", 143, 291},   {"GP", 140, 197.5}, {"NC", 1.2, 1.2}};

double cpu_time() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) * 1e3 + static_cast<double>(now.tv_nsec) * 1e-6;
}

double mean(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return values.empty() ? 0.0 : sum / static_cast<double>(values.size());
}

double p95(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto at = values.begin() + static_cast<std::ptrdiff_t>((values.size() * 95 + 99) / 100 - 1);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

}  // namespace

int main(int argc, char** argv) {
  const double seconds = argc > 1 ? std::strtod(argv[1], nullptr) : 300.0;
  const std::uint64_t seed = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 1;
  std::map<std::string, Measured> measured;
  testing::AnalyticWorld world(testing::office(), {2.0, 13.0, 0.0}, {0.01, 0.01, 0.01, 0.005}, seed);
  testing::ClosedLoop loop(world, std::nullopt, [&](const char* node, const std::function<Work()>& run) {
    const double begin = cpu_time();
    const Work work = run();
    Measured& of_node = measured[node];
    of_node.times.push_back(cpu_time() - begin);
    of_node.units.push_back(units(work));
  });
  loop.run(seconds);

  fmt::print("{:.0f} s, {:.0f} m driven, {} keyframes, {} loops closed, {}{}\n\n", world.time(), world.driven(),
             loop.localization().keyframes->size(), loop.localization().loops,
             loop.explored() ? "all explored" : "not all explored", world.touched() ? ", touched a wall" : "");
  fmt::print("node   runs  mean ms   p95 ms  published mean, p95  mean units  ns a unit\n");
  for (const Published& published : kPublished) {
    const Measured& of_node = measured[published.node];
    const double time = mean(of_node.times);
    const double work = mean(of_node.units);
    fmt::print("{:<5} {:>5} {:>8.3f} {:>8.3f} {:>12.2f} {:>7.2f} {:>11.0f} {:>10.2f}\n", published.node,
               of_node.times.size(), time, p95(of_node.times), published.mean, published.p95, work,
               work > 0.0 ? time * 1e6 / work : 0.0);
  }
  return 0;
}
