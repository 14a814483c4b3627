// What the search for schedules (planner/schedule_search.h) comes to for how much effort: the case studies on 1, 2 and
// 3 cores. The plan is judged by a long trial with other draws than those that it was searched with.
//
// Usage: search_bench [EFFORT...]. Exit: 0.
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <ctime>
#include <string>
#include <utility>
#include <vector>

#include "cases.h"
#include "planner/expected.h"
#include "planner/frames.h"
#include "trial/trial.h"
#include "value_of.h"

namespace {

using namespace ctn;
using bench::Case;
using bench::value_of;

constexpr std::uint64_t kSearchSeed = 1;
constexpr std::uint64_t kJudgeSeed = 1001;
constexpr Nanos kHorizon = std::chrono::seconds{600};

// As half a minute after the start: a trial does not follow growth.
constexpr Nanos kSinceStart = std::chrono::seconds{30};

double cpu_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

void judge(const Case& of, int cores, const std::string& how, const plan::Plan& plan, double took) {
  const trial::Samples samples(of.app, of.work, kSinceStart, kJudgeSeed);
  const trial::Trial trial(of.app, samples);
  const trial::Figures figures = trial.run(trial::schedule_of(of.app, plan), {.horizon = kHorizon, .p95 = true});
  std::size_t heaviest = 0;
  for (std::size_t term = 0; term < of.app.objective.size(); ++term) {
    if (of.app.objective[term].weight > of.app.objective[heaviest].weight) heaviest = term;
  }
  fmt::print("{:<24} {:>5} {:<10} {:>9.1f} {:>10.2f} {:>10.2f} {:>8.2f}\n", of.name, cores, how, 1e3 * took,
             plan.expected ? plan.expected->objective : plan.objective, figures.objective,
             figures.terms[heaviest].p95_ms);
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<double> efforts;
  for (int i = 1; i < argc; ++i) efforts.push_back(std::atof(argv[i]));
  if (efforts.empty()) efforts = {0.01, 0.1, 1.0};
  fmt::print("{:<24} {:>5} {:<10} {:>9} {:>10} {:>10} {:>8}\n", "app", "cores", "effort", "CPU ms", "expected",
             "objective", "p95");
  for (const char* name : {"navigation", "navigation_with_detector", "vr"}) {
    const Case of = bench::frozen_case(name);
    const model::CostTable costs = of.work.costs(of.app.graph);
    const trial::Samples samples(of.app, of.work, kSinceStart, kSearchSeed);
    for (const int cores : {1, 2, 3}) {
      double began = cpu_seconds();
      const plan::Plan frames = value_of(planner::make_plan_in_frames(of.app, costs, {.cores = cores}));
      judge(of, cores, "frames", frames, cpu_seconds() - began);
      for (const double effort : efforts) {
        began = cpu_seconds();
        const plan::Plan plan =
            value_of(planner::make_expected_plan(of.app, samples, costs, {.cores = cores, .effort = effort}));
        judge(of, cores, fmt::format("{}", effort), plan, cpu_seconds() - began);
      }
    }
  }
}
