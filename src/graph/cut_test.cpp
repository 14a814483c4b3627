#include "graph/cut.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "graph/build.h"
#include "graph/testing/spec_text.h"

namespace ctn::graph {
namespace {

using testing::ElementsAre;

// Between two subchains of one node each, one of five nodes.
AppSpec row_spec() {
  AppSpec spec = spec_of({"last", "a", "b", "c", "d", "e", "first"}, {"first a b c d e last"});
  spec.subchains = {subchain("row", "a b c d e")};
  spec.objective = {response("first a b c d e last", 1.0)};
  return spec;
}

App built(const AppSpec& spec) {
  auto app = build_app(spec);
  EXPECT_TRUE(app.ok()) << app.error().message();
  return std::move(*app);
}

void set_rates(AppSpec& spec, const std::string& names) {
  for (const Name& name : split(names)) node(spec, name.value).fallback_rate = At<Rate>{Rate{10.0}, {}};
}

// "row: a b"
std::vector<std::string> shown(const App& app, const std::vector<SubchainId>& ids) {
  std::vector<std::string> all;
  for (const SubchainId id : ids) {
    const Subchain& subchain = app.graph.subchain(id);
    std::string text = subchain.name + ":";
    for (const NodeId node : subchain.nodes) text += " " + app.graph.node(node).name;
    all.push_back(text);
  }
  return all;
}

std::vector<std::string> subchains(const App& app) {
  std::vector<SubchainId> all;
  for (std::size_t index = 0; index < app.graph.subchains().size(); ++index) all.emplace_back(index);
  return shown(app, all);
}

TEST(Cut, IsInFrontOfEachNodeThatHasARate) {
  AppSpec spec = row_spec();
  set_rates(spec, "a b d e");
  const App app = cut_at_fallback_rates(built(spec));
  EXPECT_THAT(subchains(app), ElementsAre("row: a", "b: b c", "last: last", "d: d", "e: e", "first: first"))
      << "as an app file would have them: those that it names, then single nodes as they were written";
  EXPECT_THAT(shown(app, app.order), ElementsAre("first: first", "row: a", "b: b c", "d: d", "e: e", "last: last"));
  for (std::size_t index = 0; index < app.graph.subchains().size(); ++index) {
    const Subchain& subchain = app.graph.subchain(SubchainId(index));
    EXPECT_EQ(subchain.implicit, subchain.name != "row" && subchain.name != "b");
    for (const NodeId node : subchain.nodes) EXPECT_EQ(app.graph.node(node).subchain, SubchainId(index));
  }
}

TEST(Cut, IsWhatAnAppFileCouldHaveSaid) {
  AppSpec spec = row_spec();
  spec.order = split("last row first");
  spec.steal_priority = split("row last first");
  spec.steal_off = split("row");
  set_rates(spec, "b d e");
  const App cut = cut_at_fallback_rates(built(spec));
  spec.subchains = {subchain("row", "a"), subchain("b", "b c")};
  spec.order = split("last row b d e first");
  spec.steal_priority = split("row b d e last first");
  spec.steal_off = split("row b d e");
  const App written = built(spec);
  EXPECT_EQ(subchains(cut), subchains(written));
  EXPECT_EQ(cut.order, written.order);
  EXPECT_EQ(cut.steal.priority, written.steal.priority);
  EXPECT_EQ(cut.steal.off, written.steal.off);
  EXPECT_EQ(subchains(cut_at_fallback_rates(cut)), subchains(cut)) << "once and for all";
}

TEST(Cut, ChangesNothingWhereHeadsAloneHaveRates) {
  AppSpec spec = row_spec();
  set_rates(spec, "first a last");
  const App app = built(spec);
  EXPECT_EQ(subchains(cut_at_fallback_rates(app)), subchains(app));
  EXPECT_EQ(cut_at_fallback_rates(app).order, app.order);
}

}  // namespace
}  // namespace ctn::graph
