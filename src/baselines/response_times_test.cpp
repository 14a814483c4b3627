#include "baselines/response_times.h"

#include <gtest/gtest.h>

#include <vector>

namespace ctn::baselines {
namespace {

// A well-known set: costs 1, 2, 3 and periods 4, 6, 12 give 1, 3 and 10.
TEST(ResponseTimes, AreThoseOfATextbook) {
  const std::vector<PeriodicTask> tasks = {{1.0, 4.0}, {2.0, 6.0}};
  EXPECT_DOUBLE_EQ(*response_time(1.0, {}, 4.0), 1.0);
  EXPECT_DOUBLE_EQ(*response_time(2.0, {tasks.data(), 1}, 6.0), 3.0);
  EXPECT_DOUBLE_EQ(*response_time(3.0, tasks, 12.0), 10.0);
  EXPECT_FALSE(response_time(3.0, tasks, 9.9));
}

TEST(ResponseTimes, EndWhereHigherTasksTakeAllOfTheCore) {
  const std::vector<PeriodicTask> tasks = {{1.0, 1.0}};
  EXPECT_FALSE(response_time(0.1, tasks, 1e6));
}

TEST(ResponseTimes, AWholeQuotientButForRoundingCountsOnce) {
  const std::vector<PeriodicTask> tasks = {{0.1, 0.3}};
  EXPECT_NEAR(*response_time(0.2, tasks, 10.0), 0.3, 1e-12);
}

}  // namespace
}  // namespace ctn::baselines
