// How a session follows the CPUs that its process may use, in virtual time: cpusets that shrink and grow, and whoever
// changes the affinity of its threads.
#include "runtime/allowed_cpus.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <string>
#include <vector>

#include "config/testing/apps.h"
#include "runtime/enforcer.h"
#include "runtime/testing/virtual_session.h"

namespace ctn::runtime {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

class AllowedCpusTest : public VirtualSession {
 protected:
  AllowedCpusTest() {
    costs = {{"fast", milliseconds{4}}, {"slow", milliseconds{10}}};
    cost = [this](const std::string& node, std::uint64_t /*run*/) {
      ++runs[node][fake.current_cpu()];
      node_threads[node] = fake.current_thread();
      return costs.at(node);
    };
    on_notice = [this](const std::string& notice) { notices.push_back(notice); };
    open(two_loops_app(), *policy::make_policy("catan"), 2);
  }
  // In the first second after `settling`: how many runs of all nodes were on that CPU.
  int runs_on(int cpu, Nanos settling = milliseconds{250}) {
    pass(settling);
    runs.clear();
    pass(seconds{1});
    return runs["fast"][cpu] + runs["slow"][cpu];
  }
  // As `taskset -a`.
  void bind_all_threads(const os::CpuSet& cpus) {
    for (const os::ThreadId thread : fake.threads(fake.current_process()).value()) {
      ASSERT_TRUE(fake.set_affinity(thread, cpus).ok());
    }
  }
  void expect_planned_for(const os::CpuSet& cpus) {
    ASSERT_FALSE(notices.empty());
    EXPECT_EQ(notices.back(),
              "cpus: of CPUs 0-1, " + os::to_string(cpus) + " are online and allowed: planning for these");
  }

  std::map<std::string, std::map<int, int>> runs;  // by node and CPU
  std::map<std::string, os::ThreadId> node_threads;
  std::vector<std::string> notices;
};

TEST_F(AllowedCpusTest, ACpusetThatShrinksAndGrowsIsFollowedAsHotPlugIs) {
  start();
  EXPECT_GT(runs_on(1, seconds{3}), 0);
  const std::uint64_t before = engine->snapshot().plans;
  fake.set_cpuset({0});
  pass(milliseconds{200});
  EXPECT_EQ(engine->snapshot().plans, before + 1) << "at once: a look every 100 ms";
  expect_planned_for({0});
  EXPECT_EQ(runs_on(1), 0);
  EXPECT_NEAR(runs_on(0), 120, 3) << "both nodes go on at their rates";
  fake.set_cpuset({0, 1});
  EXPECT_GT(runs_on(1), 0);
  expect_planned_for({0, 1});
  EXPECT_EQ(notices.size(), 2U);
  EXPECT_TRUE(engine->stop().ok());
}

// `taskset -p` with the number of a process changes its main thread, and no other.
TEST_F(AllowedCpusTest, WhatIsTakenFromTheMainThreadIsTakenFromTheSession) {
  start();
  pass(seconds{3});
  ASSERT_TRUE(fake.set_affinity(fake.current_thread(), {1}).ok());
  EXPECT_EQ(runs_on(0), 0);
  expect_planned_for({1});
  ASSERT_TRUE(fake.set_affinity(fake.current_thread(), {0, 1}).ok());
  EXPECT_GT(runs_on(0), 0);
  expect_planned_for({0, 1});
  EXPECT_TRUE(engine->stop().ok());
}

TEST_F(AllowedCpusTest, AMainThreadThatWasBoundBeforeDoesNotBindTheSession) {
  ASSERT_TRUE(fake.set_affinity(fake.current_thread(), {0}).ok());
  start();
  EXPECT_GT(runs_on(1, seconds{3}), 0);
  EXPECT_TRUE(notices.empty());
  EXPECT_TRUE(engine->stop().ok());
}

TEST_F(AllowedCpusTest, WhatCatanItselfDoesToAThreadIsNotTakenForAnotherProgramsDoing) {
  start();
  pass(seconds{3});
  ASSERT_TRUE(engine->adopt_this_thread("fast").ok());  // which is the main thread
  pass(seconds{2});
  EXPECT_EQ(fake.affinity(fake.current_thread()).value().size(), 1U) << "as planned for the node";
  EXPECT_TRUE(notices.empty());
  EXPECT_TRUE(engine->stop().ok());
}

// Guards: the main thread, adopted by one session, took its CPUs from the other one.
TEST_F(AllowedCpusTest, WhatAnotherSessionOfThisProcessDoesToAThreadIsNotTheUsersDoing) {
  Enforcer other(fake, true, nullptr, nullptr);
  const os::ThreadId main = fake.current_thread();
  start();
  pass(seconds{3});
  ASSERT_TRUE(other.apply(main, os::Level::kOrdinary, {0}).ok());
  EXPECT_GT(runs_on(1), 0);
  EXPECT_TRUE(notices.empty());
  other.restore(main);
  EXPECT_GT(runs_on(1), 0);
  EXPECT_TRUE(notices.empty());
  // Its own affinity counts as before.
  ASSERT_TRUE(fake.set_affinity(main, {0}).ok());
  EXPECT_EQ(runs_on(1), 0);
  expect_planned_for({0});
  EXPECT_TRUE(engine->stop().ok());
}

TEST_F(AllowedCpusTest, AThreadThatAnotherSessionHasPlacedIsWatchedOnceItIsFree) {
  Enforcer other(fake, true, nullptr, nullptr);
  const os::ThreadId main = fake.current_thread();
  ASSERT_TRUE(other.apply(main, os::Level::kOrdinary, {0}).ok());
  start();
  EXPECT_GT(runs_on(1, seconds{3}), 0);
  other.restore(main);
  EXPECT_GT(runs_on(1), 0);
  EXPECT_TRUE(notices.empty());
  ASSERT_TRUE(fake.set_affinity(main, {0}).ok());
  EXPECT_EQ(runs_on(1), 0);
  expect_planned_for({0});
  EXPECT_TRUE(engine->stop().ok());
}

// Guards: a thread that joined was first placed on all CPUs that were given, which is refused where one of them is
// gone.
TEST_F(AllowedCpusTest, ThreadsThatJoinWhileACpuIsGoneArePlacedOnThoseThatAreLeft) {
  start();
  pass(seconds{3});
  fake.set_cpuset({0});
  pass(milliseconds{300});
  const Status joined = engine->adopt_this_thread("fast");
  EXPECT_TRUE(joined.ok()) << joined.error().message();
  EXPECT_EQ(fake.affinity(fake.current_thread()).value(), os::CpuSet{0});
  EXPECT_TRUE(engine->stop().ok());
}

TEST_F(AllowedCpusTest, AllThreadsThatAreBoundElsewhereAreFollowedAndPlacedAgain) {
  start();
  pass(seconds{3});
  const os::CpuSet planned = fake.affinity(node_threads.at("fast")).value();
  ASSERT_EQ(planned.size(), 1U);
  bind_all_threads({1});
  EXPECT_EQ(runs_on(0), 0);
  expect_planned_for({1});
  bind_all_threads({0, 1});
  EXPECT_GT(runs_on(0, seconds{3}), 0);
  expect_planned_for({0, 1});
  for (const auto& [node, thread] : node_threads) EXPECT_EQ(fake.affinity(thread).value().size(), 1U) << node;
  EXPECT_EQ(fake.affinity(node_threads.at("fast")).value(), planned);
  EXPECT_TRUE(engine->stop().ok());
}

TEST_F(AllowedCpusTest, ThreadsThatAreMovedFromOutsideAreMovedBackAndToldOfOnce) {
  start();
  pass(seconds{3});
  for (int time = 0; time < 3; ++time) {
    bind_all_threads({0, 1});
    pass(milliseconds{2100});
    for (const auto& [node, thread] : node_threads) EXPECT_EQ(fake.affinity(thread).value().size(), 1U) << node;
  }
  ASSERT_EQ(notices.size(), 1U);
  EXPECT_EQ(notices[0].find("moved: another program has pinned 2 of the app's threads"), 0U) << notices[0];
  EXPECT_TRUE(engine->stop().ok());
}

}  // namespace
}  // namespace ctn::runtime
