// A user's callback may do whatever a user may: no lock is held when it is called, and no thread waits for it.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "config/testing/apps.h"
#include "os/fake/fake_os.h"
#include "os/fake/faulty_os.h"
#include "runtime/notice_thread.h"
#include "runtime/scheduler.h"
#include "runtime/testing/virtual_session.h"

namespace ctn::runtime {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

// Each of these takes the lock of an object that has notices to add: the enforcer's when a level is refused, the
// that of the registered nodes when one has left.
TEST(Notices, TheCallbackMayCallTheSchedulerBack) {
  const graph::App app = parse(R"(
catan: 1
app: pair
nodes: { left: { fallback_rate: 20Hz }, right: { fallback_rate: 20Hz } }
objective: [ { period: left, weight: 1 }, { period: right, weight: 1 } ]
scheduler: { bootstrap: 500ms }
)");
  os::FakeOs fake{os::fake_topology(1)};
  fake.share_cpus(true);
  os::FaultyOs faulty(fake);
  LocalRegion memory(app.graph, 1);
  std::vector<std::string> told;
  std::unique_ptr<Scheduler> scheduler;
  std::atomic<std::int32_t> numbers[3] = {0, 0, 0};
  std::atomic<bool> over{false};
  const auto id = [&](int thread) { return os::ThreadId{numbers[thread].load()}; };
  const auto on_notice = [&](const std::string& text) {
    told.push_back(text);
    EXPECT_FALSE(scheduler->snapshot().notices.empty());
    if (text.starts_with("rates-only")) {
      EXPECT_TRUE(scheduler->add_thread(NodeId(0), fake.current_process(), id(1)).ok()) << "adopts a thread";
      EXPECT_TRUE(scheduler->join(NodeId(1), fake.current_process(), id(2)).ok()) << "registers a node";
    } else if (text.starts_with("node-left: node right")) {
      scheduler->remove_thread(NodeId(0), id(1));
      EXPECT_TRUE(scheduler->join(NodeId(1), fake.current_process(), id(2)).ok()) << "registers it again";
    }
  };
  SchedulerOptions options{
      .policy = *policy::make_policy("catan"), .cpus = {}, .record = {}, .note = {}, .on_notice = on_notice};
  scheduler = *Scheduler::create(app, faulty, std::move(options), os::CpuSet{0}, memory.region());
  ASSERT_TRUE(scheduler->prepare().ok());
  ASSERT_TRUE(scheduler->start().ok());

  std::vector<std::unique_ptr<os::Thread>> threads;
  for (std::atomic<std::int32_t>& number : numbers) {
    threads.push_back(fake.spawn("node", [&] {
      number.store(static_cast<std::int32_t>(fake.current_thread()));
      while (!over.load()) fake.sleep_until(fake.now() + milliseconds{100});
    }));
  }
  fake.sleep_until(fake.now() + milliseconds{10});
  faulty.fail_next(os::Call::kSetLevel, 1, os::refused());
  EXPECT_TRUE(scheduler->join(NodeId(0), fake.current_process(), id(0)).ok());
  fake.sleep_until(fake.now() + seconds{1});
  EXPECT_EQ(scheduler->threads(NodeId(0)), (std::vector<os::ThreadId>{id(0), id(1)}));
  EXPECT_EQ(scheduler->threads(NodeId(1)), std::vector<os::ThreadId>{id(2)});
  scheduler->leave(NodeId(1), "the test says so");
  fake.sleep_until(fake.now() + seconds{1});
  EXPECT_EQ(scheduler->threads(NodeId(0)), std::vector<os::ThreadId>{id(0)});
  EXPECT_EQ(scheduler->threads(NodeId(1)), std::vector<os::ThreadId>{id(2)});
  ASSERT_GE(told.size(), 2U);
  EXPECT_TRUE(told[0].starts_with("rates-only: ")) << told[0];

  over.store(true);
  for (const auto& thread : threads) thread->join();
  scheduler->end_scheduling();
  EXPECT_TRUE(scheduler->finish().ok());
}

class NoticesOfASession : public VirtualSession {};

// Guards: the callback was called by the housekeeping thread, and while it blocked no report was collected and no plan
// made.
TEST_F(NoticesOfASession, PlansAreMadeWhileTheCallbackBlocks) {
  costs = {{"left", milliseconds{5}}, {"right", milliseconds{5}}};
  std::vector<std::string> told;
  std::atomic<std::uint32_t> may_return{0};
  on_notice = [&](const std::string& text) {
    told.push_back(text);
    fake.wait(may_return, 0, kNever);
  };
  open(parse(R"(
catan: 1
app: pair
nodes: { left: { fallback_rate: 20Hz }, right: { fallback_rate: 20Hz } }
objective: [ { period: left, weight: 1 }, { period: right, weight: 1 } ]
scheduler: { bootstrap: 500ms }
)"),
       *policy::make_policy("catan"), 1);
  start();
  pass(seconds{2});
  ASSERT_TRUE(engine->change({.weights = {{"left", 20.0}}}).ok());
  pass(milliseconds{200});
  ASSERT_EQ(told.size(), 1U);
  const Snapshot before = engine->snapshot();
  ASSERT_TRUE(engine->change({.weights = {{"right", 20.0}}}).ok());
  pass(milliseconds{200});
  const Snapshot after = engine->snapshot();
  EXPECT_GT(after.plans, before.plans);
  EXPECT_GT(after.nodes[0].compute_ms.count, before.nodes[0].compute_ms.count);
  EXPECT_GT(after.notices.size(), 1U);
  EXPECT_EQ(told.size(), 1U);
  may_return.store(1);
  fake.wake(may_return);
  EXPECT_TRUE(engine->stop().ok());
  EXPECT_EQ(told, engine->snapshot().notices) << "all, in order, before it has stopped";
}

}  // namespace
}  // namespace ctn::runtime
