#include "summary.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "sample.h"

namespace ctn::demo {
namespace {

TEST(SpreadOf, IsMedianAndEnds) {
  const Spread odd = spread_of({3.0, 1.0, 2.0});
  EXPECT_EQ(odd.median, 2.0);
  EXPECT_EQ(odd.min, 1.0);
  EXPECT_EQ(odd.max, 3.0);
  EXPECT_EQ(spread_of({1.0, 2.0}).median, 1.5);
}

TEST(Summarise, TakesTheMedianOverRounds) {
  const Summary summary = summarise(sample_results());
  const Row* row = find_row(summary, 1, "default", 1.0);
  ASSERT_NE(row, nullptr);
  EXPECT_EQ(row->rounds, 3U);
  EXPECT_EQ(row->response_ms.median, 252.0);
  EXPECT_EQ(row->response_ms.min, 251.0);
  EXPECT_EQ(row->response_ms.max, 253.0);
  EXPECT_FALSE(row->predicted_ms.has_value());
  EXPECT_EQ(find_row(summary, 2, "catan", 1.0)->predicted_ms->median, 150.0);
}

TEST(Summarise, AllClaimsHoldWhereAllIsWell) {
  const Summary summary = summarise(sample_results());
  EXPECT_EQ(summary.claims.size(), 10U);
  EXPECT_TRUE(std::ranges::all_of(summary.claims, &Claim::held));
}

std::size_t broken_by(void (*change)(Measured&)) {
  Results results = sample_results();
  for (Measured& run : results.runs) {
    if (run.trial.cpus.size() == 1) change(run);
  }
  const Summary summary = summarise(results);
  return static_cast<std::size_t>(std::ranges::count(summary.claims, false, &Claim::held));
}

TEST(Summarise, SaysWhichClaimDidNotHold) {
  EXPECT_EQ(broken_by([](Measured& run) {
              if (run.trial.scheduler == "rate:11.4Hz") run.response_ms *= 0.94;
            }),
            1U);
  EXPECT_EQ(broken_by([](Measured& run) {
              if (run.trial.scheduler == "default") run.response_ms = 180.0;
            }),
            1U);
  EXPECT_EQ(broken_by([](Measured& run) {
              if (run.predicted_ms) run.predicted_ms = 200.0;
            }),
            1U);
  EXPECT_EQ(broken_by([](Measured& run) {
              if (run.trial.scheduler == "default") run.angle_deg = 1.0;
            }),
            2U);
}

TEST(Summarise, CopesWithPartOfTheTrials) {
  Results results = sample_results();
  results.runs.resize(1);
  EXPECT_TRUE(summarise(results).claims.empty());
  results.runs.clear();
  EXPECT_TRUE(summarise(results).rows.empty());
}

}  // namespace
}  // namespace ctn::demo
