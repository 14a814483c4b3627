// In virtual time, with the fake OS.
#include "runtime/client_nodes.h"

#include <gtest/gtest.h>

#include <memory>

#include "config/testing/apps.h"
#include "os/fake/fake_os.h"
#include "os/fake/faulty_os.h"

namespace ctn::runtime {
namespace {

using std::chrono::milliseconds;

class ClientNodesTest : public ::testing::Test {
 protected:
  ClientNodesTest() {
    other = fake.spawn("other", [this] {
      other_id = fake.current_thread();
      fake.sleep_until(TimePoint{std::chrono::hours{1}});
    });
    fake.sleep_until(fake.now() + milliseconds{1});
  }

  void raise(os::ThreadId thread) {
    ASSERT_TRUE(fake.set_level(thread, os::Level::kActive).ok());
    ASSERT_TRUE(fake.set_affinity(thread, os::CpuSet{1}).ok());
  }
  void list(os::ThreadId thread) {
    NodeCell& cell = region.node(node);
    cell.thread[0].store(static_cast<std::int32_t>(thread));
    cell.threads.store(1);
  }

  os::FakeOs fake;
  graph::App app = one_node_app();
  NodeId node{std::size_t{0}};
  LocalRegion memory{app.graph, 1};
  Region& region = memory.region();
  os::ThreadId other_id{};
  std::unique_ptr<os::Thread> other;
  ClientNodes nodes{fake};
};

TEST_F(ClientNodesTest, ThreadsGetBackTheSchedulingThatTheyRegisteredWith) {
  nodes.add(node, other_id);
  const os::CpuSet before = *fake.affinity(other_id);
  raise(other_id);
  EXPECT_TRUE(nodes.any_raised(region));
  nodes.restore_threads(region);
  EXPECT_EQ(*fake.level(other_id), os::Level::kOrdinary);
  EXPECT_EQ(*fake.affinity(other_id), before);
  EXPECT_FALSE(nodes.any_raised(region));
}

// Guards: a call of a server that is stopped may take effect after threads were restored, and that was not checked
// again.
TEST_F(ClientNodesTest, AThreadThatIsRaisedAfterItWasRestoredIsRestoredAgain) {
  nodes.add(node, other_id);
  raise(other_id);
  nodes.restore_threads(region);
  raise(other_id);
  ASSERT_TRUE(nodes.any_raised(region));
  nodes.restore_threads(region);
  EXPECT_EQ(*fake.level(other_id), os::Level::kOrdinary);
}

TEST_F(ClientNodesTest, ThreadsThatOnlyTheServerKnewBecomeOrdinary) {
  nodes.add(node, fake.current_thread());
  list(other_id);
  EXPECT_FALSE(nodes.any_raised(region));
  raise(other_id);
  EXPECT_TRUE(nodes.any_raised(region));
  nodes.restore_threads(region);
  EXPECT_EQ(*fake.level(other_id), os::Level::kOrdinary);
  EXPECT_EQ(*fake.affinity(other_id), *fake.affinity(fake.current_thread()));
}

// Guards: the program gave them the CPUs of the node's own thread.
TEST_F(ClientNodesTest, ThreadsThatTheProgramNamedGetBackTheirOwnScheduling) {
  ASSERT_TRUE(fake.set_affinity(other_id, os::CpuSet{0}).ok());
  nodes.add(node, fake.current_thread());
  nodes.add_thread(node, other_id);
  list(other_id);
  raise(other_id);
  nodes.restore_threads(region);
  EXPECT_EQ(*fake.level(other_id), os::Level::kOrdinary);
  EXPECT_EQ(*fake.affinity(other_id), os::CpuSet{0});
}

TEST_F(ClientNodesTest, TheSchedulingThatAServerGaveIsNotSaved) {
  raise(other_id);
  nodes.add(node, other_id);
  nodes.restore_threads(region);
  EXPECT_EQ(*fake.level(other_id), os::Level::kOrdinary);
  EXPECT_EQ(*fake.affinity(other_id), os::CpuSet{1}) << "a server had moved it by then";
  ASSERT_TRUE(fake.set_affinity(other_id, os::CpuSet{0}).ok());
  nodes.update_saved_scheduling();
  raise(other_id);
  nodes.update_saved_scheduling();
  nodes.restore_threads(region);
  EXPECT_EQ(*fake.level(other_id), os::Level::kOrdinary);
  EXPECT_EQ(*fake.affinity(other_id), os::CpuSet{0});
}

// A server lowers a thread just after somebody has looked what it has.
class LoweringOs final : public os::FaultyOs {
 public:
  using FaultyOs::FaultyOs;
  Result<os::SavedScheduling> save_scheduling(os::ThreadId thread) override {
    Result<os::SavedScheduling> found = FaultyOs::save_scheduling(thread);
    if (lowers) shift_level(thread, os::Level::kOrdinary);
    return found;
  }
  bool lowers = false;
};

// Guards: the level was looked at once more by itself, and so the one that the server had given was saved.
TEST_F(ClientNodesTest, TheSchedulingThatAServerTakesBackAtThatMomentIsNotSaved) {
  LoweringOs lowering(fake);
  ClientNodes watched{lowering};
  raise(other_id);
  lowering.lowers = true;
  watched.add(node, other_id);
  lowering.lowers = false;
  raise(other_id);
  watched.restore_threads(region);
  EXPECT_EQ(*fake.level(other_id), os::Level::kOrdinary);
}

TEST_F(ClientNodesTest, AThreadThatReusesTheNumberOfOneThatEndedIsNotRestored) {
  nodes.add(node, other_id);
  fake.reuse_number(other_id);
  ASSERT_TRUE(fake.set_affinity(other_id, os::CpuSet{1}).ok());
  nodes.restore_threads(region);
  EXPECT_EQ(*fake.affinity(other_id), os::CpuSet{1});
  nodes.update_saved_scheduling();
  ASSERT_TRUE(fake.set_affinity(other_id, os::CpuSet{0}).ok());
  nodes.restore_threads(region);
  EXPECT_EQ(*fake.affinity(other_id), os::CpuSet{0}) << "nor is what it has saved as the other's";
}

// Guards: a thread that had the number of a named thread that had ended was named to the next server, and raised there;
// and threads that had ended were kept for good.
TEST_F(ClientNodesTest, ANamedThreadThatEndsIsForgotten) {
  nodes.add(node, fake.current_thread());
  const auto others = [&] { return nodes.all().front().others; };
  nodes.add_thread(node, other_id);
  nodes.add_thread(node, other_id);
  EXPECT_EQ(others(), std::vector<os::ThreadId>{other_id}) << "once, however often it is named";
  const auto brief = fake.spawn("brief", [&] { nodes.add_thread(node, fake.current_thread()); });
  brief->join();
  EXPECT_EQ(others().size(), 2U);
  nodes.update_saved_scheduling();
  EXPECT_EQ(others(), std::vector<os::ThreadId>{other_id});
  fake.reuse_number(other_id);
  nodes.update_saved_scheduling();
  EXPECT_TRUE(others().empty()) << "another has its number";
  nodes.add_thread(node, other_id);
  EXPECT_EQ(others(), std::vector<os::ThreadId>{other_id}) << "which names itself";
}

// Guards: it stayed raised, since it was not the one of which it was known what it had had.
TEST_F(ClientNodesTest, AThreadThatAServerRaisedForOneThatEndedBecomesOrdinary) {
  nodes.add(node, fake.current_thread());
  nodes.add_thread(node, other_id);
  list(other_id);
  fake.reuse_number(other_id);
  raise(other_id);
  nodes.restore_threads(region);
  EXPECT_EQ(*fake.level(other_id), os::Level::kOrdinary);
}

// A server handed it to a node whose join it did not answer, so that the list that it is in is nobody's.
TEST_F(ClientNodesTest, ASharedThreadIsRestoredWhereverTheServerListsIt) {
  const os::CpuSet before{0};
  ASSERT_TRUE(fake.set_affinity(other_id, before).ok());
  nodes.add(node, fake.current_thread());
  ASSERT_TRUE(nodes.share(other_id).ok());
  EXPECT_FALSE(nodes.any_raised(region));
  raise(other_id);
  EXPECT_TRUE(nodes.any_raised(region));
  nodes.restore_threads(region);
  EXPECT_EQ(*fake.level(other_id), os::Level::kOrdinary);
  EXPECT_EQ(*fake.affinity(other_id), before);
}

TEST_F(ClientNodesTest, ASharedThreadThatOnlyTheServerKnewBecomesOrdinary) {
  raise(other_id);
  ASSERT_TRUE(nodes.share(other_id).ok());
  nodes.restore_threads(region);
  EXPECT_EQ(*fake.level(other_id), os::Level::kOrdinary);
}

TEST_F(ClientNodesTest, ASharedThreadIsOneOfThisProcessAndKnownUntilItEnds) {
  EXPECT_FALSE(nodes.share(os::ThreadId{12345}).ok());
  ASSERT_TRUE(nodes.share(other_id).ok());
  ASSERT_TRUE(nodes.share(other_id).ok());
  EXPECT_EQ(nodes.shared(), std::vector<os::ThreadId>{other_id}) << "once, however often it is named";
  EXPECT_TRUE(nodes.has_untold());
  const auto brief = fake.spawn("brief", [&] { EXPECT_TRUE(nodes.share(fake.current_thread()).ok()); });
  brief->join();
  EXPECT_EQ(nodes.shared().size(), 2U);
  nodes.update_saved_scheduling();
  EXPECT_EQ(nodes.shared(), std::vector<os::ThreadId>{other_id});
  fake.reuse_number(other_id);
  nodes.update_saved_scheduling();
  EXPECT_TRUE(nodes.shared().empty()) << "another has its number";
  EXPECT_FALSE(nodes.has_untold());
}

TEST_F(ClientNodesTest, ThreadIdsInTheRegionThatAreNotOfThisProcessAreIgnored) {
  nodes.add(node, other_id);
  list(os::ThreadId{-7});
  nodes.restore_threads(region);
  list(os::ThreadId{12345});
  nodes.restore_threads(region);
  EXPECT_FALSE(nodes.any_raised(region));
  EXPECT_TRUE(fake.changes().empty());
}

TEST_F(ClientNodesTest, NodesAndTheirThreadsCanBeAddedAndRemoved) {
  EXPECT_FALSE(nodes.has(node));
  nodes.add_thread(node, other_id);
  nodes.add(node, fake.current_thread());
  nodes.add(node, other_id);
  nodes.remove(node, other_id);
  ASSERT_TRUE(nodes.has(node));
  ASSERT_EQ(nodes.all().size(), 1U);
  EXPECT_EQ(nodes.all().front().thread, fake.current_thread());
  nodes.add_thread(node, other_id);
  EXPECT_EQ(nodes.all().front().others, std::vector<os::ThreadId>{other_id});
  nodes.remove_thread(node, other_id);
  EXPECT_TRUE(nodes.all().front().others.empty());
}

}  // namespace
}  // namespace ctn::runtime
