// How long a plan takes to make by formulas, to prove and to write. What the search comes to for how much time:
// search_bench.
#include <benchmark/benchmark.h>

#include <cstdlib>
#include <string_view>

#include "config/app_file.h"
#include "config/cost_file.h"
#include "plan/json.h"
#include "plan/validate.h"
#include "planner/formulas.h"
#include "planner/frames.h"
#include "planner/surrogate.h"
#include "planner/testing/random_apps.h"
#include "trial/samples.h"
#include "trial/schedule.h"

namespace ctn {
namespace {

constexpr std::string_view kApp = R"(catan: 1
app: face_tracking
nodes:
  camera: {}
  detect: { max_threads: 4 }
  plan: {}
  motor: { external: true }
edges:
  - camera -> detect -> plan -> motor
subchains:
  track: [camera, detect, plan]
objective:
  - { response_time: [camera, detect, plan, motor], weight: 1.0, max: 100ms }
)";
constexpr std::string_view kCosts = "camera: 25ms\ndetect: 57.5ms\nplan: 1ms\n";

struct FaceTracking {
  FaceTracking()
      : app(config::parse_app(kApp, "app").value()), costs(config::parse_costs(kCosts, "costs", app).value()) {}

  graph::App app;
  model::CostTable costs;
};

plan::Plan made(const FaceTracking& in, int cores) {
  auto plan = planner::make_plan_by_formulas(in.app, in.costs, {.cores = cores});
  if (!plan) std::abort();
  return *std::move(plan);
}

int cores_of(const benchmark::State& state) { return static_cast<int>(state.range(0)); }

void make_plan(benchmark::State& state) {
  const FaceTracking in;
  for (auto _ : state) benchmark::DoNotOptimize(made(in, cores_of(state)));
}
BENCHMARK(make_plan)->ArgName("cores")->Arg(1)->Arg(2)->Arg(16);

void validate(benchmark::State& state) {
  const FaceTracking in;
  const plan::Plan plan = made(in, cores_of(state));
  for (auto _ : state) {
    if (!plan::validate(plan, in.app, in.costs, cores_of(state))) std::abort();
  }
}
BENCHMARK(validate)->ArgName("cores")->Arg(2);

void to_json(benchmark::State& state) {
  const FaceTracking in;
  const plan::Plan plan = made(in, cores_of(state));
  for (auto _ : state) benchmark::DoNotOptimize(plan::to_json(plan, in.app));
}
BENCHMARK(to_json)->ArgName("cores")->Arg(2);

// So many subchains on so many cores: in frames, as while an app runs, with the gap of the paper's stages in percent.
planner::RandomCase large(const benchmark::State& state) {
  const auto subchains = static_cast<int>(state.range(0));
  return planner::random_case(1, {.subchains = subchains, .chains = subchains, .max_cost = 20.0, .pairs = true},
                              static_cast<int>(state.range(1)));
}

void plan_in_frames(benchmark::State& state) {
  const planner::RandomCase any = large(state);
  const planner::FramesRequest request{.cores = any.cores, .slack = any.slack, .steps = planner::kFrameStepsAtRunTime};
  for (auto _ : state) {
    const auto plan = planner::make_plan_in_frames(any.app, any.costs, request);
    if (!plan) std::abort();
    state.counters["objective"] = plan->objective;
  }
}
BENCHMARK(plan_in_frames)
    ->ArgNames({"subchains", "cores"})
    ->Args({5, 2})
    ->Args({8, 3})
    ->Args({12, 4})
    ->Args({20, 8})
    ->Args({64, 16})
    ->Args({256, 64})
    ->Unit(benchmark::kMillisecond);

void guess_a_plan(benchmark::State& state) {
  const planner::RandomCase any = large(state);
  const trial::Samples samples(any.app, trial::MeasuredRuns{}, any.costs);
  const planner::FormulaRequest request{.cores = any.cores, .slack = any.slack};
  for (auto _ : state) {
    const auto plan = planner::make_guessed_plan(any.app, samples, any.costs, request);
    if (!plan) std::abort();
    state.counters["objective"] = plan->objective;
  }
}
BENCHMARK(guess_a_plan)
    ->ArgNames({"subchains", "cores"})
    ->Args({5, 2})
    ->Args({20, 8})
    ->Args({64, 16})
    ->Args({256, 64})
    ->Unit(benchmark::kMillisecond);

// What a search asks thousands of times: one schedule, without the time that it takes to know the app.
void guess_a_schedule(benchmark::State& state) {
  const planner::RandomCase any = large(state);
  const trial::Samples samples(any.app, trial::MeasuredRuns{}, any.costs);
  const auto plan = planner::make_guessed_plan(any.app, samples, any.costs, {.cores = any.cores, .slack = any.slack});
  if (!plan) std::abort();
  const trial::Schedule schedule = trial::schedule_of(any.app, *plan);
  planner::Surrogate surrogate(any.app, samples, any.costs, any.slack);
  for (auto _ : state) benchmark::DoNotOptimize(surrogate(schedule));
}
BENCHMARK(guess_a_schedule)
    ->ArgNames({"subchains", "cores"})
    ->Args({5, 2})
    ->Args({20, 8})
    ->Args({64, 16})
    ->Args({256, 64})
    ->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace ctn
