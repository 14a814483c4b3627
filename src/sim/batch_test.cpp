#include "sim/batch.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>
#include <vector>

namespace ctn::sim {
namespace {

TEST(Progress, GoesOnFromWhatWasDoneBefore) {
  std::vector<std::size_t> told;
  Progress progress([&](std::size_t done) { told.push_back(done); }, 2);
  progress.add();
  progress.add();
  EXPECT_EQ(told, (std::vector<std::size_t>{3, 4}));
}

// Guards: the callback was called under a lock that the worker took.
TEST(Progress, NoWorkerWaitsForTheOneThatTells) {
  constexpr std::size_t kCount = 10;
  constexpr int kTries = 10'000'000;  // if it never happens
  std::atomic<std::size_t> added{0};
  std::atomic<int> under_way{0};
  std::vector<std::size_t> told;
  Progress progress([&](std::size_t done) {
    EXPECT_EQ(under_way.fetch_add(1), 0) << "one call at a time";
    told.push_back(done);
    for (int tries = 0; added.load() < kCount - 1 && tries < kTries; ++tries) std::this_thread::yield();
    under_way.fetch_sub(1);
  });
  for_each_in_parallel(kCount, 2, [&](std::size_t) {
    progress.add();
    added.fetch_add(1);
  });
  EXPECT_EQ(told, (std::vector<std::size_t>{1, kCount})) << "the rest was done during the first call";
}

}  // namespace
}  // namespace ctn::sim
