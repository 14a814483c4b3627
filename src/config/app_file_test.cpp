// What a right app file means, and that no text at all does harm. What wrong ones are told is in tests/malformed.
#include "config/app_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "config/yaml.h"

namespace ctn::config {
namespace {

using testing::ElementsAre;
using namespace std::chrono_literals;

constexpr std::string_view kNavigation = R"(catan: 1
app: navigation
nodes:
  scan: {}
  odometry: { unscheduled: true, period: 20ms }
  LM: { min_rate: 5Hz }
  LP: {}
  GL: { input: queue, modes: [skip, match], output_period: 667ms, max_threads: 2, fallback_rate: 10Hz }
  GP: { max_rate: 1Hz }
  base: { external: true }
edges:
  - scan -> LM -> LP->base
  - scan -> GL -> GP -> LP
  - odometry -> LM
subchains:
  local: [scan, LM, LP]
objective:
  - { response_time: [scan, LM, LP, base], weight: 1.0, max: 60ms }
  - { period: GL, weight: 0.5 }
order: [GL, local, GP]
steal: { priority: [local, GP, GL], off: [GP] }
scheduler: { slack: 5%, frames: fixed, min_slice: 2ms, window: 20, percentile: 99.5, bootstrap: 0s, bootstrap_cost: 3ms, replan: 500ms, planner: paper, schedule: frames }
)";

graph::App parsed(std::string_view text) {
  auto app = parse_app(text, "app.yaml");
  EXPECT_TRUE(app.ok()) << app.error().message();
  return std::move(*app);
}

const graph::Node& node(const graph::App& app, std::string_view name) {
  return app.graph.node(*app.graph.find_node(name));
}

TEST(AppFile, ReadsKindsOfCores) {
  const auto app = parse_app(
      "catan: 1\napp: demo\ncores: { big: { count: 2 }, little: { count: 4, speed: 0.45 }, spare: {} }\n"
      "nodes: { a: {} }\nobjective: [{ period: a, weight: 1 }]\n",
      "app.yaml");
  ASSERT_TRUE(app.ok()) << app.error().message();
  const std::vector<graph::CoreKind> expected{{"big", 2, 1.0}, {"little", 4, 0.45}, {"spare", 1, 1.0}};
  EXPECT_EQ(app->core_kinds, expected);
  EXPECT_EQ(app->core_count(), 7);
  EXPECT_EQ(app->kind_of(1), 0U);
  EXPECT_EQ(app->kind_of(2), 1U);
  EXPECT_EQ(app->kind_of(6), 2U);
  EXPECT_EQ(app->cores_by_kind(3), (std::vector<int>{2, 1, 0}));
}

TEST(AppFile, ReadsExclusiveGroups) {
  const std::string nodes = "catan: 1\napp: demo\nnodes: { a: {}, b: {}, c: {}, d: {} }\n";
  const std::string objective = "objective: [{ period: a, weight: 1 }]\n";
  const auto app = parse_app(nodes + "exclusive: { spinner: [a, c], timers: [d, b] }\n" + objective, "app.yaml");
  ASSERT_TRUE(app.ok()) << app.error().message();
  ASSERT_EQ(app->exclusive.size(), 2U);
  EXPECT_EQ(app->exclusive[1].name, "timers");
  EXPECT_EQ(app->exclusive[1].nodes, (std::vector<NodeId>{NodeId(3), NodeId(1)}));
  EXPECT_EQ(node(*app, "c").exclusive, 0U);
  EXPECT_EQ(app->excluded_by(SubchainId(0)), (std::vector<SubchainId>{SubchainId(2)}));
  const auto refused = parse_app(nodes + "exclusive: [a, b]\n" + objective, "app.yaml");
  ASSERT_FALSE(refused.ok());
  EXPECT_THAT(refused.error().message(), testing::HasSubstr("app.yaml:4:12: exclusive: "));
}

TEST(AppFile, ReadsNodes) {
  const graph::App app = parsed(kNavigation);
  EXPECT_EQ(app.name, "navigation");
  EXPECT_EQ(app.graph.nodes().size(), 7U);
  EXPECT_EQ(app.graph.edges().size(), 7U);
  const graph::Node& gl = node(app, "GL");
  EXPECT_EQ(gl.input, graph::InputKind::kQueue);
  EXPECT_THAT(gl.modes, ElementsAre("skip", "match"));
  EXPECT_EQ(gl.output_period, 667ms);
  EXPECT_EQ(gl.max_threads, 2);
  EXPECT_EQ(gl.fallback_rate, Rate{10.0});
  EXPECT_EQ(node(app, "LM").min_rate, Rate{5.0});
  EXPECT_EQ(node(app, "GP").max_rate, Rate{1.0});
  EXPECT_EQ(node(app, "scan").max_threads, 1);
  EXPECT_TRUE(node(app, "base").external);
  EXPECT_TRUE(node(app, "odometry").unscheduled);
  EXPECT_EQ(node(app, "odometry").period, 20ms);
}

TEST(AppFile, ReadsWhatMayTriggerASubchain) {
  const auto trigger_of = [](const std::string& word) {
    const graph::App app = parsed("catan: 1\napp: t\nnodes:\n  s: { unscheduled: true, period: 5ms }\n  a: { " + word +
                                  " }\nedges: [ s -> a ]\nobjective: [ { period: a, weight: 1 } ]\n");
    return node(app, "a").trigger;
  };
  EXPECT_EQ(trigger_of(""), graph::TriggerBy::kAny);
  EXPECT_EQ(trigger_of("trigger: time"), graph::TriggerBy::kTime);
  EXPECT_EQ(trigger_of("trigger: arrival"), graph::TriggerBy::kArrival);
  EXPECT_EQ(trigger_of("trigger: any"), graph::TriggerBy::kAny);
}

TEST(AppFile, ReadsAgeLimitsOfEdgesAndOfWholePaths) {
  std::string text(kNavigation);
  text.replace(text.find("  - odometry -> LM\n"), 19,
               "  - { path: odometry -> LM, max_age: 50ms, on_stale: skip }\n"
               "  - path: scan -> GL -> GP\n"
               "    max_age: 1.5s\n"
               "  - { path: GP -> LP, max_age: 2s, on_stale: run }\n");
  const graph::App app = parsed(text);
  const auto limit = [&](std::string_view from, std::string_view to) {
    return app.graph.age_limit(*app.graph.find_node(from), *app.graph.find_node(to));
  };
  EXPECT_EQ(app.graph.edges().size(), 7U) << "a limit may be written apart from the path that has the edge";
  EXPECT_EQ(limit("odometry", "LM"), (graph::AgeLimit{50ms, graph::OnStale::kSkip}));
  EXPECT_EQ(limit("scan", "GL"), (graph::AgeLimit{1500ms, graph::OnStale::kRun}));
  EXPECT_EQ(limit("GL", "GP"), (graph::AgeLimit{1500ms, graph::OnStale::kRun}));
  EXPECT_EQ(limit("GP", "LP"), (graph::AgeLimit{2s, graph::OnStale::kRun}));
  EXPECT_EQ(limit("scan", "LM"), std::nullopt);
  EXPECT_EQ(limit("LM", "scan"), std::nullopt) << "there is no such edge";
}

TEST(AppFile, ReadsObjectiveAndRankings) {
  const graph::App app = parsed(kNavigation);
  const auto id = [&](std::string_view name) { return *app.graph.find_subchain(name); };
  ASSERT_EQ(app.objective.size(), 2U);
  EXPECT_EQ(app.graph.path_name(app.objective[0].path), "scan -> LM -> LP -> base");
  EXPECT_EQ(app.objective[0].max, 60ms);
  EXPECT_EQ(app.objective[1].metric, graph::Metric::kPeriod);
  EXPECT_EQ(app.objective[1].weight, 0.5);
  EXPECT_THAT(app.order, ElementsAre(id("GL"), id("local"), id("GP")));
  EXPECT_THAT(app.steal.priority, ElementsAre(id("local"), id("GP"), id("GL")));
  EXPECT_THAT(app.steal.off, ElementsAre(id("GP")));
}

TEST(AppFile, ReadsSchedulerOptions) {
  const graph::SchedulerOptions options = parsed(kNavigation).scheduler;
  EXPECT_EQ(options.slack, 0.05);
  EXPECT_EQ(options.frames, graph::FrameMode::kFixed);
  EXPECT_EQ(options.min_slice, 2ms);
  EXPECT_EQ(options.window, 20);
  EXPECT_EQ(options.percentile, 99.5);
  EXPECT_EQ(options.bootstrap, 0ms);
  EXPECT_EQ(options.bootstrap_cost, 3ms);
  EXPECT_EQ(options.replan, 500ms);
  EXPECT_EQ(options.planner, graph::PlannerKind::kPaper);
  EXPECT_EQ(options.schedule, graph::ScheduleKind::kFrames);
}

TEST(AppFile, DefaultsAreThoseOfTheDocumentation) {
  const graph::App app = parsed(
      "catan: 1\napp: one\nnodes: { loop: {} }\nobjective: [ { period: loop, weight: 1 } ]\nscheduler: { slack: auto "
      "}\n");
  EXPECT_EQ(app.scheduler.slack, std::nullopt);
  EXPECT_EQ(app.scheduler.frames, graph::FrameMode::kElastic);
  EXPECT_EQ(app.scheduler.window, 50);
  EXPECT_EQ(app.scheduler.planner, graph::PlannerKind::kAuto);
  EXPECT_EQ(app.scheduler.schedule, graph::ScheduleKind::kAuto);
  EXPECT_EQ(app.order.size(), 1U);
  EXPECT_TRUE(app.steal.off.empty());
}

TEST(AppFile, TakesByteOrderMarksAndWindowsLineEnds) {
  std::string text = "\xEF\xBB\xBF" + std::string(kNavigation);
  EXPECT_TRUE(parse_app(text, "app.yaml").ok());
  for (std::size_t at = 0; (at = text.find('\n', at)) != std::string::npos; at += 2) text.replace(at, 1, "\r\n");
  EXPECT_TRUE(parse_app(text, "app.yaml").ok());
}

TEST(AppFile, LoadsTheTextTogetherWithTheAppThatItSays) {
  const std::string path = testing::TempDir() + "catan_app_file_" + std::to_string(::getpid()) + ".yaml";
  std::ofstream(path) << kNavigation;
  const auto file = load_app_file(path);
  std::filesystem::remove(path);
  ASSERT_TRUE(file.ok()) << file.error().message();
  EXPECT_EQ(file->text, kNavigation);
  EXPECT_EQ(file->app.name, "navigation");
}

TEST(AppFile, SaysWhichFileCannotBeRead) {
  EXPECT_EQ(load_app("/no/such/app.yaml").error().message(),
            "/no/such/app.yaml: cannot be read: No such file or directory; check the path and its rights");
  EXPECT_EQ(load_app("/tmp").error().message(), "/tmp: is a directory; name a file");
}

TEST(Yaml, KnowsWhereThingsStand) {
  const auto root = parse_yaml("a:\n  b: [x, 'y']\n  c:\nd: \"e\"\n", "f", "docs");
  ASSERT_TRUE(root.ok());
  const Entry& a = root->entries[0];
  EXPECT_EQ(a.value.entries[0].place, (Place{"f", 2, 3}));
  EXPECT_EQ(a.value.entries[0].value.items[1].place, (Place{"f", 2, 10}));
  EXPECT_TRUE(a.value.entries[0].value.items[0].verbatim);
  EXPECT_FALSE(a.value.entries[0].value.items[1].verbatim);
  EXPECT_EQ(a.value.entries[1].value.kind, ValueKind::kNull);
  EXPECT_EQ(a.value.entries[1].value.place, (Place{"f", 3, 3}));
}

void check_any(const std::string& text) {
  const auto app = parse_app(text, "any.yaml");
  if (app.ok()) return;
  RC_ASSERT(app.error().kind() == ErrorKind::kCaller);
  for (const Problem& problem : app.error().problems()) {
    RC_ASSERT(problem.place.file == "any.yaml" && problem.place.line >= 1 && problem.place.column >= 1);
    RC_ASSERT(!problem.what.empty() && !problem.hint.empty());
  }
}

RC_GTEST_PROP(AppFileProperty, NoTextDoesHarm, (const std::string& text)) { check_any(text); }

// One slip of the finger in a right file.
RC_GTEST_PROP(AppFileProperty, NoSlipDoesHarm, ()) {
  std::string text(kNavigation);
  const std::string keys = "{}[]:,-> \n\"'#&*!|%@0aA.\t?";
  const int slips = *rc::gen::inRange(1, 4);
  for (int i = 0; i < slips; ++i) {
    const auto at = static_cast<std::size_t>(*rc::gen::inRange(0, static_cast<int>(text.size())));
    const char key = keys[static_cast<std::size_t>(*rc::gen::inRange(0, static_cast<int>(keys.size())))];
    switch (*rc::gen::inRange(0, 3)) {
      case 0:
        text.erase(at, static_cast<std::size_t>(*rc::gen::inRange(1, 20)));
        break;
      case 1:
        text.insert(at, 1, key);
        break;
      default:
        text[at] = key;
    }
  }
  check_any(text);
}

}  // namespace
}  // namespace ctn::config
