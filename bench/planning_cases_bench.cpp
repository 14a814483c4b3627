// The planner's goals, measured: how long plans take and how good they are, beside solvers that others wrote (CBC for
// stage I, Ipopt for stage II), and what planning both stages as one is worth. docs/benchmarks.md says how to read it.
//
// Usage: planning_cases_bench [goals] [many] [solvers] [worth]: these parts only; else all.
// Exit: 0, however slow; 1 if a result is wrong, which is then named on stderr.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <optional>
#include <random>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "config/app_file.h"
#include "config/cost_file.h"
#include "plan/validate.h"
#include "planner/allocation.h"
#include "planner/assemble.h"
#include "planner/planner.h"
#include "planner/random_apps.h"
#include "solvers/cbc_stage_one.h"
#include "solvers/ipopt_stage_two.h"
#include "solvers/rounding.h"

namespace ctn {
namespace {

using planner::Allocation;
using planner::Instance;
using planner::RandomCase;
using planner::Target;

constexpr double kSame = 1e-6;         // solvers agree
constexpr double kTimeout = 60.0;      // s for one program of CBC's
constexpr double kTimesFaster = 20.0;  // the goal against other solvers

int wrong_results = 0;

void wrong(const std::string& what) {
  ++wrong_results;
  fmt::print(stderr, "WRONG: {}\n", what);
}

void progress(const std::string& what) { fmt::print(stderr, "... {}\n", what); }

// ---- Time

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double elapsed_ms() {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

double cpu_ms() { return 1000.0 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

// Milliseconds, the median of so many runs; of fewer where they take longer than a second in all.
double timed(int runs, const std::function<void()>& run, double (*now)() = elapsed_ms) {
  std::vector<double> took;
  double sum = 0.0;
  for (int i = 0; i < runs && (i == 0 || sum < 1000.0); ++i) {
    const double begin = now();
    run();
    took.push_back(now() - begin);
    sum += took.back();
  }
  return median(std::move(took));
}

// ---- Apps

RandomCase from_files(const std::string& stem, int cores) {
  const std::string path = std::string(CATAN_SOURCE_DIR) + "/" + stem;
  auto app = config::load_app(path + ".yaml");
  if (!app) throw std::runtime_error(app.error().message());
  auto costs = config::load_costs(path + ".costs.yaml", *app);
  if (!costs) throw std::runtime_error(costs.error().message());
  return {*std::move(app), *std::move(costs), cores, graph::kDefaultSlack};
}

RandomCase navigation(int cores) { return from_files("bench/cases/navigation", cores); }
RandomCase with_detector(int cores) { return from_files("bench/cases/navigation_with_detector", cores); }
RandomCase vr(int cores) { return from_files("bench/cases/vr", cores); }

// Costs over a range of 1 to 20 ms, about as many chains as subchains, some subchains of two nodes.
std::vector<RandomCase> random_apps(int subchains, int cores, std::uint64_t count) {
  std::vector<RandomCase> apps;
  for (std::uint64_t seed = 1; seed <= count; ++seed) {
    apps.push_back(planner::random_case(
        seed, {.subchains = subchains, .chains = subchains, .dearest = 20.0, .pairs = true}, cores));
  }
  return apps;
}

std::vector<RandomCase> just(RandomCase one) {
  std::vector<RandomCase> apps;
  apps.push_back(std::move(one));
  return apps;
}

Instance instance_of(const RandomCase& any) { return planner::make_instance(any.app, any.costs, any.cores, any.slack); }

std::optional<plan::Plan> planned(const RandomCase& any, planner::Method method, const std::string& name) {
  auto plan = planner::make_plan(any.app, any.costs, {.cores = any.cores, .slack = any.slack, .method = method});
  if (!plan) {
    wrong(fmt::format("{}: no plan: {}", name, plan.error().message()));
    return std::nullopt;
  }
  if (const Status valid = plan::validate(*plan, any.app, any.costs, any.cores); !valid) {
    wrong(fmt::format("{}: an invalid plan: {}", name, valid.error().message()));
    return std::nullopt;
  }
  return *std::move(plan);
}

// ---- 1. Goals

struct Goal {
  double max_ms = 0.0;
  double max_gap = 0.0;  // 0: proven optimal

  std::string text() const {
    if (max_ms <= 0.0) return "-";
    return max_gap > 0.0 ? fmt::format("gap <= {:g} %, {:g} ms", 100.0 * max_gap, max_ms)
                         : fmt::format("optimal, {:g} ms", max_ms);
  }
};

void print_case(const std::string& name, std::size_t apps, const Goal& goal, double typical, double slowest,
                std::size_t optimal, double gap, bool met) {
  fmt::print("{:<40} {:>4} {:>20} {:>9.3f} {:>9.3f} {:>7} {:>8.3g} % {:>7}\n", name, apps, goal.text(), typical,
             slowest, fmt::format("{}/{}", optimal, apps), 100.0 * gap,
             goal.max_ms <= 0.0 ? "-"
             : met              ? "met"
                                : "MISSED");
  std::fflush(stdout);
}

void plan_case(const std::string& name, const Goal& goal, const std::vector<RandomCase>& apps, int runs) {
  progress(name);
  std::vector<double> took;
  std::size_t optimal = 0;
  double gap = 0.0;
  for (const RandomCase& any : apps) {
    const auto plan = planned(any, planner::Method::kJoint, name);
    if (!plan) continue;
    optimal += plan->quality == plan::Quality::kOptimal ? 1 : 0;
    gap = std::max(gap, plan->gap);
    took.push_back(timed(runs, [&] {
      static_cast<void>(planner::make_plan(any.app, any.costs, {.cores = any.cores, .slack = any.slack}));
    }));
  }
  if (took.empty()) return;
  const double typical = median(took);
  const bool met = typical <= goal.max_ms && (goal.max_gap > 0.0 ? gap <= goal.max_gap : optimal == apps.size());
  print_case(name, apps.size(), goal, typical, *std::max_element(took.begin(), took.end()), optimal, gap, met);
}

// The shares alone, of the one allocation that one core leaves.
void shares_case(const std::string& name, const Goal& goal, const RandomCase& any) {
  const Instance instance = instance_of(any);
  const Target free = free_target(instance);
  const std::vector<int> on_the_core(instance.members.size(), 0);
  planner::Planned planned;
  const double took = timed(501, [&] {
    planner::Effort effort;
    planned = plan_shares(instance, free, {on_the_core, on_the_core, on_the_core, 1}, effort);
  });
  const double gap = std::max(0.0, 1.0 - planned.bound / planned.shares.value);
  const bool optimal = gap <= kSame;
  print_case(name, 1, goal, took, took, optimal ? 1 : 0, gap, optimal && took <= goal.max_ms);
}

void goals() {
  fmt::print("Plans, from app and costs to a plan that says how good it is (ms)\n");
  fmt::print("{:<40} {:>4} {:>20} {:>9} {:>9} {:>7} {:>10} {:>7}\n", "case", "apps", "goal", "median", "slowest",
             "optimal", "worst gap", "verdict");
  shares_case("stage II, navigation, 1 core", {0.2, 0.0}, navigation(1));
  shares_case("stage II, VR, 1 core", {0.1, 0.0}, vr(1));
  plan_case("whole plan, navigation, 1 core", {0.2, 0.0}, just(navigation(1)), 501);
  plan_case("whole plan, VR, 1 core (bounds relaxed)", {}, just(vr(1)), 501);
  plan_case("joint, navigation with detector, 2 cores", {2.0, 0.0}, just(with_detector(2)), 201);
  plan_case("joint, 12 subchains on 4 cores", {20.0, 0.0}, random_apps(12, 4, 20), 5);
  plan_case("joint, 20 subchains on 8 cores", {50.0, 0.01}, random_apps(20, 8, 20), 5);
  plan_case("joint, 64 subchains on 16 cores", {250.0, 0.05}, random_apps(64, 16, 10), 3);
}

// ---- 2. Very many subchains

// What re-planning finds changed: each node costs up to a tenth more or less.
RandomCase with_other_costs(RandomCase any, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  for (std::size_t i = 0; i < any.app.graph.nodes().size(); ++i) {
    const double times = 0.9 + 0.2 * static_cast<double>(random() >> 11U) * 0x1.0p-53;
    if (!any.app.graph.node(NodeId(i)).external) any.costs.set(NodeId(i), any.costs[NodeId(i)].times(times));
  }
  return any;
}

void many_case(int subchains, int cores) {
  constexpr std::size_t kEffortAgain = 100'000;  // as policy "catan" re-plans
  const std::string name = fmt::format("{} subchains on {} cores", subchains, cores);
  progress(name);
  std::vector<double> first;
  std::vector<double> again;
  double gap = 0.0;
  double worse_again = 0.0;
  double two_stage = 0.0;  // the sum of how much more it costs
  const std::vector<RandomCase> apps = random_apps(subchains, cores, 5);
  for (const RandomCase& any : apps) {
    const auto plan = planned(any, planner::Method::kJoint, name);
    const auto staged = planned(any, planner::Method::kTwoStage, name + ", two-stage");
    if (!plan || !staged) return;
    if (staged->objective < plan->objective) wrong(name + ": two stages are better than one");
    gap = std::max(gap, plan->gap);
    two_stage += staged->objective / plan->objective - 1.0;
    const planner::Request replanned{.cores = any.cores, .slack = any.slack};
    first.push_back(timed(
        3, [&] { static_cast<void>(planner::make_plan(any.app, any.costs, replanned)); }, cpu_ms));
    const RandomCase other = with_other_costs(any, again.size() + 1);
    const planner::Request request{.cores = other.cores, .slack = other.slack, .effort = kEffortAgain, .warm = &*plan};
    again.push_back(timed(
        5, [&] { static_cast<void>(planner::make_plan(other.app, other.costs, request)); }, cpu_ms));
    const auto fresh = planned(other, planner::Method::kJoint, name);
    const auto warm = planner::make_plan(other.app, other.costs, request);
    if (!fresh || !warm) return wrong(name + ": no plan from the one in force");
    worse_again = std::max(worse_again, warm->objective / fresh->objective - 1.0);
  }
  fmt::print("{:<28} {:>4} {:>9.1f} {:>9.1f} {:>8.2f} % {:>9.1f} {:>9.1f} {:>10.2f} % {:>10.1f} %\n", name, apps.size(),
             median(first), *std::max_element(first.begin(), first.end()), 100.0 * gap, median(again),
             *std::max_element(again.begin(), again.end()), 100.0 * worse_again,
             100.0 * two_stage / static_cast<double>(apps.size()));
  std::fflush(stdout);
}

void many() {
  fmt::print(
      "\nVery many subchains: the first plan, and one from the plan in force where costs changed by a tenth (ms of "
      "CPU)\n");
  fmt::print("{:<28} {:>4} {:>9} {:>9} {:>10} {:>9} {:>9} {:>12} {:>12}\n", "case", "apps", "first", "slowest",
             "worst gap", "again", "slowest", "than first", "two-stage");
  many_case(100, 24);
  many_case(200, 64);
  many_case(256, 64);
}

// ---- 3. Against other solvers

// The bounds scaled as far as it takes for them to hold.
Target target_of(const RandomCase& any, const Instance& instance) {
  const auto plan = planned(any, planner::Method::kJoint, "target");
  return objective_target(instance, plan ? plan->relax_factor * (1.0 + 1e-9) : 1.0);
}

bool limits_hold(const Target& target, const std::vector<planner::Timing>& timings) {
  return std::all_of(target.limits.begin(), target.limits.end(), [&](const planner::Group& limit) {
    return value_of(limit, timings) <= limit.limit * (1.0 + kSame);
  });
}

struct Duel {
  std::vector<double> ours;
  std::vector<double> theirs;
  std::size_t unfinished = 0;  // theirs, within their time
  std::string note;
};

void print_duel(const std::string& name, const Duel& duel) {
  if (duel.ours.empty()) return;
  const double ours = median(duel.ours);
  const double theirs = median(duel.theirs);
  fmt::print("{:<40} {:>4} {:>9.3f} {:>10.2f} {:>8.0f} {:>7}  {}{}\n", name, duel.ours.size(), ours, theirs,
             theirs / ours, theirs >= kTimesFaster * ours ? "met" : "MISSED", duel.note,
             duel.unfinished > 0 ? fmt::format("; {} not finished in {:g} s", duel.unfinished, kTimeout) : "");
  std::fflush(stdout);
}

void against_cbc(const std::string& name, const std::vector<RandomCase>& apps) {
  progress(name + ", and the same by CBC");
  Duel duel;
  double worst = -1.0;
  for (const RandomCase& any : apps) {
    const Instance instance = instance_of(any);
    const Target free = free_target(instance);
    planner::Planned ours;
    duel.ours.push_back(timed(101, [&] {
      planner::Effort effort;
      ours = allocate_by_equal_shares(instance, free, effort);
    }));
    solvers::StageOne theirs;
    duel.theirs.push_back(timed(3, [&] { theirs = solvers::cbc_stage_one(instance, free, kTimeout); }));
    duel.unfinished += theirs.proven ? 0 : 1;
    if (theirs.found && !(ours.found && ours.shares.value <= theirs.value * (1.0 + kSame))) {
      wrong(fmt::format("{}: stage I {} where CBC finds {:.9g}", name,
                        ours.found ? fmt::format("finds {:.9g}", ours.shares.value) : "finds nothing", theirs.value));
    }
    if (ours.found && theirs.found) worst = std::max(worst, ours.shares.value / theirs.value - 1.0);
  }
  duel.note = fmt::format("objective at most {:+.4f} % from CBC's", 100.0 * worst);
  print_duel(name, duel);
}

// The better of the two ways to round that are allowed, if any is.
std::optional<double> rounded_value(const Instance& instance, const Target& target, const Allocation& allocation,
                                    const std::vector<planner::Timing>& relaxed) {
  for (std::size_t i = 0; i < instance.members.size(); ++i) {
    if (allocation.core_of[i] >= 0 && instance.members[i].exact_period > 0.0) return std::nullopt;
  }
  std::optional<double> best;
  for (const solvers::Frame frame : {solvers::Frame::kLongest, solvers::Frame::kShortest}) {
    const std::vector<planner::Timing> timings = solvers::rounded(instance, allocation, relaxed, frame);
    if (!limits_hold(target, timings)) continue;
    const double value = objective_of(instance, timings);
    best = best ? std::min(*best, value) : value;
  }
  return best;
}

void against_ipopt(const std::string& name, const std::vector<RandomCase>& apps) {
  progress(name + ", and the same by Ipopt");
  Duel duel;
  double above = 0.0;
  std::optional<double> below;
  for (const RandomCase& any : apps) {
    const Instance instance = instance_of(any);
    const Target target = target_of(any, instance);
    const Allocation allocation = solvers::dealt(instance);
    planner::Planned ours;
    duel.ours.push_back(timed(501, [&] {
      planner::Effort effort{planner::Request{}.effort};
      ours = plan_shares(instance, target, allocation, effort);
    }));
    solvers::StageTwo theirs;
    duel.theirs.push_back(timed(51, [&] { theirs = solvers::ipopt_stage_two(instance, target, allocation); }));
    if (!theirs.solved || !ours.found) {
      wrong(fmt::format("{}: {} finds no solution", name, ours.found ? "Ipopt" : "stage II"));
      continue;
    }
    if (ours.shares.value < theirs.value * (1.0 - kSame)) {
      wrong(fmt::format("{}: {:.9g} is below the relaxation {:.9g}", name, ours.shares.value, theirs.value));
    }
    above = std::max(above, ours.shares.value / theirs.value - 1.0);
    const auto rounding = rounded_value(instance, target, allocation, theirs.timings);
    if (!rounding) continue;
    if (ours.shares.value > *rounding * (1.0 + kSame)) {
      wrong(fmt::format("{}: {:.9g} is above a rounded relaxation, {:.9g}", name, ours.shares.value, *rounding));
    }
    below = std::max(below.value_or(-1.0), ours.shares.value / *rounding - 1.0);
  }
  duel.note = fmt::format("at most {:+.3f} % from the relaxation; {}", 100.0 * above,
                          below ? fmt::format("at most {:+.3f} % from it rounded", 100.0 * *below)
                                : "rounding it meets no bounds or exact rates");
  print_duel(name, duel);
}

void duels() {
  fmt::print("\nAgainst other solvers (ms; goal: {:g} times faster, never a worse objective)\n", kTimesFaster);
  fmt::print("{:<40} {:>4} {:>9} {:>10} {:>8} {:>7}\n", "case", "apps", "Catan", "other", "ratio", "verdict");
  against_cbc("stage I, navigation, 2 cores", just(navigation(2)));
  against_cbc("stage I, with detector, 2 cores", just(with_detector(2)));
  against_cbc("stage I, 8 subchains on 3 cores", random_apps(8, 3, 10));
  against_cbc("stage I, 12 subchains on 4 cores", random_apps(12, 4, 2));
  against_ipopt("stage II, navigation, 1 core", just(navigation(1)));
  against_ipopt("stage II, VR, 1 core", just(vr(1)));
  against_ipopt("stage II, 6 subchains on 2 cores", random_apps(6, 2, 20));
}

// ---- 4. What joint planning is worth

struct Worth {
  std::string over;
  std::vector<double> percent;  // by app: how much more the other costs

  void add(double other, double joint) { percent.push_back(100.0 * (other / joint - 1.0)); }
  void print() const {
    if (percent.empty()) return;
    double sum = 0.0;
    std::size_t differs = 0;
    for (const double p : percent) {
      sum += p;
      differs += p > 1e-4 ? 1 : 0;
    }
    const auto count = static_cast<double>(percent.size());
    fmt::print("{:<56} {:>4} {:>8.2f} % {:>8.2f} % {:>7.1f} %\n", over, percent.size(), sum / count,
               *std::max_element(percent.begin(), percent.end()), 100.0 * static_cast<double>(differs) / count);
  }
};

struct Worths {
  Worth two_stage{"two-stage: stage I by equal shares, then exact shares", {}};
  Worth longest{"joint's cores, relaxation rounded, longest frame", {}};
  Worth shortest{"joint's cores, relaxation rounded, shortest frame", {}};
  Worth both{"stage I's cores, relaxation rounded, longest frame", {}};
};

std::optional<double> rounded_plan(const Instance& instance, const plan::Plan& plan, solvers::Frame frame) {
  Allocation allocation;
  if (!allocation_of(plan, instance, allocation)) return std::nullopt;
  const Target target = objective_target(instance, 1.0);
  const solvers::StageTwo relaxed = solvers::ipopt_stage_two(instance, target, allocation);
  if (!relaxed.solved) return std::nullopt;
  return objective_of(instance, solvers::rounded(instance, allocation, relaxed.timings, frame));
}

void compare(std::uint64_t seed, Worths& worths) {
  const int subchains = 5 + static_cast<int>(seed % 4);
  const int cores = 2 + static_cast<int>(seed / 4 % 2);
  const RandomCase any =
      planner::random_case(seed, {.subchains = subchains, .chains = subchains, .dearest = 20.0, .pairs = true}, cores);
  const std::string name = fmt::format("seed {} ({} subchains, {} cores)", seed, subchains, cores);
  const auto joint = planned(any, planner::Method::kJoint, name + ", joint");
  if (!joint) return;
  const Instance instance = instance_of(any);
  const auto add = [&](Worth& worth, const std::optional<double>& other) {
    if (!other) return;
    worth.add(*other, joint->objective);
    if (joint->quality == plan::Quality::kOptimal && *other < joint->objective * (1.0 - kSame)) {
      wrong(
          fmt::format("{}: called optimal at {:.9g}, but {} gives {:.9g}", name, joint->objective, worth.over, *other));
    }
  };
  add(worths.longest, rounded_plan(instance, *joint, solvers::Frame::kLongest));
  add(worths.shortest, rounded_plan(instance, *joint, solvers::Frame::kShortest));
  const auto two_stage = planned(any, planner::Method::kTwoStage, name + ", two-stage");
  if (!two_stage) return;
  add(worths.two_stage, two_stage->objective);
  add(worths.both, rounded_plan(instance, *two_stage, solvers::Frame::kLongest));
}

void worth_of_joint() {
  constexpr std::uint64_t kApps = 200;
  progress(fmt::format("joint against other ways to plan, over {} random apps", kApps));
  Worths worths;
  for (std::uint64_t seed = 1; seed <= kApps; ++seed) compare(seed, worths);
  fmt::print("\nWhat other ways to plan cost more than joint, over random apps of 5 to 8 subchains on 2 or 3 cores\n");
  fmt::print("{:<56} {:>4} {:>10} {:>10} {:>9}\n", "instead of joint", "apps", "mean", "worst", "differs");
  for (const Worth* worth : {&worths.two_stage, &worths.longest, &worths.shortest, &worths.both}) worth->print();
}

}  // namespace
}  // namespace ctn

int main(int argc, char** argv) {
  const auto wanted = [&](std::string_view part) {
    return argc < 2 || std::find(argv + 1, argv + argc, part) != argv + argc;
  };
  try {
    if (wanted("goals")) ctn::goals();
    if (wanted("many")) ctn::many();
    if (wanted("solvers")) ctn::duels();
    if (wanted("worth")) ctn::worth_of_joint();
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return EXIT_FAILURE;
  }
  if (ctn::wrong_results > 0) fmt::print("\n{} results are WRONG: see above\n", ctn::wrong_results);
  return ctn::wrong_results == 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}
