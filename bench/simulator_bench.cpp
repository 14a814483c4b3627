// How much faster than life the simulator is, on one CPU, planning included: navigation, and apps that grow, for which
// the cost of an event should hardly do so. docs/simulation.md says how to read it.
//
// Usage: simulator_bench [SECONDS], of simulated time; else 60. Exit: 0, however slow it is.
#include <fmt/format.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <stdexcept>
#include <string>

#include "cases.h"
#include "config/app_file.h"
#include "config/cost_file.h"
#include "cpu_seconds.h"
#include "sim/simulation.h"
#include "value_of.h"

namespace {

using namespace ctn;
using bench::cpu_seconds;
using bench::value_of;

struct Case {
  std::string name;
  graph::App app;
  model::Workload work;
  std::string scheduler;
  int cores = 1;
};

// Rows of three nodes, each fed by the row before, every fourth of which takes turns with it.
Case made_up(int subchains, const std::string& scheduler, int cores) {
  std::string text = "catan: 1\napp: made_up\nnodes:\n";
  std::string edges = "edges:\n";
  std::string named = "subchains:\n";
  std::string objective = "objective:\n";
  std::string costs;
  for (int i = 0; i < subchains; ++i) {
    const int hertz = 10 + 7 * (i % 5);
    text += fmt::format("  a{0}: {{ fallback_rate: {1}Hz }}\n  b{0}: {{}}\n  c{0}: {{}}\n", i, hertz);
    edges += fmt::format("  - a{0} -> b{0} -> c{0}\n", i);
    named += fmt::format("  s{0}: [a{0}, b{0}, c{0}]\n", i);
    objective += fmt::format("  - {{ response_time: [a{0}, b{0}, c{0}], weight: {1} }}\n", i, 1 + i % 3);
    costs +=
        fmt::format("a{0}: 0.3ms\nb{0}: {{ cost: {1}ms, typical: {2}ms }}\nc{0}: 0.4ms\n", i, 2 + i % 4, 1 + i % 4);
  }
  graph::App app = value_of(config::parse_app(text + edges + named + objective, "made_up.yaml"));
  model::Workload work = value_of(config::parse_workload(costs, "made_up.costs.yaml", app));
  return {fmt::format("{} subchains", subchains), std::move(app), std::move(work), scheduler, cores};
}

Case navigation(const std::string& scheduler) {
  bench::Case of = bench::frozen_case("navigation");
  return {of.name, std::move(of.app), std::move(of.work), scheduler, 1};
}

void measure(const Case& of, int seconds) {
  auto simulation = value_of(
      sim::Simulation::create(of.app, std::make_unique<sim::DrawnCosts>(of.app, of.work, 1),
                              {.policy = value_of(policy::make_policy(of.scheduler)), .machine = {.cores = of.cores}}));
  const double before = cpu_seconds();
  simulation->run_for(std::chrono::seconds{seconds});
  const double took = cpu_seconds() - before;
  const auto events = static_cast<double>(simulation->events());
  fmt::print("{:<16} {:<9} {:>5} {:>12.0f} {:>14.0f} {:>10.0f} {:>9}\n", of.name, of.scheduler, of.cores,
             seconds / took, events / seconds, took * 1e9 / events, simulation->outcome().plans_made);
}

}  // namespace

int main(int argc, char** argv) {
  const int seconds = argc > 1 ? std::max(1, std::atoi(argv[1])) : 60;
  fmt::print("{:<16} {:<9} {:>5} {:>12} {:>14} {:>10} {:>9}\n", "app", "scheduler", "cores", "x real time",
             "events/s of it", "ns/event", "plans");
  for (const char* scheduler : {"catan", "default", "fifo"}) measure(navigation(scheduler), seconds);
  for (const char* scheduler : {"default", "catan"}) {
    measure(made_up(10, scheduler, 4), seconds);
    measure(made_up(50, scheduler, 16), seconds);
  }
  for (const char* scheduler : {"default", "catan"}) measure(made_up(200, scheduler, 64), seconds);
}
