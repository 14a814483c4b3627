// What build_app refuses, by section of the spec, and how it says so. The exact messages with places are in
// tests/malformed; here is what can be had only by hand, and one case for each check.
#include "graph/build.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <limits>

#include "base/numbers.h"
#include "graph/testing/spec_text.h"

namespace ctn::graph {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using namespace std::chrono_literals;

AppSpec good_spec() {
  AppSpec spec = spec_of({"scan", "LM", "LP", "GL", "base", "imu"}, {"scan LM LP base", "scan GL LP", "imu LM"});
  node(spec, "base").external = true;
  node(spec, "imu").unscheduled = true;
  node(spec, "imu").period = At<Nanos>{5ms, {}};
  spec.subchains = {subchain("local", "scan LM LP")};
  spec.objective = {response("scan LM LP base", 1.0)};
  return spec;
}

std::string errors_of(const AppSpec& spec) {
  const auto app = build_app(spec);
  if (app.ok()) return "";
  EXPECT_EQ(app.error().kind(), ErrorKind::kCaller);
  return app.error().message();
}

At<Rate> hertz(double rate) { return {Rate{rate}, {}}; }

TEST(BuildApp, TakesWhatIsRight) { EXPECT_EQ(errors_of(good_spec()), ""); }

TEST(BuildApp, RefusesAnEmptySpec) {
  EXPECT_EQ(errors_of({}),
            "nodes: the app has no nodes; name every node under nodes\n"
            "objective: the app has no objective, so that no plan is better than another; add a response_time or a "
            "period with its weight");
}

TEST(BuildApp, ReportsAllInOrderOfPlace) {
  AppSpec spec = good_spec();
  node(spec, "scan").period = At<Nanos>{5ms, {"a.yaml", 9, 1}};
  spec.edges.push_back({{{"scan", {"a.yaml", 3, 1}}, {"LX", {"a.yaml", 3, 9}}}, {"a.yaml", 3, 1}});
  spec.objective[0].weight = {-1.0, {"a.yaml", 3, 5}};
  EXPECT_EQ(errors_of(spec),
            "a.yaml:3:5: objective[0].weight: weight -1 is no number from 0 up; write 0 or more: what one millisecond "
            "counts\n"
            "a.yaml:3:9: edges[3]: there is no node 'LX'; did you mean 'LM'?\n"
            "a.yaml:9:1: nodes.scan.period: period is for unscheduled and external nodes; Catan chooses that of this "
            "one; add "
            "unscheduled: true if it runs by itself, or bound it by min_rate and max_rate");
}

TEST(BuildNodes, RefusesDoubledAndImpossibleNames) {
  AppSpec spec = good_spec();
  spec.nodes.push_back(spec.nodes[0]);
  spec.nodes.emplace_back().name.value = "";
  spec.nodes.emplace_back().name.value = "a -> b";
  spec.nodes.emplace_back().name.value = std::string(101, 'x');
  EXPECT_THAT(
      errors_of(spec),
      AllOf(HasSubstr("nodes.scan: there are two nodes 'scan'"), HasSubstr("nodes[7]: the name of this node is empty"),
            HasSubstr("'a -> b' is no name for this node"), HasSubstr("the name is 101 characters long")));
}

TEST(BuildNodes, RefusesKeysThatTheKindHasNot) {
  AppSpec spec = good_spec();
  node(spec, "base").max_rate = hertz(1);
  node(spec, "base").unscheduled = true;
  node(spec, "imu").min_rate = hertz(1);
  node(spec, "imu").fallback_rate = hertz(1);
  node(spec, "imu").max_threads = At<int>{2, {}};
  EXPECT_THAT(errors_of(spec), AllOf(HasSubstr("nodes.base: the node is both external and unscheduled"),
                                     HasSubstr("nodes.imu.min_rate: an unscheduled node runs by itself"),
                                     HasSubstr("nodes.imu.fallback_rate:"), HasSubstr("nodes.imu.max_threads:")));
  node(spec, "base").unscheduled = false;
  node(spec, "base").modes = split("a b");
  node(spec, "base").input = InputKind::kQueue;
  node(spec, "base").output_period = At<Nanos>{1ms, {}};
  EXPECT_THAT(errors_of(spec), AllOf(HasSubstr("nodes.base.max_rate:"), HasSubstr("nodes.base.modes:"),
                                     HasSubstr("nodes.base.input:"), HasSubstr("nodes.base.output_period:")));
}

TEST(BuildNodes, RefusesWhatNoRunCanHave) {
  AppSpec spec = good_spec();
  node(spec, "GL").max_threads = At<int>{65, {}};
  node(spec, "GL").min_rate = hertz(20'000);
  node(spec, "LM").min_rate = hertz(10'000);
  EXPECT_EQ(errors_of(spec),
            "nodes.GL.max_threads: 65 threads are out of range; write a whole number from 1 to 64\n"
            "nodes.GL.min_rate: 20000Hz cannot be had: nothing is triggered more often than 10000Hz; ask for less");
}

TEST(BuildNodes, RefusesValuesOutOfRange) {
  AppSpec spec = good_spec();
  node(spec, "GL").max_threads = At<int>{0, {}};
  node(spec, "GL").output_period = At<Nanos>{0ms, {}};
  node(spec, "GL").min_rate = hertz(60);
  node(spec, "GL").max_rate = hertz(50);
  node(spec, "GL").modes = split("skip match skip");
  EXPECT_THAT(errors_of(spec), AllOf(HasSubstr("0 threads are out of range"), HasSubstr("output_period must be more"),
                                     HasSubstr("min_rate (60Hz) is above max_rate (50Hz)"),
                                     HasSubstr("nodes.GL.modes[2]: mode 'skip' is named twice")));
}

TEST(BuildEdges, NamesTheCycle) {
  AppSpec spec = good_spec();
  spec.edges.push_back({split("LP GL"), {}});
  EXPECT_THAT(errors_of(spec), HasSubstr("the edges form a cycle: LP -> GL -> LP; remove one of its edges"));
  spec.edges.push_back({split("LP scan"), {}});
  EXPECT_THAT(errors_of(spec), HasSubstr("the edges form a cycle: scan -> LM -> LP -> scan"));
}

TEST(BuildEdges, RefusesAgeLimitsThatMeanNothing) {
  const auto limited = [](const char* path, Nanos max_age) {
    return PathSpec{split(path), {}, At<Nanos>{max_age, {}}, std::nullopt};
  };
  AppSpec spec = good_spec();
  spec.edges.push_back(limited("scan LM", 0ms));
  spec.edges.push_back(limited("LM LP base", 50ms));
  spec.edges.push_back(limited("LM LP", 50ms));
  spec.edges.push_back({split("imu LM"), {}, std::nullopt, At<OnStale>{OnStale::kSkip, {}}});
  EXPECT_THAT(errors_of(spec),
              AllOf(HasSubstr("edges[3].max_age: max_age must be more than 0"),
                    HasSubstr("edges[4].max_age: edge LP -> base cannot have an age limit: 'base' is external"),
                    HasSubstr("edges[5].max_age: edge LM -> LP has an age limit already, by edges[4]"),
                    HasSubstr("edges[6].on_stale: on_stale says what becomes of data that is older than max_age, which "
                              "is missing")));
  spec = good_spec();
  spec.edges.push_back(limited("LM LP", 50ms));
  EXPECT_EQ(errors_of(spec), "") << "the edge was written before: the path gives it a limit";
}

TEST(BuildEdges, RefusesLoopsStubsAndRepeats) {
  AppSpec spec = good_spec();
  spec.edges.push_back({split("GL GL"), {}});
  spec.edges.push_back({split("GL"), {}});
  spec.edges.push_back({split("scan LM LP"), {}});
  EXPECT_THAT(
      errors_of(spec),
      AllOf(HasSubstr("edges[3]: an edge leads from 'GL' to itself"), HasSubstr("edges[4]: a path needs two"),
            HasSubstr("edges[5]: this path adds no edge: all of them were written before, the last in edges[0]")));
}

TEST(BuildEdges, AskForThePeriodOfAnUnscheduledSource) {
  AppSpec spec = good_spec();
  node(spec, "imu").period.reset();
  EXPECT_THAT(errors_of(spec),
              HasSubstr("nodes.imu.period: an unscheduled node that no other unscheduled node feeds needs"));
}

// An app of unscheduled nodes that feed one another, of which `periods` have one of their own, and a scheduled sink.
AppSpec drivers(const std::vector<std::string>& nodes, const std::vector<std::string>& paths,
                const std::vector<std::pair<std::string, Nanos>>& periods) {
  AppSpec spec = spec_of(nodes, paths);
  for (NodeSpec& each : spec.nodes) each.unscheduled = each.name.value != "sink";
  for (const auto& [name, period] : periods) node(spec, name).period = At<Nanos>{period, {}};
  spec.objective = {response("sink", 1.0)};
  return spec;
}

// "imu 5ms": the node that it follows, and its period.
std::string followed_by(const AppSpec& spec, const std::string& name) {
  const auto app = build_app(spec);
  if (!app) return app.error().message();
  const Node& node = app->graph.node(*app->graph.find_node(name));
  const std::string leader = node.follows ? app->graph.node(*node.follows).name : "nobody";
  return leader + " " + std::to_string(std::chrono::duration_cast<std::chrono::milliseconds>(*node.period).count()) +
         "ms";
}

TEST(Followers, FollowTheFastestThatFeedsThem) {
  const AppSpec spec =
      drivers({"slow", "imu", "Int", "sink"}, {"slow Int sink", "imu Int"}, {{"slow", 20ms}, {"imu", 5ms}});
  EXPECT_EQ(followed_by(spec, "Int"), "imu 5ms");
  EXPECT_EQ(followed_by(spec, "imu"), "nobody 5ms");
}

TEST(Followers, OfEqualsTheFirstInput) {
  const auto of = [](const std::vector<std::string>& paths) {
    return drivers({"left", "right", "both", "sink"}, paths, {{"left", 5ms}, {"right", 5ms}});
  };
  EXPECT_EQ(followed_by(of({"left both sink", "right both"}), "both"), "left 5ms");
  EXPECT_EQ(followed_by(of({"right both sink", "left both"}), "both"), "right 5ms");
}

TEST(Followers, APeriodOfItsOwnKeepsTheTimer) {
  EXPECT_EQ(followed_by(drivers({"imu", "Int", "sink"}, {"imu Int sink"}, {{"imu", 5ms}, {"Int", 5ms}}), "Int"),
            "nobody 5ms");
}

TEST(Followers, FormRows) {
  const AppSpec spec = drivers({"B", "A", "imu", "sink"}, {"imu A B sink", "imu B"}, {{"imu", 5ms}});
  EXPECT_EQ(followed_by(spec, "A"), "imu 5ms");
  EXPECT_EQ(followed_by(spec, "B"), "A 5ms") << "the first of its inputs";
}

// A node that emits less often than it runs sets its followers off less often.
TEST(Followers, GoByWhatIsEmitted) {
  AppSpec spec =
      drivers({"imu", "other", "Int", "next", "sink"}, {"imu Int next sink"}, {{"imu", 5ms}, {"other", 10ms}});
  node(spec, "imu").output_period = At<Nanos>{20ms, {}};
  EXPECT_EQ(followed_by(spec, "Int"), "imu 20ms");
  EXPECT_EQ(followed_by(spec, "next"), "Int 20ms");
  spec.edges.push_back({split("other Int"), {}});
  EXPECT_EQ(followed_by(spec, "Int"), "other 10ms");
}

TEST(Followers, AScheduledNodeIsNotFollowed) {
  AppSpec spec = drivers({"camera", "imu", "Int", "sink"}, {"camera Int sink", "imu Int"}, {{"imu", 5ms}});
  node(spec, "camera").unscheduled = false;
  EXPECT_EQ(followed_by(spec, "Int"), "imu 5ms");
}

TEST(BuildSubchains, RefusesWhatIsNoPath) {
  AppSpec spec = good_spec();
  spec.subchains = {subchain("a", "LM scan"), subchain("b", "GL nowhere"), subchain("c", ""), subchain("d", "LP LP")};
  EXPECT_THAT(errors_of(spec),
              AllOf(HasSubstr("no edge leads from 'LM' to 'scan'; write scan before LM: the edge leads that way"),
                    HasSubstr("subchains.b: there is no node 'nowhere'"), HasSubstr("subchains.c: the subchain has no"),
                    HasSubstr("subchains.d: node 'LP' is named twice")));
  spec.subchains = {subchain("a", "scan LP")};
  EXPECT_THAT(errors_of(spec), HasSubstr("no edge leads from 'scan' to 'LP'; add scan -> LP to edges, or split"));
}

TEST(BuildSubchains, RefusesSharedExternalAndUnscheduledNodes) {
  AppSpec spec = good_spec();
  spec.subchains.push_back(subchain("a", "imu LM"));
  spec.subchains.push_back(subchain("b", "LP base"));
  EXPECT_THAT(errors_of(spec),
              AllOf(HasSubstr("node 'imu' is unscheduled, so it can be in no subchain"),
                    HasSubstr("node 'LM' is in subchain 'local' too"), HasSubstr("node 'base' is external")));
}

TEST(BuildSubchains, RefusesClashesOfNames) {
  AppSpec spec = good_spec();
  spec.subchains[0].name.value = "GL";
  EXPECT_THAT(errors_of(spec), HasSubstr("subchains.GL: node 'GL' is a subchain of that name already"));
  spec = good_spec();
  spec.subchains.push_back(subchain("local", "GL"));
  EXPECT_THAT(errors_of(spec), HasSubstr("there are two subchains 'local'"));
  spec = good_spec();
  spec.subchains[0].name.value = "scan";
  EXPECT_EQ(errors_of(spec), "") << "a subchain may be called after one of its own nodes";
}

TEST(BuildSubchains, RefusesAnAppWithNothingToSchedule) {
  AppSpec spec = spec_of({"a"}, {});
  node(spec, "a").external = true;
  EXPECT_THAT(errors_of(spec), HasSubstr("every node is external or unscheduled"));
}

TEST(BuildSubchains, RatesOfOneSubchainMustAgree) {
  AppSpec spec = good_spec();
  node(spec, "LP").max_rate = hertz(50);
  node(spec, "scan").min_rate = hertz(50);
  EXPECT_EQ(errors_of(spec), "");
  node(spec, "LM").min_rate = hertz(51);
  EXPECT_THAT(errors_of(spec), HasSubstr("nodes.LM.min_rate: 51Hz is above the max_rate of 'LP' (50Hz)"));
}

TEST(BuildSubchains, NoNodeRunsMoreOftenThanTheOneBeforeItGivesOutput) {
  AppSpec spec = good_spec();
  node(spec, "LM").output_period = At<Nanos>{700ms, {}};
  node(spec, "LM").min_rate = hertz(5);
  EXPECT_EQ(errors_of(spec), "");
  node(spec, "LP").min_rate = hertz(5);
  EXPECT_EQ(errors_of(spec),
            "nodes.LP.min_rate: 5Hz cannot be had: a node before it in subchain 'local' gives output every 700 ms at "
            "most; lower it, or output_period of the node before");
}

TEST(BuildSubchains, FallbackRatesAreBoundByEachNodeThatRunsAtThem) {
  AppSpec spec = good_spec();
  node(spec, "scan").fallback_rate = hertz(30);
  node(spec, "LP").max_rate = hertz(20);
  EXPECT_EQ(errors_of(spec),
            "nodes.scan.fallback_rate: fallback_rate (30Hz) is above the max_rate of 'LP' (20Hz), which runs at it; "
            "lower it, raise that max_rate, or give LP a fallback_rate, too");
  node(spec, "LM").fallback_rate = hertz(20);
  EXPECT_EQ(errors_of(spec), "") << "LP runs with LM";
  node(spec, "LM").max_rate = hertz(10);
  EXPECT_EQ(errors_of(spec),
            "nodes.LM.fallback_rate: fallback_rate (20Hz) is above max_rate (10Hz); lower it, or raise max_rate");
}

TEST(BuildSubchains, AFallbackRateWithinOneNeedsTheNodesName) {
  AppSpec spec = good_spec();
  node(spec, "LM").fallback_rate = hertz(20);
  spec.subchains[0].name.value = "scan";
  EXPECT_EQ(errors_of(spec), "");
  spec.subchains[0].name.value = "LM";
  EXPECT_EQ(errors_of(spec),
            "nodes.LM.fallback_rate: with a rate of its own, 'LM' begins a subchain 'LM' where rates are set by hand, "
            "but there is one of that name; rename subchains.LM");
}

TEST(BuildSubchains, TriggersByArrivalNeedSomethingThatArrives) {
  const auto by = [](TriggerBy trigger) { return At<TriggerBy>{trigger, {}}; };
  AppSpec spec = good_spec();
  node(spec, "GL").trigger = by(TriggerBy::kArrival);
  EXPECT_EQ(errors_of(spec),
            "nodes.GL.trigger: no unscheduled node feeds 'GL': nothing arrives that could trigger it; "
            "add an edge from one, or write trigger: any");
  node(spec, "GL").trigger = by(TriggerBy::kAny);
  EXPECT_EQ(errors_of(spec), "");
  spec.edges.push_back({split("imu GL"), {}});
  node(spec, "GL").trigger = by(TriggerBy::kArrival);
  EXPECT_EQ(errors_of(spec), "");
  node(spec, "GL").min_rate = hertz(10);
  node(spec, "GL").max_rate = hertz(10);
  EXPECT_THAT(errors_of(spec), HasSubstr("nodes.GL.trigger: subchain 'GL' has an exact rate, which is kept by time"));
  spec = good_spec();
  node(spec, "LM").trigger = by(TriggerBy::kTime);
  node(spec, "imu").trigger = by(TriggerBy::kTime);
  EXPECT_THAT(errors_of(spec), AllOf(HasSubstr("nodes.LM.trigger: only the head of a subchain is triggered by Catan"),
                                     HasSubstr("nodes.imu.trigger: an unscheduled node runs by itself")));
}

TEST(BuildObjective, RefusesPathsThatAreNone) {
  AppSpec spec = good_spec();
  spec.objective = {response("scan LP", 1.0), response("base", 1.0), response("", 1.0), response("scan LM LPP", 1.0)};
  EXPECT_THAT(errors_of(spec),
              AllOf(HasSubstr("objective[0].response_time: no edge leads from 'scan' to 'LP'"),
                    HasSubstr("objective[1].response_time: every node of the path is external"),
                    HasSubstr("objective[2].response_time: the path has no nodes"),
                    HasSubstr("objective[3].response_time: there is no node 'LPP'; did you mean 'LP'?")));
}

TEST(BuildObjective, AClockCountsWhereAPathBeginsOrEnds) {
  AppSpec spec = good_spec();
  spec.edges.push_back({split("base GL"), {}});
  spec.edges.erase(spec.edges.begin() + 1);
  spec.edges.push_back({split("scan LP"), {}});
  spec.objective = {response("scan LM LP base", 1.0), response("base GL", 1.0), response("LP base GL", 1.0)};
  EXPECT_EQ(errors_of(spec), "") << "without a clock it may stand anywhere";
  node(spec, "base").period = At<Nanos>{8ms, {}};
  EXPECT_EQ(errors_of(spec),
            "objective[2].response_time: external node 'base' has a period, and so a clock, which counts only where a "
            "path begins or ends; end the path at base, or remove its period");
  spec.objective.pop_back();
  EXPECT_EQ(errors_of(spec), "");
  node(spec, "base").period = At<Nanos>{0ms, {}};
  EXPECT_THAT(errors_of(spec), HasSubstr("nodes.base.period: period must be more than 0"));
}

TEST(BuildObjective, RefusesPeriodsThatAreNotOurs) {
  AppSpec spec = good_spec();
  spec.objective = {period("imu", 1.0), period("base", 1.0), period("scan LM", 1.0), period("GL", 1.0)};
  spec.objective[3].max = At<Nanos>{20ms, {}};
  EXPECT_THAT(errors_of(spec), AllOf(HasSubstr("node 'imu' is unscheduled: its period is not Catan's to choose"),
                                     HasSubstr("node 'base' is external"), HasSubstr("a period is that of one node"),
                                     HasSubstr("objective[3].max: max bounds a response time; a period is bounded by a "
                                               "rate; write min_rate: 50Hz in nodes.GL")));
}

TEST(BuildObjective, RefusesBadNumbersAndRepeats) {
  AppSpec spec = good_spec();
  spec.objective.push_back(spec.objective[0]);
  spec.objective.push_back(period("GL", std::numeric_limits<double>::quiet_NaN()));
  spec.objective.push_back(period("LM", kInfinity));
  spec.objective[1].max = At<Nanos>{0ms, {}};
  EXPECT_THAT(errors_of(spec), AllOf(HasSubstr("objective[1]: objective[0] is about the same; keep one"),
                                     HasSubstr("max must be more than 0"), HasSubstr("weight nan is no number"),
                                     HasSubstr("weight inf is no number")));
}

// Guards: no plan could be told from another, nor any be made.
TEST(BuildObjective, RefusesWeightsThatAddUpToTooMuch) {
  AppSpec spec = good_spec();
  spec.objective.push_back(period("GL", 9e98));
  At<double>& first = spec.objective[0].weight;
  At<double>& second = spec.objective.back().weight;
  const std::string key = fmt::format("objective[{}].weight: ", spec.objective.size() - 1);
  first = {9e99, {}};
  EXPECT_EQ(errors_of(spec), "");
  second = {2e100, {"a.yaml", 3, 5}};
  EXPECT_EQ(errors_of(spec), "a.yaml:3:5: " + key +
                                 "weight 2e+100 is too large: all weights together may be 1e+100 at most; write "
                                 "smaller ones: only what they are to one another counts");
  first = {std::numeric_limits<double>::max(), {}};
  second = {std::numeric_limits<double>::max(), {}};
  EXPECT_THAT(errors_of(spec), HasSubstr("objective[0].weight: weight 1.7976931348623157e+308 is too large"));
}

TEST(BuildOrder, RankingsNameEverySubchainOnce) {
  AppSpec spec = good_spec();
  spec.order = split("local");
  spec.steal_priority = split("GL local GL");
  spec.steal_off = split("GL GL LM imu loca");
  EXPECT_THAT(errors_of(spec),
              AllOf(HasSubstr("order: 'GL' is not ranked; name every subchain once, or leave order out"),
                    HasSubstr("steal.priority[2]: subchain 'GL' is named twice"),
                    HasSubstr("steal.off[1]: subchain 'GL' is named twice"),
                    HasSubstr("steal.off[2]: node 'LM' is part of subchain 'local'; write local"),
                    HasSubstr("steal.off[3]: node 'imu' is in no subchain"),
                    HasSubstr("steal.off[4]: there is no subchain 'loca'; did you mean 'local'?")));
}

TEST(BuildOrder, KeepsWhatWasWritten) {
  AppSpec spec = good_spec();
  spec.order = split("GL local");
  spec.steal_off = split("GL");
  const auto app = build_app(spec);
  ASSERT_TRUE(app.ok()) << app.error().message();
  EXPECT_EQ(app->graph.subchain(app->order[0]).name, "GL");
  EXPECT_EQ(app->graph.subchain(app->steal.priority[0]).name, "local");
  EXPECT_EQ(app->steal.off, std::vector{*app->graph.find_subchain("GL")});
}

TEST(BuildApp, ExclusiveGroupsHaveTwoNodesOrMoreAndShareNone) {
  AppSpec spec = good_spec();
  spec.exclusive = {{{"spinner", {}}, split("LM GL imu")}};
  EXPECT_EQ(errors_of(spec), "");
  spec.exclusive = {{{"one", {}}, split("LM")}, {{"two", {}}, split("GL base GL")}, {{"two", {}}, split("LM scn")}};
  EXPECT_THAT(errors_of(spec), AllOf(HasSubstr("exclusive.one: an exclusive group needs two nodes or more"),
                                     HasSubstr("exclusive.two: node 'base' is external: nothing is known of its runs"),
                                     HasSubstr("exclusive.two: node 'GL' is named twice"),
                                     HasSubstr("exclusive.two: there are two exclusive groups 'two'"),
                                     HasSubstr("exclusive.two: node 'LM' is in exclusive group 'one' too"),
                                     HasSubstr("exclusive.two: there is no node 'scn'; did you mean 'scan'?")));
}

}  // namespace
}  // namespace ctn::graph
