#include "graph/app.h"

#include <gmock/gmock.h>

#include "graph/build.h"
#include "graph/testing/spec_text.h"

namespace ctn::graph {
namespace {

using testing::ElementsAre;
using namespace std::chrono_literals;

App navigation() {
  AppSpec spec = spec_of({"scan", "LM", "LP", "GL", "GM", "GP", "NC", "base"},
                         {"scan LM LP base", "scan GL GM GP NC LP", "GL GP", "GL NC"});
  node(spec, "base").external = true;
  spec.subchains = {subchain("local", "scan LM LP")};
  spec.objective = {response("scan LM LP base", 1.0), period("GL", 0.5), response("GL NC LP base", 0.005)};
  auto app = build_app(spec);
  EXPECT_TRUE(app.ok()) << app.error().message();
  return std::move(*app);
}

std::vector<NodeId> path(const App& app, const std::string& names) {
  std::vector<NodeId> ids;
  for (const Name& name : split(names)) ids.push_back(*app.graph.find_node(name.value));
  return ids;
}

std::vector<std::string> names(const App& app, const std::vector<SubchainId>& ids) {
  std::vector<std::string> result;
  for (const SubchainId id : ids) result.push_back(app.graph.subchain(id).name);
  return result;
}

TEST(Graph, CanBeHadWithoutABoundOnARate) {
  AppSpec spec = spec_of({"a", "b"}, {"a b"});
  node(spec, "a").min_rate = node(spec, "b").min_rate = At<Rate>{Rate{5.0}, {}};
  spec.objective = {period("a", 1.0)};
  const Graph graph = build_app(spec).value().graph;
  const Graph without = graph.without_min_rate(*graph.find_node("b"));
  EXPECT_EQ(without.nodes()[0].min_rate, Rate{5.0});
  EXPECT_EQ(without.nodes()[1].min_rate, std::nullopt);
  EXPECT_EQ(graph.nodes()[1].min_rate, Rate{5.0});
}

TEST(Graph, FindsByName) {
  const App app = navigation();
  EXPECT_EQ(app.graph.node(*app.graph.find_node("GL")).name, "GL");
  EXPECT_EQ(app.graph.find_node("gl"), std::nullopt);
  EXPECT_EQ(app.graph.subchain(*app.graph.find_subchain("local")).nodes.size(), 3U);
  EXPECT_EQ(app.graph.find_subchain("scan"), std::nullopt);
  EXPECT_TRUE(app.graph.has_edge(*app.graph.find_node("GL"), *app.graph.find_node("NC")));
  EXPECT_FALSE(app.graph.has_edge(*app.graph.find_node("NC"), *app.graph.find_node("GL")));
}

TEST(Graph, SharedEdgesOfPathsAreOneEdge) { EXPECT_EQ(navigation().graph.edges().size(), 10U); }

TEST(Graph, NodesThatNoSubchainNamesAreSubchainsThemselves) {
  const App app = navigation();
  const Subchain& local = app.graph.subchain(*app.graph.find_subchain("local"));
  EXPECT_FALSE(local.implicit);
  EXPECT_EQ(app.graph.node(local.head()).name, "scan");
  EXPECT_EQ(app.graph.node(local.tail()).name, "LP");
  EXPECT_TRUE(app.graph.subchain(*app.graph.find_subchain("GM")).implicit);
  EXPECT_EQ(app.graph.find_subchain("base"), std::nullopt);
}

TEST(Graph, SortsPredecessorsFirstThenAsWritten) {
  const App app = navigation();
  EXPECT_EQ(app.graph.path_name(app.graph.topological_order()), "scan -> LM -> GL -> GM -> GP -> NC -> LP -> base");
}

TEST(ChainElements, AStretchOfOneSubchainIsOneElement) {
  const App app = navigation();
  const auto elements = app.graph.chain_elements(path(app, "scan LM LP base"));
  ASSERT_EQ(elements.size(), 1U);
  EXPECT_EQ(elements[0].nodes, path(app, "scan LM LP"));
  EXPECT_EQ(app.graph.chain_elements(path(app, "GL GM GP NC LP base")).size(), 5U);
}

TEST(ChainElements, ASubchainEnteredAgainCountsAgain) {
  AppSpec spec = spec_of({"A", "X", "B", "C"}, {"A B C", "A X C"});
  spec.subchains = {subchain("S", "A B C")};
  spec.objective = {response("A X C", 1.0)};
  const auto app = build_app(spec);
  ASSERT_TRUE(app.ok()) << app.error().message();
  const auto elements = app->graph.chain_elements(app->objective[0].path);
  ASSERT_EQ(elements.size(), 3U);
  EXPECT_EQ(elements[0].subchain, elements[2].subchain);
}

TEST(ChainElements, AnExternalNodeIsNoneAndEndsAStretch) {
  AppSpec spec = spec_of({"A", "X", "B"}, {"A B", "A X B"});
  node(spec, "X").external = true;
  spec.subchains = {subchain("S", "A B")};
  spec.objective = {response("A X B", 1.0), response("A B", 1.0)};
  const auto app = build_app(spec);
  ASSERT_TRUE(app.ok()) << app.error().message();
  EXPECT_EQ(app->graph.chain_elements(app->objective[0].path).size(), 2U);
  EXPECT_EQ(app->graph.chain_elements(app->objective[1].path).size(), 1U);
}

TEST(ChainElements, UnscheduledNodesAreOneEach) {
  AppSpec spec = spec_of({"IMU", "Int", "Warp"}, {"IMU Int Warp"});
  node(spec, "IMU").unscheduled = node(spec, "Int").unscheduled = true;
  node(spec, "IMU").period = At<Nanos>{5ms, {}};
  spec.objective = {response("IMU Int Warp", 1.0)};
  const auto app = build_app(spec);
  ASSERT_TRUE(app.ok()) << app.error().message();
  const auto elements = app->graph.chain_elements(app->objective[0].path);
  ASSERT_EQ(elements.size(), 3U);
  EXPECT_EQ(elements[0].subchain, std::nullopt);
  EXPECT_TRUE(elements[2].subchain.has_value());
  EXPECT_EQ(app->graph.node(*app->graph.find_node("Int")).period, 5ms) << "it follows the IMU";
}

TEST(App, StealsByWeightThenAsWritten) {
  const App app = navigation();
  EXPECT_DOUBLE_EQ(app.weight_of(*app.graph.find_subchain("local")), 1.005);
  EXPECT_DOUBLE_EQ(app.weight_of(*app.graph.find_subchain("GL")), 0.505);
  EXPECT_DOUBLE_EQ(app.weight_of(*app.graph.find_subchain("GM")), 0.0);
  EXPECT_THAT(names(app, app.steal.priority), ElementsAre("local", "GL", "NC", "GM", "GP"));
}

TEST(App, OrdersSlotsSoThatGiversComeBeforeTheirUsers) {
  const App app = navigation();
  EXPECT_THAT(names(app, app.order), ElementsAre("GL", "NC", "local", "GM", "GP"));
}

TEST(App, OrdersSlotsByTheHeavierChainWhereTwoDisagree) {
  for (const double back : {0.5, 2.0}) {
    AppSpec spec = spec_of({"a", "b", "c", "d"}, {"a d", "b c", "a b", "c d"});
    spec.subchains = {subchain("outer", "a d"), subchain("inner", "b c")};
    spec.objective = {response("a b", 1.0), response("c d", back)};
    const auto app = build_app(spec);
    ASSERT_TRUE(app.ok()) << app.error().message();
    EXPECT_EQ(names(*app, app->order).front(), back > 1.0 ? "inner" : "outer");
  }
}

TEST(Graph, OutputsAreAsFarApartAsAnyBeforeThemInTheSubchain) {
  AppSpec spec = spec_of({"imu", "a", "b", "c", "other"}, {"imu a b c other"});
  spec.subchains = {subchain("line", "a b c")};
  node(spec, "imu").unscheduled = true;
  node(spec, "imu").period = At<Nanos>{5ms, {}};
  node(spec, "imu").output_period = At<Nanos>{20ms, {}};
  node(spec, "b").output_period = At<Nanos>{50ms, {}};
  node(spec, "c").output_period = At<Nanos>{30ms, {}};
  spec.objective = {response("a b c other", 1.0)};
  const Graph graph = build_app(spec).value().graph;
  const auto period = [&](const char* name) { return graph.output_period_up_to(*graph.find_node(name)); };
  EXPECT_EQ(period("imu"), 20ms);
  EXPECT_EQ(period("a"), 0ms) << "what comes later is not its own";
  EXPECT_EQ(period("b"), 50ms);
  EXPECT_EQ(period("c"), 50ms) << "it runs no more often than b emits";
  EXPECT_EQ(period("other"), 0ms) << "of another subchain";
}

// A camera with a clock, one without; image is fed by the first, other by both, alone by nobody.
TEST(Graph, WhoNeedsInputAwaitsItWhereItIsKnownWhenItComes) {
  AppSpec spec = spec_of({"camera", "file", "image", "other", "alone", "free"},
                         {"camera image", "camera other", "file other", "camera free"});
  for (const char* name : {"camera", "file"}) node(spec, name).external = true;
  node(spec, "camera").period = At<Nanos>{std::chrono::milliseconds{33}, {}};
  for (const char* name : {"camera", "image", "other", "alone"}) node(spec, name).needs_input = true;
  spec.objective = {response("image", 1.0)};
  const Graph graph = build_app(spec).value().graph;
  const auto awaits = [](const Graph& of, const char* name) { return of.awaits_input(*of.find_node(name)); };
  EXPECT_FALSE(graph.node(*graph.find_node("camera")).needs_input) << "nobody triggers it";
  EXPECT_TRUE(awaits(graph, "image"));
  EXPECT_FALSE(awaits(graph, "other")) << "the file may give something at any time";
  EXPECT_FALSE(awaits(graph, "alone"));
  EXPECT_FALSE(awaits(graph, "free"));
  const std::vector<NodeId> needing{*graph.find_node("free")};
  const Graph changed = graph.needing_input(needing);
  EXPECT_TRUE(awaits(changed, "free"));
  EXPECT_FALSE(changed.node(*changed.find_node("image")).needs_input);
}

}  // namespace
}  // namespace ctn::graph
