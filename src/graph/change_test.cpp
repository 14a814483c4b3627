#include "graph/change.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <vector>

#include "base/numbers.h"
#include "graph/build.h"
#include "graph/testing/spec_text.h"

namespace ctn::graph {
namespace {

NodeSpec node(const std::string& name) {
  NodeSpec spec;
  spec.name = {name, {}};
  return spec;
}

TermSpec term(Metric metric, const std::string& path, double weight) {
  TermSpec spec;
  spec.metric = metric;
  spec.path = split(path);
  spec.weight.value = weight;
  return spec;
}

// Two chains from a to d, and a capped node.
App app() {
  AppSpec spec;
  spec.name = {"x", {}};
  for (const char* name : {"a", "b", "c", "d", "lone"}) spec.nodes.push_back(node(name));
  spec.nodes[3].max_rate = At<Rate>{Rate{50.0}, {}};
  NodeSpec sensor = node("imu");
  sensor.unscheduled = true;
  sensor.period = At<Nanos>{std::chrono::milliseconds{5}, {}};
  spec.nodes.push_back(sensor);
  for (const char* path : {"a b d", "a c d"}) spec.edges.push_back({split(path), {}});
  spec.objective = {term(Metric::kResponseTime, "a b d", 1.0), term(Metric::kResponseTime, "a c d", 0.5),
                    term(Metric::kResponseTime, "a b", 0.25), term(Metric::kPeriod, "lone", 0.1),
                    term(Metric::kResponseTime, "c", 0.01)};
  Result<App> built = build_app(spec);
  EXPECT_TRUE(built.ok()) << built.error().message();
  return *std::move(built);
}

std::string keys(const Error& error) {
  std::string text;
  for (const Problem& problem : error.problems()) text += problem.key + ";";
  return text;
}

TEST(FindTerm, ByNumberChainEndsOrNode) {
  const App x = app();
  const auto is = [&](const std::string& name, std::size_t index) {
    const Result<std::size_t> found = find_term(x, name);
    return found.ok() && *found == index;
  };
  EXPECT_TRUE(is("0", 0));
  EXPECT_TRUE(is("4", 4));
  EXPECT_TRUE(is("a -> b -> d", 0));
  EXPECT_TRUE(is("a->c->d", 1));
  EXPECT_TRUE(is(" a -> b ", 2));
  EXPECT_TRUE(is("lone", 3));
  EXPECT_TRUE(is("period of lone", 3));
  EXPECT_TRUE(is("c", 4));
  for (std::size_t index = 0; index < x.objective.size(); ++index) {
    EXPECT_TRUE(is(term_name(x, x.objective[index]), index)) << term_name(x, x.objective[index]);
  }
}

TEST(FindTerm, SaysWhatThereIsWhereNoneOrSeveralAreMeant) {
  const App x = app();
  for (const char* name : {"a -> d", "5", "b", "", "->", "period of c", "-1", "99999999999999999999999"}) {
    const Result<std::size_t> found = find_term(x, name);
    ASSERT_FALSE(found.ok()) << name;
    EXPECT_EQ(found.error().kind(), ErrorKind::kCaller);
    EXPECT_NE(found.error().message().find("0 (a -> b -> d)"), std::string::npos) << found.error().message();
  }
  EXPECT_NE(find_term(x, "a -> d").error().message().find("several"), std::string::npos);
}

TEST(Changed, WeightsBoundsAndRatesAreThoseThatWereAsked) {
  const App x = app();
  Changes changes;
  changes.weights = {{"a -> b", 3.0}, {"3", 0.0}};
  changes.maxes = {{"0", 60.5}};
  changes.min_rates = {{"d", 50.0}, {"lone", 2.0}};
  const Result<App> after = changed(x, changes);
  ASSERT_TRUE(after.ok()) << after.error().message();
  EXPECT_EQ(after->objective[2].weight, 3.0);
  EXPECT_EQ(after->objective[3].weight, 0.0);
  EXPECT_EQ(after->objective[0].weight, 1.0) << "what was not asked stays";
  EXPECT_EQ(after->objective[0].max, std::chrono::microseconds{60500});
  EXPECT_EQ(after->graph.node(*after->graph.find_node("d")).min_rate, Rate{50.0}) << "an exact rate";
  Changes back;
  back.maxes = {{"0", {}}};
  back.min_rates = {{"d", {}}};
  const Result<App> again = changed(*after, back);
  ASSERT_TRUE(again.ok());
  EXPECT_FALSE(again->objective[0].max);
  EXPECT_FALSE(again->graph.node(*again->graph.find_node("d")).min_rate);
}

TEST(Changed, RankingsThatFollowFromWeightsFollowTheNewOnes) {
  const App x = app();
  Changes changes;
  changes.weights = {{"lone", 9.0}};
  const App after = *changed(x, changes);
  const SubchainId lone = *x.graph.find_subchain("lone");
  EXPECT_NE(x.steal.priority.front(), lone);
  EXPECT_EQ(after.steal.priority.front(), lone);
  App by_hand = x;
  std::swap(by_hand.steal.priority.front(), by_hand.steal.priority.back());
  EXPECT_EQ(changed(by_hand, changes)->steal.priority, by_hand.steal.priority) << "what was written stays";
}

TEST(Changed, AllThatIsWrongIsTold) {
  const App x = app();
  Changes changes;
  changes.weights = {{"0", -1.0}, {"1", std::numeric_limits<double>::quiet_NaN()}, {"nobody", 1.0}};
  changes.maxes = {{"lone", 5.0}, {"2", 0.0}, {"4", kInfinity}};
  changes.min_rates = {{"d", 51.0}, {"nope", 1.0}, {"imu", 1.0}, {"a", 0.0}, {"b", 1.0}, {"b", 2.0}};
  const Result<App> after = changed(x, changes);
  ASSERT_FALSE(after.ok());
  EXPECT_EQ(after.error().kind(), ErrorKind::kCaller);
  EXPECT_EQ(keys(after.error()),
            "objective[0].weight;objective[1].weight;nobody;objective[3].max;objective[2].max;objective[4].max;"
            "nodes.nope.min_rate;nodes.imu.min_rate;nodes.a.min_rate;nodes.b.min_rate;nodes.d.min_rate;");
  for (const Problem& problem : after.error().problems()) EXPECT_FALSE(problem.hint.empty()) << problem.key;
}

TEST(Changed, WeightsMayNotAddUpToMoreThanInAnAppFile) {
  const App x = app();
  Changes changes;
  changes.weights = {{"0", 9e99}, {"1", 9e98}};
  EXPECT_TRUE(changed(x, changes).ok());
  for (const double weight : {2e99, 1e308, std::numeric_limits<double>::max()}) {
    changes.weights[1].weight = weight;
    const Result<App> after = changed(x, changes);
    ASSERT_FALSE(after.ok()) << weight;
    EXPECT_EQ(keys(after.error()), weight > 9e99 ? "objective[1].weight;" : "objective[0].weight;");
    EXPECT_NE(after.error().message().find("only what they are to one another counts"), std::string::npos);
  }
}

// Guards: an app was accepted that an app file may not have, and that no plan can be made of.
TEST(Changed, WhatAnAppFileMayNotHaveIsRefused) {
  AppSpec spec;
  spec.name = {"x", {}};
  for (const char* name : {"a", "b", "imu"}) spec.nodes.push_back(node(name));
  spec.nodes[0].trigger = At<TriggerBy>{TriggerBy::kArrival, {}};
  spec.nodes[0].max_rate = At<Rate>{Rate{50.0}, {}};
  spec.nodes[0].output_period = At<Nanos>{std::chrono::milliseconds{700}, {}};
  spec.nodes[2].unscheduled = true;
  spec.nodes[2].period = At<Nanos>{std::chrono::milliseconds{5}, {}};
  spec.edges.push_back({split("imu a b"), {}});
  SubchainSpec subchain;
  subchain.name = {"s", {}};
  subchain.nodes = split("a b");
  spec.subchains.push_back(subchain);
  spec.objective = {term(Metric::kResponseTime, "a b", 1.0)};
  const Result<App> built = build_app(spec);
  ASSERT_TRUE(built.ok()) << built.error().message();
  for (const Changes::MinRate& refused : {Changes::MinRate{"a", 50.0}, Changes::MinRate{"b", 5.0}}) {
    Changes changes;
    changes.min_rates = {refused};
    const Result<App> after = changed(*built, changes);
    ASSERT_FALSE(after.ok()) << refused.node;
    EXPECT_THAT(after.error().message(), testing::HasSubstr("; ask for ")) << "what can be changed while it runs";
  }
  Changes changes;
  changes.min_rates = {{"a", 49.0}, {"b", 1.0}};
  EXPECT_TRUE(changed(*built, changes).ok());
}

}  // namespace
}  // namespace ctn::graph
