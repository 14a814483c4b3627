// In virtual time, with the fake OS.
#include "runtime/client_members.h"

#include <gtest/gtest.h>

#include <memory>

#include "config/testing/apps.h"
#include "os/fake/fake_os.h"

namespace ctn::runtime {
namespace {

using std::chrono::milliseconds;

class ClientMembersTest : public ::testing::Test {
 protected:
  ClientMembersTest() {
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
  graph::App app =
      parse("catan: 1\napp: one\nnodes: { node: {} }\nedges: []\nobjective: [ { period: node, weight: 1 } ]\n");
  NodeId node{std::size_t{0}};
  LocalRegion memory{app.graph, 1};
  Region& region = memory.region();
  os::ThreadId other_id{};
  std::unique_ptr<os::Thread> other;
  ClientMembers members{fake};
};

TEST_F(ClientMembersTest, ThreadsGetBackTheSchedulingThatTheyRegisteredWith) {
  members.add(node, other_id);
  const os::CpuSet before = *fake.affinity(other_id);
  raise(other_id);
  EXPECT_TRUE(members.any_raised(region));
  members.restore_threads(region);
  EXPECT_EQ(*fake.level(other_id), os::Level::kOrdinary);
  EXPECT_EQ(*fake.affinity(other_id), before);
  EXPECT_FALSE(members.any_raised(region));
}

// Guards: a call of a server that is stopped may take effect after threads were restored, and nobody checked again.
TEST_F(ClientMembersTest, AThreadThatIsRaisedAfterItWasRestoredIsRestoredAgain) {
  members.add(node, other_id);
  raise(other_id);
  members.restore_threads(region);
  raise(other_id);
  ASSERT_TRUE(members.any_raised(region));
  members.restore_threads(region);
  EXPECT_EQ(*fake.level(other_id), os::Level::kOrdinary);
}

TEST_F(ClientMembersTest, ThreadsThatOnlyTheServerKnewBecomeOrdinary) {
  members.add(node, fake.current_thread());
  list(other_id);
  EXPECT_FALSE(members.any_raised(region));
  raise(other_id);
  EXPECT_TRUE(members.any_raised(region));
  members.restore_threads(region);
  EXPECT_EQ(*fake.level(other_id), os::Level::kOrdinary);
  EXPECT_EQ(*fake.affinity(other_id), *fake.affinity(fake.current_thread()));
}

// Guards: the program gave them the CPUs of the node's own thread.
TEST_F(ClientMembersTest, ThreadsThatTheProgramNamedGetBackTheirOwnScheduling) {
  ASSERT_TRUE(fake.set_affinity(other_id, os::CpuSet{0}).ok());
  members.add(node, fake.current_thread());
  members.add_thread(node, other_id);
  list(other_id);
  raise(other_id);
  members.restore_threads(region);
  EXPECT_EQ(*fake.level(other_id), os::Level::kOrdinary);
  EXPECT_EQ(*fake.affinity(other_id), os::CpuSet{0});
}

TEST_F(ClientMembersTest, TheSchedulingThatAServerGaveIsNotSaved) {
  raise(other_id);
  members.add(node, other_id);
  members.restore_threads(region);
  EXPECT_EQ(*fake.level(other_id), os::Level::kOrdinary);
  EXPECT_EQ(*fake.affinity(other_id), os::CpuSet{1}) << "a server had moved it by then";
  ASSERT_TRUE(fake.set_affinity(other_id, os::CpuSet{0}).ok());
  members.update_saved_scheduling();
  raise(other_id);
  members.update_saved_scheduling();
  members.restore_threads(region);
  EXPECT_EQ(*fake.level(other_id), os::Level::kOrdinary);
  EXPECT_EQ(*fake.affinity(other_id), os::CpuSet{0});
}

TEST_F(ClientMembersTest, AThreadThatReusesTheNumberOfOneThatEndedIsNotRestored) {
  members.add(node, other_id);
  fake.reuse_number(other_id);
  ASSERT_TRUE(fake.set_affinity(other_id, os::CpuSet{1}).ok());
  members.restore_threads(region);
  EXPECT_EQ(*fake.affinity(other_id), os::CpuSet{1});
  members.update_saved_scheduling();
  ASSERT_TRUE(fake.set_affinity(other_id, os::CpuSet{0}).ok());
  members.restore_threads(region);
  EXPECT_EQ(*fake.affinity(other_id), os::CpuSet{0}) << "nor is what it has saved as the other's";
}

TEST_F(ClientMembersTest, ThreadIdsInTheRegionThatAreNotOfThisProcessAreIgnored) {
  members.add(node, other_id);
  list(os::ThreadId{-7});
  members.restore_threads(region);
  list(os::ThreadId{12345});
  members.restore_threads(region);
  EXPECT_FALSE(members.any_raised(region));
  EXPECT_TRUE(fake.changes().empty());
}

TEST_F(ClientMembersTest, NodesAndTheirThreadsCanBeAddedAndRemoved) {
  EXPECT_FALSE(members.has(node));
  members.add_thread(node, other_id);
  members.add(node, fake.current_thread());
  members.add(node, other_id);
  members.remove(node, other_id);
  ASSERT_TRUE(members.has(node));
  ASSERT_EQ(members.all().size(), 1U);
  EXPECT_EQ(members.all().front().thread, fake.current_thread());
  members.add_thread(node, other_id);
  EXPECT_EQ(members.all().front().others, std::vector<os::ThreadId>{other_id});
  members.remove_thread(node, other_id);
  EXPECT_TRUE(members.all().front().others.empty());
}

}  // namespace
}  // namespace ctn::runtime
