#include "claims.h"

#include <gtest/gtest.h>

#include "sample.h"

namespace ctn::case_studies {
namespace {

// Of a figure that is the better the lower: by `theirs` in 90 of 100 pairs, ours has 600.
Row beside_600(const Study& study, double theirs, double in_the_others) {
  Runs runs;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    runs["catan"].push_back({seed, {{"score", 600.0}}, {}});
    runs["other"].push_back({seed, {{"score", seed <= 90 ? theirs : in_the_others}}, {}});
  }
  return compare_two(study.metrics[1], study.batches[1], study.batches[0], runs);
}

// Ours, of all pairs of beside_600().
Row of_600(const Study& study) {
  Row row{.metric = &study.metrics[1], .batch = &study.batches[0], .runs = 100, .share = {}, .spread = {}};
  row.spread = program::spread_of(std::vector<double>(100, 600.0));
  return row;
}

TEST(Claims, OnMeansAreNotShownByATestThatFoundTheReverse) {
  const Study study = sample_study();
  const Row ours = of_600(study);
  EXPECT_EQ(lower_mean("", ours, beside_600(study, 601.0, 605.0)).verdict, Verdict::kHeld);
  EXPECT_EQ(lower_mean("", ours, beside_600(study, 599.0, 599.0)).verdict, Verdict::kFailed);
  const Row seldom_far_higher = beside_600(study, 599.0, 1100.0);
  ASSERT_GT(seldom_far_higher.spread->mean, 600.0);
  EXPECT_EQ(lower_mean("", ours, seldom_far_higher).verdict, Verdict::kNotShown);
  EXPECT_EQ(no_higher_mean("", ours, seldom_far_higher).verdict, Verdict::kNotShown);
  EXPECT_EQ(no_higher_mean("", ours, seldom_far_higher, true).verdict, Verdict::kHeld) << "it is as low as can be";
}

}  // namespace
}  // namespace ctn::case_studies
