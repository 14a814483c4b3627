// How fast a trial (src/trial) is beside the simulator, and how far from it: the same schedule and costs in both, on
// one CPU. Fixed priorities are those of the baseline `verucchi`, frames and owned cores those that the planner makes,
// and what is searched is what sessions have.
//
// Usage: trial_bench [SECONDS [terms]], of virtual time; else 60. With `terms`, each response time and core as well.
// Exit: 0, however slow or far they are.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>

#include "baselines/policies.h"
#include "baselines/verucchi.h"
#include "cases.h"
#include "cpu_seconds.h"
#include "planner/expected.h"
#include "planner/frames.h"
#include "sim/simulation.h"
#include "trial/trial.h"
#include "value_of.h"

namespace {

using namespace ctn;
using bench::cpu_seconds;
using bench::value_of;

constexpr std::uint64_t kSeed = 1;

using bench::Case;

// As at its start: a trial does not follow growth.
model::Workload without_growth(const graph::App& app, model::Workload work) {
  for (std::size_t node = 0; node < app.graph.nodes().size(); ++node) {
    model::NodeWork without = work[NodeId(node)];
    without.growth = 0.0;
    work.set(NodeId(node), without);
  }
  return work;
}

Case at_start(Case of) {
  of.work = without_growth(of.app, std::move(of.work));
  return of;
}

struct Schedule {
  std::string method;
  trial::Schedule schedule;
  sim::Options options;
};

Schedule fixed_priorities(const Case& of, int cores) {
  const model::CostTable costs = of.work.costs(of.app.graph);
  const baselines::RatePlan plan = value_of(baselines::plan_by_verucchi(of.app, costs, {cores, 0.06, 0}));
  trial::Schedule schedule{.cores = cores, .subchains = {}, .frames = {}, .pipelines = {}};
  // The simulator's controllers begin one after the other, and the grids of their triggers with them.
  const sim::MachineCosts machine;
  const Nanos apart = machine.context_switch + machine.dispatch_event;
  for (const baselines::TaskPlan& task : plan.subchains) {
    const auto before = static_cast<Nanos::rep>(schedule.subchains.size());
    schedule.subchains.push_back({.core = task.core,
                                  .priority = task.priority,
                                  .period = std::max(to_nanos(task.period), dispatch::kShortestPeriod),
                                  .phase = before * apart});
  }
  const baselines::Baseline baseline = baselines::make_baseline("verucchi", "verucchi", costs);
  return {"priorities", std::move(schedule), {.policy = baseline.policy, .machine = {.cores = cores}, .slack = 0.06}};
}

Schedule planned(const Case& of, int cores, const std::string& method, const plan::Plan& plan) {
  return {method,
          trial::schedule_of(of.app, plan),
          {.policy = value_of(policy::make_policy("catan")), .machine = {.cores = cores}, .plans = {{Nanos{0}, plan}}}};
}

Schedule in_frames(const Case& of, int cores) {
  return planned(of, cores, "frames",
                 value_of(planner::make_plan_in_frames(of.app, of.work.costs(of.app.graph), {.cores = cores})));
}

// What sessions have: with budgets, and subchains that others trigger.
Schedule searched(const Case& of, int cores) {
  const trial::Samples samples(of.app, of.work, Nanos{0}, kSeed);
  const model::CostTable costs = of.work.costs(of.app.graph);
  return planned(of, cores, "searched",
                 value_of(planner::make_expected_plan(of.app, samples, costs, {.cores = cores, .effort = 0.2})));
}

// Each response time and core: the trial's figure, the simulator's.
void print_terms(const Case& of, const trial::Figures& figures, const sim::Outcome& outcome) {
  std::size_t chain = 0;
  for (std::size_t term = 0; term < of.app.objective.size(); ++term) {
    if (of.app.objective[term].metric != graph::Metric::kResponseTime) continue;
    const sim::ChainOutcome& measured = outcome.chains[chain++];
    fmt::print("    {:<60} {:>9.3f} {:>9.3f} {:>+6.2f} %  n {} {}\n", measured.path, figures.terms[term].mean_ms,
               measured.response_ms.mean, 100.0 * (figures.terms[term].mean_ms / measured.response_ms.mean - 1.0),
               figures.terms[term].count, measured.response_ms.count);
  }
  for (std::size_t core = 0; core < figures.busy.size(); ++core) {
    fmt::print("    core {} busy {:.4f} simulated {:.4f}\n", core, figures.busy[core],
               outcome.cores[core].real_time + outcome.cores[core].ordinary);
  }
}

void measure(const Case& of, const Schedule& by, int seconds, bool terms) {
  auto simulation =
      value_of(sim::Simulation::create(of.app, std::make_unique<sim::DrawnCosts>(of.app, of.work, kSeed), by.options));
  const double began = cpu_seconds();
  const Nanos warm_up = simulation->warm_from() - TimePoint{};
  simulation->run_for(warm_up + std::chrono::seconds{seconds});
  const double simulated = cpu_seconds() - began;
  const sim::Outcome outcome = simulation->outcome();

  const trial::Samples samples(of.app, of.work, Nanos{0}, kSeed);
  const trial::Trial trial(of.app, samples);
  const trial::Options options{.horizon = std::chrono::seconds{seconds}, .warm_up = warm_up};
  constexpr int kRepeats = 20;
  const double before = cpu_seconds();
  trial::Figures figures;
  for (int repeat = 0; repeat < kRepeats; ++repeat) figures = trial.run(by.schedule, options);
  const double tried = (cpu_seconds() - before) / kRepeats;

  const double virtual_seconds = to_millis(warm_up).count() / 1e3 + seconds;
  const auto sim_events = static_cast<double>(simulation->events());
  const auto events = static_cast<double>(figures.events);
  const double off = 100.0 * (figures.objective / outcome.objective.value_or(NAN) - 1.0);
  fmt::print("{:<12} {:<11} {:>5} {:>10.0f} {:>9.0f} {:>10.0f} {:>9.0f} {:>9.2f} {:>10.2f} {:>10.2f} {:>+7.2f} %\n",
             of.name, by.method, by.options.machine.cores, virtual_seconds / tried, virtual_seconds / simulated,
             tried * 1e9 / events, simulated * 1e9 / sim_events, tried * 1e3, figures.objective,
             outcome.objective.value_or(NAN), off);
  if (terms) print_terms(of, figures, outcome);
}

}  // namespace

int main(int argc, char** argv) {
  const int seconds = argc > 1 ? std::max(1, std::atoi(argv[1])) : 60;
  const bool terms = argc > 2 && std::string(argv[2]) == "terms";
  fmt::print("{:<12} {:<11} {:>5} {:>10} {:>9} {:>10} {:>9} {:>9} {:>10} {:>10} {:>9}\n", "app", "schedule", "cores",
             "x real", "sim: x", "ns/event", "sim: ns", "ms", "objective", "sim: obj.", "off by");
  for (const char* name : {"navigation", "vr"}) {
    const Case of = at_start(bench::frozen_case(name));
    for (const int cores : {1, 2, 4}) {
      measure(of, fixed_priorities(of, cores), seconds, terms);
      measure(of, in_frames(of, cores), seconds, terms);
      measure(of, searched(of, cores), seconds, terms);
    }
  }
}
