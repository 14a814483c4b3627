// How long a plan takes to make, to prove and to write: what re-planning costs while an app runs.
#include <benchmark/benchmark.h>

#include <cstdlib>
#include <string_view>

#include "config/app_file.h"
#include "config/cost_file.h"
#include "plan/json.h"
#include "plan/validate.h"
#include "planner/planner.h"
#include "planner/random_apps.h"

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
  auto plan = planner::make_plan(in.app, in.costs, {.cores = cores});
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

// So many subchains on so many cores; `gap` in percent, `two_stage` the objective of that method over this one's.
void make_large_plan(benchmark::State& state) {
  const int cores = static_cast<int>(state.range(1));
  const auto subchains = static_cast<int>(state.range(0));
  const planner::RandomCase any =
      planner::random_case(1, {.subchains = subchains, .chains = subchains, .dearest = 20.0, .pairs = true}, cores);
  const planner::Request request{.cores = any.cores, .slack = any.slack};
  auto plan = planner::make_plan(any.app, any.costs, request);
  if (!plan) std::abort();
  for (auto _ : state) benchmark::DoNotOptimize(planner::make_plan(any.app, any.costs, request));
  const auto staged = planner::make_plan(
      any.app, any.costs, {.cores = any.cores, .slack = any.slack, .method = planner::Method::kTwoStage});
  if (!staged) std::abort();
  state.counters["gap"] = 100.0 * plan->gap;
  state.counters["objective"] = plan->objective;
  state.counters["two_stage"] = staged->objective / plan->objective;
}
BENCHMARK(make_large_plan)
    ->ArgNames({"subchains", "cores"})
    ->Args({100, 24})
    ->Args({200, 64})
    ->Args({256, 64})
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace ctn
