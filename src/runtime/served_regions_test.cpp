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

}  // namespace
}  // namespace ctn::runtime
