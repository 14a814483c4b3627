// Nodes move from one server's region to the next, each with its next run.
#include "runtime/served_regions.h"

#include <gtest/gtest.h>

#include "base/run_access.h"
#include "config/testing/apps.h"
#include "os/fake/fake_os.h"

namespace ctn::runtime {
namespace {

constexpr const char* kText =
    "catan: 1\napp: two\nnodes: { here: {}, there: {} }\nedges: []\n"
    "objective: [ { period: here, weight: 1 }, { period: there, weight: 1 } ]\n";

class ServedRegionsTest : public ::testing::Test {
 protected:
  os::SharedMemory of_server(const std::string& text) {
    os::SharedMemory memory = *os::SharedMemory::create("regions-test", Region::size_for(app.graph, 1, text));
    Region::create(app.graph, 1, text, memory.bytes());
    return memory;
  }
  ServedRegions with_one() {
    ServedRegions made(app, kText);
    EXPECT_TRUE(made.add(of_server(kText)).ok());
    return made;
  }
  void run_once() {
    newest_cell().word.fetch_add(1);
    NodePort& port = *wiring.port(here);
    ASSERT_TRUE(port.wait_for_trigger());
    ctn::Run run;
    port.begin(run);
    port.end(run);
  }
  NodeCell& newest_cell() const { return regions.newest().node(here); }

  os::FakeOs fake;
  graph::App app = parse(kText);
  NodeId here{std::size_t{0}};
  NodeId there{std::size_t{1}};
  std::vector<NodeId> running{here};
  ServedRegions regions = with_one();
  Wiring wiring{app, fake, regions.newest()};
};

TEST_F(ServedRegionsTest, ANodeMovesWithItsNextRun) {
  const Region& first = regions.newest();
  run_once();
  ASSERT_TRUE(regions.add(of_server(kText)).ok());
  regions.move_nodes(wiring, running);
  EXPECT_TRUE(wiring.port(here)->uses(first));
  EXPECT_FALSE(wiring.port(there)->uses(first)) << "no thread runs it: it has moved already";
  regions.drop_old(wiring, running);
  EXPECT_EQ(regions.count(), 2U);
  run_once();
  regions.drop_old(wiring, running);
  EXPECT_EQ(regions.count(), 1U);
  EXPECT_TRUE(wiring.port(here)->uses(regions.newest()));
}

TEST_F(ServedRegionsTest, AnotherAppIsRefused) {
  const Status added = regions.add(of_server(std::string(kText) + "# of another day\n"));
  ASSERT_FALSE(added.ok());
  EXPECT_EQ(added.error().kind(), ErrorKind::kEnvironment);
  EXPECT_EQ(regions.count(), 1U);
}

TEST_F(ServedRegionsTest, TheSameServerIsKnownByItsMemory) {
  ASSERT_TRUE(regions.add(of_server(kText)).ok());
  regions.drop_newest();
  EXPECT_EQ(regions.count(), 1U);
  EXPECT_FALSE(regions.is_newest(of_server(kText)));
}

// Of a server that has the subchain cut, `there` is by itself: `here` does not trigger it, and gives the output that
// the subchain ends with.
TEST(ServedRegions, MayDifferInWhetherSubchainsAreCut) {
  const std::string text =
      "catan: 1\napp: two\nnodes: { here: { fallback_rate: 20Hz }, there: { fallback_rate: 5Hz } }\n"
      "edges: [ here -> there ]\nsubchains: { both: [here, there] }\nobjective: [ { period: here, weight: 1 } ]\n";
  os::FakeOs fake;
  const graph::App app = parse(text);
  const NodeId here{std::size_t{0}};
  const NodeId there{std::size_t{1}};
  ServedRegions regions(app, text);
  const auto add = [&](bool cut) {
    const graph::App laid_out = cut ? graph::cut_at_fallback_rates(app) : app;
    os::SharedMemory memory = *os::SharedMemory::create("regions-test", Region::size_for(laid_out.graph, 1, text));
    Region::create(laid_out.graph, 1, text, memory.bytes(), cut);
    ASSERT_TRUE(regions.add(std::move(memory)).ok());
    EXPECT_EQ(regions.newest_app().graph.subchains().size(), cut ? 2U : 1U);
  };
  add(false);
  Wiring wiring(regions.newest_app(), fake, regions.newest());
  const std::vector<NodeId> running{here};
  std::uint32_t triggers = 0;
  for (const bool cut : {false, true, false, true}) {
    if (triggers > 0) {
      add(cut);
      regions.move_nodes(wiring, running);
    }
    const Region& region = regions.newest();
    region.node(here).word.store(++triggers);
    NodePort& port = *wiring.port(here);
    ASSERT_TRUE(port.wait_for_trigger());
    ctn::Run run;
    port.begin(run);
    port.end(run);
    EXPECT_EQ(region.node(there).word.load(), cut ? 0U : triggers);
    EXPECT_EQ(region.signal(SubchainId(0)).completed.load(), cut ? triggers : 0U);
    EXPECT_EQ(region.signal(SubchainId(0)).outputs.load(), cut ? 1U : 0U);
  }
}

}  // namespace
}  // namespace ctn::runtime
