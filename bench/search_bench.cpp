// What the search for schedules (planner/schedule_search.h) comes to for how much effort: the case studies, or random
// apps (contest_apps.h), on as many cores as one likes. A plan is judged by a long trial with other draws than those
// that it was searched with.
//
//   search_bench                                    the case studies on 1, 2 and 3 cores, at efforts 0.01, 0.1 and 1
//   search_bench --random 80 --cores 1 0.03 0.3 3   how near random apps come to the best that any effort found
//
// Exit: 0; 2 for options that make no sense.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "cases.h"
#include "contest_apps.h"
#include "cpu_seconds.h"
#include "planner/expected.h"
#include "planner/frames.h"
#include "trial/trial.h"
#include "value_of.h"

namespace {

using namespace ctn;
using bench::Case;
using bench::cpu_seconds;
using bench::value_of;

constexpr std::uint64_t kSearchSeed = 1;
constexpr std::uint64_t kJudgeSeed = 1001;
constexpr Nanos kHorizon = std::chrono::seconds{600};

// As half a minute after the start: a trial does not follow growth.
constexpr Nanos kSinceStart = std::chrono::seconds{30};

struct Judged {
  plan::Plan plan;
  double objective = 0.0;  // in ms
  double p95 = 0.0;        // of the term that weighs most, in ms
  double took = 0.0;       // CPU time of planning, in s
};

template <typename MakePlan>
Judged judged(const Case& of, const MakePlan& make_plan) {
  const double began = cpu_seconds();
  Judged result{.plan = value_of(make_plan())};
  result.took = cpu_seconds() - began;
  const trial::Samples samples(of.app, of.work, kSinceStart, kJudgeSeed);
  const trial::Trial trial(of.app, samples);
  const trial::Figures figures = trial.run(trial::schedule_of(of.app, result.plan), {.horizon = kHorizon, .p95 = true});
  std::size_t heaviest = 0;
  for (std::size_t term = 0; term < of.app.objective.size(); ++term) {
    if (of.app.objective[term].weight > of.app.objective[heaviest].weight) heaviest = term;
  }
  result.objective = figures.objective;
  result.p95 = figures.terms[heaviest].p95_ms;
  return result;
}

Judged searched(const Case& of, int cores, double effort) {
  const trial::Samples samples(of.app, of.work, kSinceStart, kSearchSeed);
  return judged(of, [&] {
    return planner::make_expected_plan(of.app, samples, of.work.costs(of.app.graph),
                                       {.cores = cores, .effort = effort});
  });
}

void print(const Case& of, int cores, const std::string& how, const Judged& found) {
  fmt::print("{:<24} {:>5} {:<10} {:>9.1f} {:>10.2f} {:>10.2f} {:>8.2f}\n", of.name, cores, how, 1e3 * found.took,
             found.plan.expected ? found.plan.expected->objective : found.plan.objective, found.objective, found.p95);
}

void search_cases(const std::vector<int>& all_cores, const std::vector<double>& efforts) {
  fmt::print("{:<24} {:>5} {:<10} {:>9} {:>10} {:>10} {:>8}\n", "app", "cores", "effort", "CPU ms", "expected",
             "objective", "p95");
  for (const char* name : {"navigation", "navigation_with_detector", "vr"}) {
    const Case of = bench::frozen_case(name);
    const model::CostTable costs = of.work.costs(of.app.graph);
    for (const int cores : all_cores) {
      print(of, cores, "frames",
            judged(of, [&] { return planner::make_plan_in_frames(of.app, costs, {.cores = cores}); }));
      for (const double effort : efforts) print(of, cores, fmt::format("{}", effort), searched(of, cores, effort));
    }
  }
}

struct RandomApp {
  std::uint64_t seed = 0;
  int cores = 1;
  std::vector<Judged> by_effort;
};

std::vector<RandomApp> search_random(int count, std::uint64_t first, const std::vector<int>& all_cores,
                                     const std::vector<double>& efforts) {
  std::vector<RandomApp> apps;
  for (const int cores : all_cores) {
    for (std::uint64_t seed = first; seed < first + static_cast<std::uint64_t>(count); ++seed) {
      const Case of = bench::case_of(bench::random_app(seed));
      RandomApp& app = apps.emplace_back(RandomApp{.seed = seed, .cores = cores, .by_effort = {}});
      for (const double effort : efforts) app.by_effort.push_back(searched(of, cores, effort));
    }
  }
  return apps;
}

// To the best that any of the efforts found.
void print_effort(const std::vector<RandomApp>& apps, int cores, std::size_t effort, double asked) {
  double took = 0.0;
  double logs = 0.0;
  double p95_logs = 0.0;
  int near_best = 0;
  std::vector<std::pair<double, std::uint64_t>> ratios;
  for (const RandomApp& app : apps) {
    if (app.cores != cores) continue;
    const Judged& found = app.by_effort[effort];
    const Judged& best = *std::min_element(app.by_effort.begin(), app.by_effort.end(),
                                           [](const Judged& a, const Judged& b) { return a.objective < b.objective; });
    const double ratio = found.objective / best.objective;
    took += found.took;
    logs += std::log(ratio);
    p95_logs += std::log(found.p95 / best.p95);
    near_best += ratio <= 1.01 ? 1 : 0;
    ratios.emplace_back(ratio, app.seed);
  }
  std::sort(ratios.rbegin(), ratios.rend());
  std::string worst;
  constexpr std::size_t kWorst = 5;
  for (std::size_t at = 0; at < std::min(ratios.size(), kWorst); ++at) {
    worst += fmt::format(" {:.2f} ({})", ratios[at].first, ratios[at].second);
  }
  const auto count = static_cast<double>(ratios.size());
  fmt::print("{:>5} {:<10} {:>9.1f} {:>9.4f} {:>9.4f} {:>9.1f} % {}\n", cores, asked, 1e3 * took / count,
             std::exp(logs / count), std::exp(p95_logs / count), 100.0 * near_best / count, worst);
}

void print_random(const std::vector<RandomApp>& apps, const std::vector<int>& all_cores,
                  const std::vector<double>& efforts) {
  fmt::print("{:>5} {:<10} {:>9} {:>9} {:>9} {:>11}  {}\n", "cores", "effort", "CPU ms", "geo. mean", "p95",
             "within 1 %", "worst (app seed)");
  for (const int cores : all_cores) {
    for (std::size_t effort = 0; effort < efforts.size(); ++effort) print_effort(apps, cores, effort, efforts[effort]);
  }
}

void print_json(const std::vector<RandomApp>& apps, const std::vector<double>& efforts) {
  nlohmann::ordered_json entries = nlohmann::ordered_json::array();
  for (const RandomApp& app : apps) {
    for (std::size_t effort = 0; effort < efforts.size(); ++effort) {
      const Judged& found = app.by_effort[effort];
      entries.push_back({{"app_seed", app.seed},
                         {"cores", app.cores},
                         {"effort", efforts[effort]},
                         {"cpu_ms", 1e3 * found.took},
                         {"objective_ms", found.objective},
                         {"p95_ms", found.p95}});
    }
  }
  fmt::print("{}\n", nlohmann::ordered_json{{"catan", 1}, {"entries", entries}}.dump());
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<double> efforts{0.01, 0.1, 1.0};
  std::vector<int> cores{1, 2, 3};
  int random = 0;
  std::uint64_t first = 1;
  bool json = false;
  CLI::App options{"How good a schedule the search finds for how much effort"};
  options.add_option("efforts", efforts, "As of catan plan --effort")->capture_default_str();
  options.add_option("--cores", cores, "On how many")
      ->allow_extra_args(false)
      ->delimiter(',')
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  options.add_option("--random", random, "So many random apps in place of the case studies")
      ->check(CLI::Range(0, 10000));
  options.add_option("--first", first, "Seed of the first random app")->capture_default_str();
  options.add_flag("--json", json, "Every figure of random apps as one JSON document");
  try {
    options.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return options.exit(error) == 0 ? 0 : 2;
  }
  if (random == 0) {
    search_cases(cores, efforts);
    return 0;
  }
  const std::vector<RandomApp> apps = search_random(random, first, cores, efforts);
  if (json) {
    print_json(apps, efforts);
  } else {
    print_random(apps, cores, efforts);
  }
}
