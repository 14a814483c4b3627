#include "baselines/job_dag.h"

#include <gtest/gtest.h>

#include <vector>

namespace ctn::baselines {
namespace {

// a (every 1, costs 0.25) and b (every 2, costs 1) on one core: b is pre-empted by the second run of a.
TEST(JobDag, HigherPrioritiesPreempt) {
  const std::vector<DagTask> tasks = {{0.25, 1, 0, 2}, {1.0, 2, 0, 1}};
  const auto schedule = schedule_dag(tasks, {});
  ASSERT_TRUE(schedule);
  EXPECT_EQ(schedule->hyperperiod, 2);
  EXPECT_DOUBLE_EQ(schedule->runs[0][1].begin, 1.0);
  EXPECT_DOUBLE_EQ(schedule->runs[0][1].end, 1.25);
  EXPECT_DOUBLE_EQ(schedule->runs[1][0].begin, 0.25);
  EXPECT_DOUBLE_EQ(schedule->runs[1][0].end, 1.5);
  EXPECT_DOUBLE_EQ(schedule->run(1, -1).end, -0.5);
  EXPECT_DOUBLE_EQ(schedule->run(0, 3).begin, 3.0);
}

TEST(JobDag, NoneWhereARunEndsTooLate) {
  EXPECT_FALSE(schedule_dag(std::vector<DagTask>{{0.6, 1, 0, 2}, {0.9, 2, 0, 1}}, {}));
  EXPECT_TRUE(schedule_dag(std::vector<DagTask>{{0.6, 1, 0, 2}, {0.8, 2, 0, 1}}, {}));
}

// Two tasks of one rate on two cores. Waiting for each other's newest, the second begins where the first ends.
TEST(JobDag, ARunWaitsForTheOneThatItUses) {
  const std::vector<DagTask> tasks = {{0.5, 1, 0, 2}, {0.25, 1, 1, 1}};
  const std::vector<DagEdge> newest = {{0, 1, 0}};
  const auto waiting = schedule_dag(tasks, newest);
  ASSERT_TRUE(waiting);
  EXPECT_DOUBLE_EQ(waiting->runs[1][0].begin, 0.5);
  const DagLatency one = chain_latency(tasks, *waiting, 0, newest);
  EXPECT_DOUBLE_EQ(one.age, 0.75);
  EXPECT_DOUBLE_EQ(one.reaction, 1.75);  // one period more

  // The run of the period before needs no waiting, and is older.
  const std::vector<DagEdge> before = {{0, 1, 1}};
  const auto at_once = schedule_dag(tasks, before);
  ASSERT_TRUE(at_once);
  EXPECT_DOUBLE_EQ(at_once->runs[1][0].begin, 0.0);
  const DagLatency other = chain_latency(tasks, *at_once, 0, before);
  EXPECT_DOUBLE_EQ(other.age, 1.25);
  EXPECT_DOUBLE_EQ(other.reaction, 2.25);
}

// The producer runs every 4 and ends 1.5 after its trigger, so the runs of the consumer that are triggered 2 or more
// after it can use it without waiting.
TEST(JobDag, ASlowProducersRunIsUsedUntilTheNextIsReady) {
  const std::vector<DagTask> tasks = {{1.5, 4, 0, 1}, {0.25, 1, 1, 2}};
  const DagEdge edge{0, 1, 2};
  EXPECT_EQ(used_run(tasks, edge, 0), -1);
  EXPECT_EQ(used_run(tasks, edge, 1), -1);
  EXPECT_EQ(used_run(tasks, edge, 2), 0);
  EXPECT_EQ(used_run(tasks, edge, 5), 0);
  EXPECT_EQ(used_run(tasks, edge, 6), 1);
  const std::vector<DagEdge> edges = {edge};
  const auto schedule = schedule_dag(tasks, edges);
  ASSERT_TRUE(schedule);
  const DagLatency latency = chain_latency(tasks, *schedule, 0, edges);
  EXPECT_DOUBLE_EQ(latency.age, 5.25);       // run 0 is used until the consumer's run at 5 ends
  EXPECT_DOUBLE_EQ(latency.reaction, 6.25);  // from its begin to the end of the run at 6, which uses the next
}

// A fast producer: the consumer uses every fourth run; a change may have to wait for that one.
TEST(JobDag, AFastProducersRunsAreSkipped) {
  const std::vector<DagTask> tasks = {{0.25, 1, 0, 2}, {1.0, 4, 1, 1}};
  const std::vector<DagEdge> edges = {{0, 1, 0}};
  const auto schedule = schedule_dag(tasks, edges);
  ASSERT_TRUE(schedule);
  const DagLatency latency = chain_latency(tasks, *schedule, 0, edges);
  EXPECT_DOUBLE_EQ(latency.age, 1.25);
  EXPECT_DOUBLE_EQ(latency.reaction, 5.25);
}

TEST(JobDag, NoneWhereRunsWaitForEachOther) {
  const std::vector<DagTask> tasks = {{0.25, 1, 0, 2}, {0.25, 1, 1, 1}};
  EXPECT_FALSE(schedule_dag(tasks, std::vector<DagEdge>{{0, 1, 0}, {1, 0, 0}}));
  EXPECT_TRUE(schedule_dag(tasks, std::vector<DagEdge>{{0, 1, 0}, {1, 0, 1}}));
}

}  // namespace
}  // namespace ctn::baselines
