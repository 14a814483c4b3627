#include "config/cost_file.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>
#include <unistd.h>

#include <cstdio>
#include <fstream>
#include <string>
#include <vector>

#include "config/app_file.h"

namespace ctn::config {
namespace {

const graph::App& app() {
  static const graph::App kApp = *parse_app(R"(catan: 1
app: demo
nodes:
  camera: { max_threads: 4 }
  GL: { modes: [skip, match] }
  imu: { unscheduled: true, period: 5ms }
  base: { external: true }
edges:
  - camera -> GL -> base
  - imu -> GL
objective:
  - { response_time: [camera, GL, base], weight: 1 }
)",
                                            "app.yaml");
  return kApp;
}

double cost(const model::CostTable& costs, std::string_view node) {
  return costs[*app().graph.find_node(node)].single_thread().count();
}

TEST(CostFile, ReadsAllThreeForms) {
  const auto costs = parse_costs(
      "camera: { threads: { 1: 10ms, 2: 6ms } }\nGL: { modes: { skip: [0.8, 1.1ms], match: [0.2, 9ms] } }\nimu: 20us\n",
      "c.yaml", app());
  ASSERT_TRUE(costs.ok()) << costs.error().message();
  EXPECT_DOUBLE_EQ(cost(*costs, "camera"), 10.0);
  EXPECT_DOUBLE_EQ((*costs)[*app().graph.find_node("camera")].with_threads(2, 4).count(), 6.0);
  EXPECT_DOUBLE_EQ(cost(*costs, "GL"), 0.8 * 1.1 + 0.2 * 9.0);
  EXPECT_DOUBLE_EQ(cost(*costs, "imu"), 0.02);
}

TEST(CostFile, ReadsDistributions) {
  const auto work = parse_workload(
      "camera: { threads: { 1: 10ms, 2: 6ms }, typical: 8ms, grow: 0.5%/s, spikes: [0.01, 5ms] }\n"
      "GL: { modes: { match: [0.2, 9ms], skip: [0.8, 1.1ms, 1ms] }, grow: 2%/s }\n"
      "imu: { cost: 20us, typical: 20us }\n",
      "c.yaml", app());
  ASSERT_TRUE(work.ok()) << work.error().message();
  const auto of = [&](std::string_view node) { return (*work)[*app().graph.find_node(node)]; };
  const model::NodeWork camera{
      model::CostProfile::of_threads({{1, Millis{10}}, {2, Millis{6}}}), {Millis{8}}, 0.005, {0.01, Millis{5}}};
  EXPECT_EQ(of("camera"), camera);
  const model::NodeWork matcher{model::CostProfile::of_modes({{"skip", 0.8, Millis{1.1}}, {"match", 0.2, Millis{9}}}),
                                {Millis{1}, std::nullopt},
                                0.02,
                                {}};
  EXPECT_EQ(of("GL"), matcher) << "modes in the app file's order";
  EXPECT_EQ(of("imu").typical, (std::vector<std::optional<Millis>>{Millis{0.02}}));
}

TEST(CostFile, ReadsWhatRunsWait) {
  const auto work = parse_workload(
      "camera: { threads: { 1: 10ms, 2: 6ms }, wait: 4ms }\n"
      "GL: { modes: { match: [0.2, 9ms], skip: [0.8, 1ms] }, wait: [2ms, 0.5ms] }\n",
      "c.yaml", app());
  ASSERT_TRUE(work.ok()) << work.error().message();
  const NodeId camera = *app().graph.find_node("camera");
  const NodeId matcher = *app().graph.find_node("GL");
  EXPECT_EQ(work->wait(camera), (model::WaitLaw{Millis{4}, std::nullopt}));
  EXPECT_EQ(work->wait(matcher), (model::WaitLaw{Millis{2}, Millis{0.5}}));
  EXPECT_EQ(work->wait(*app().graph.find_node("imu")), model::WaitLaw{});
  const model::CostTable costs = work->costs(app().graph);
  EXPECT_EQ(costs.wait(camera), Millis{4});
  EXPECT_DOUBLE_EQ(cost(costs, "camera"), 10.0) << "a wait costs nothing";
}

TEST(CostFile, ReadsWhatItemsOfBatchesAdd) {
  const graph::App app = *parse_app(
      "catan: 1\napp: a\nnodes: { a: {}, b: { input: queue, modes: [x, y] } }\nedges: [ a -> b ]\n"
      "cores: { big: {}, little: { speed: 0.5 } }\nobjective: [ { response_time: [a, b], weight: 1 } ]\n",
      "app.yaml");
  const NodeId b = *app.graph.find_node("b");
  const auto modes =
      parse_workload("a: 1ms\nb: { modes: { x: [0.5, 1ms], y: [0.5, 3ms] }, per_item: 0.3ms }\n", "c.yaml", app);
  ASSERT_TRUE(modes.ok()) << modes.error().message();
  EXPECT_EQ((*modes)[b].cost.per_item(), Millis{0.3});
  EXPECT_EQ((*modes)[b].cost.single_thread(), Millis{2});
  EXPECT_EQ(modes->costs(app.graph).on(app, 1)[b].per_item(), Millis{0.6});

  const auto kinds = parse_workload(
      "a: 1ms\nb: { kinds: { big: { cost: 1ms, per_item: 0.1ms }, little: { cost: 2ms, per_item: 0.5ms } } }\n",
      "c.yaml", app);
  ASSERT_TRUE(kinds.ok()) << kinds.error().message();
  EXPECT_EQ(kinds->costs(app.graph).on(app, 0)[b].per_item(), Millis{0.1});
  EXPECT_EQ(kinds->costs(app.graph).on(app, 1)[b].per_item(), Millis{0.5});
  EXPECT_FALSE(parse_workload("a: { cost: 1ms, per_item: 1ms }\nb: 1ms\n", "c.yaml", app)) << "a takes no batches";
}

TEST(CostFile, AWaitStandsBesideKindsOfCores) {
  const graph::App app = *parse_app(
      "catan: 1\napp: demo\ncores: { big: { speed: 2 }, little: { count: 3, speed: 0.5 } }\n"
      "nodes: { a: {}, b: {} }\nedges: [a -> b]\nobjective: [{ period: b, weight: 1 }]\n",
      "app.yaml");
  const auto costs =
      parse_costs("a: { cost: 6ms, wait: 3ms }\nb: { wait: 1ms, kinds: { little: 8ms, big: 2ms } }\n", "c.yaml", app);
  ASSERT_TRUE(costs.ok()) << costs.error().message();
  for (std::size_t kind = 0; kind < app.kinds(); ++kind) {
    EXPECT_EQ(costs->on(app, kind).wait(NodeId{0}), Millis{3});
    EXPECT_EQ(costs->on(app, kind).wait(NodeId{1}), Millis{1});
  }
  EXPECT_EQ(costs->on(app, 1)[NodeId{1}].single_thread(), Millis{8});
}

TEST(CostFile, IsPlannedWithWithoutGrowthAndSpikes) {
  const auto plain = parse_costs("camera: 2ms\nGL: 3ms\n", "c.yaml", app());
  const auto lively = parse_costs(
      "camera: { cost: 2ms, grow: 9%/s, spikes: [0.5, 1s] }\nGL: { cost: 3ms, typical: 1ms }\n", "c.yaml", app());
  ASSERT_TRUE(plain.ok() && lively.ok());
  for (const NodeId node : {NodeId{0}, NodeId{1}}) EXPECT_EQ((*plain)[node], (*lively)[node]);
}

TEST(CostFile, UnscheduledNodesAndZeroAreOptionalAndAllowed) {
  const auto costs = parse_costs("camera: 0ms\nGL: 2ms\n", "c.yaml", app());
  ASSERT_TRUE(costs.ok()) << costs.error().message();
  EXPECT_EQ(cost(*costs, "camera"), 0.0);
  EXPECT_EQ(cost(*costs, "imu"), 0.0);
}

TEST(CostFile, NeedNotNameNodesThatSayThemselvesWhatTheyCost) {
  const std::string path = testing::TempDir() + "partial_" + std::to_string(getpid()) + ".costs.yaml";
  const auto load = [&](const char* text) {
    std::ofstream(path) << text;
    return load_partial_workload(path, app());
  };
  const auto partial = load("camera: 2ms\n");
  ASSERT_TRUE(partial.ok()) << partial.error().message();
  EXPECT_EQ(partial->given, (std::vector<bool>{true, false, false, false}));
  EXPECT_EQ(partial->work[NodeId(0)], model::NodeWork::constant(Millis{2}));
  EXPECT_FALSE(load("camara: 2ms\n").ok()) << "as strict as ever with what it names";
  EXPECT_FALSE(load_workload(path, app()).ok());
  EXPECT_FALSE(load_partial_workload(path + ".not", app()).ok());
  static_cast<void>(std::remove(path.c_str()));
}

TEST(CostFile, ReadsCostsOfEachKindOfCores) {
  const graph::App app = *parse_app(
      "catan: 1\napp: demo\ncores: { big: { speed: 2 }, little: { count: 3, speed: 0.5 } }\n"
      "nodes: { a: {}, b: { modes: [x, y] } }\nedges: [a -> b]\nobjective: [{ period: b, weight: 1 }]\n",
      "app.yaml");
  const auto costs = parse_costs(
      "a: 6ms\nb: { kinds: { little: 8ms, big: { modes: { x: [0.5, 1ms], y: [0.5, 3ms] } } } }\n", "c.yaml", app);
  ASSERT_TRUE(costs.ok()) << costs.error().message();
  const NodeId a{0};
  const NodeId b{1};
  EXPECT_EQ((*costs)[a].single_thread().count(), 6.0);
  EXPECT_EQ(costs->on(app, 0)[a].single_thread().count(), 3.0);
  EXPECT_EQ(costs->on(app, 1)[a].single_thread().count(), 12.0);
  EXPECT_EQ((*costs)[b].single_thread().count(), 4.0) << "on a core of speed 1: twice what it is on the first kind";
  EXPECT_EQ(costs->on(app, 0)[b].single_thread().count(), 2.0);
  EXPECT_EQ(costs->on(app, 1)[b].single_thread().count(), 8.0);

  const auto work = parse_workload(
      "a: 6ms\nb: { kinds: { little: { cost: 8ms, typical: 7ms }, big: { cost: 2ms, spikes: [1, 1ms] } } }\n", "c.yaml",
      app);
  ASSERT_TRUE(work.ok()) << work.error().message();
  EXPECT_EQ((*work)[b].spikes.extra, Millis{2}) << "on a core of speed 1";
  EXPECT_EQ(work->on(app, 1)[b].typical.front(), Millis{7});
}

TEST(CostFile, KindsOfCoresMustBeTheApps) {
  const auto costs = parse_costs("camera: { kinds: { big: 1ms } }\nGL: 2ms\n", "c.yaml", app());
  ASSERT_FALSE(costs.ok());
  EXPECT_EQ(costs.error().message(),
            "c.yaml:1:18: camera.kinds: the app does not say that its cores differ; give one cost, or add cores: with "
            "one entry a kind to the app file");
}

TEST(CostFile, RoundedProbabilitiesAreMadeToAddUp) {
  const auto costs =
      parse_costs("camera: 1ms\nGL: { modes: { skip: [0.3333, 3ms], match: [0.6663, 3ms] } }\n", "c.yaml", app());
  ASSERT_TRUE(costs.ok()) << costs.error().message();
  EXPECT_DOUBLE_EQ(cost(*costs, "GL"), 3.0);
}

RC_GTEST_PROP(CostFileProperty, NoTextDoesHarm, (const std::string& text)) {
  for (const std::string& all : {text, "camera: " + text, "GL: { modes: " + text,
                                 "camera: { cost: 1ms, spikes: " + text, "camera: { cost: 1ms, wait: " + text}) {
    const auto costs = parse_costs(all, "any.yaml", app());
    if (costs.ok()) continue;
    for (const Problem& problem : costs.error().problems()) {
      RC_ASSERT(problem.place.line >= 1 && problem.place.column >= 1);
      RC_ASSERT(!problem.what.empty() && !problem.hint.empty());
    }
  }
}

}  // namespace
}  // namespace ctn::config
