#include "comparison.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sample.h"

namespace ctn::case_studies {
namespace {

TEST(Comparison, SharesByFisher) {
  const Study study = sample_study();
  const std::vector<Row> rows = compare(study, sample_runs(0.0));
  EXPECT_EQ(row_of(rows, "Collisions", "catan").share, (Share{8, 8}));
  EXPECT_FALSE(row_of(rows, "Collisions", "catan").probability) << "it is the reference";
  const Row& other = row_of(rows, "Collisions", "other");
  EXPECT_EQ(other.share, (Share{0, 8}));
  EXPECT_LT(*other.probability, 0.001);
  EXPECT_TRUE(other.better());
  EXPECT_FALSE(other.worse());
}

TEST(Comparison, PairsOfOneSeedShowWhatRanksWouldNot) {
  Study study = sample_study();
  Row other = row_of(compare(study, sample_runs(0.0)), "Score", "other");
  EXPECT_TRUE(other.worse()) << "by 1 in each of eight pairs";
  EXPECT_EQ(other.sign, -1);
  study.metrics[1].method = Method::kRanks;
  EXPECT_FALSE(row_of(compare(study, sample_runs(0.0)), "Score", "other").significant());
}

// The mean points the other way, which the page took for the direction that the test of ranks had found.
TEST(Comparison, PairsHaveTheDirectionThatTheirRanksHave) {
  const Study study = sample_study();
  Runs runs;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    runs["catan"].push_back({seed, {{"score", 600.0}}, {}});
    runs["other"].push_back({seed, {{"score", seed <= 90 ? 599.0 : 1100.0}}, {}});
  }
  const Row row = row_of(compare(study, runs), "Score", "other");
  EXPECT_GT(row.spread->mean, 600.0);
  EXPECT_LT(*row.probability, 1e-6);
  EXPECT_EQ(row.sign, -1);
  EXPECT_TRUE(row.worse()) << "scores are the better the higher";
}

TEST(Comparison, WhatNeverCameIsLatest) {
  const Study study = sample_study();
  const std::vector<Row> rows = compare(study, sample_runs(100.0));
  EXPECT_EQ(row_of(rows, "Time", "catan").runs, 8U);
  EXPECT_EQ(row_of(rows, "Time", "catan").spread->median, 4.0);
  EXPECT_TRUE(std::isinf(row_of(rows, "Time", "catan").spread->mean));
  EXPECT_TRUE(row_of(rows, "Time", "other").worse());
  EXPECT_FALSE(row_of(compare(study, sample_runs(0.0)), "Time", "other").significant());
}

TEST(Comparison, WithoutAJudgementNothingIsBetter) {
  Study study = sample_study();
  study.metrics[0].better = Better::kNeither;
  const std::vector<Row> rows = compare(study, sample_runs(0.0));
  const Row& other = row_of(rows, "Collisions", "other");
  EXPECT_TRUE(other.significant());
  EXPECT_FALSE(other.better());
  EXPECT_FALSE(other.worse());
}

TEST(Comparison, EachGroupHasItsReference) {
  Study study = sample_study();
  Batch more = study.batches[1];
  more.name = "more";
  more.group = "of its own";
  study.batches.push_back(more);
  Runs runs = sample_runs(0.0);
  runs["more"] = runs["other"];
  const std::vector<Row> rows = compare(study, runs);
  EXPECT_TRUE(row_of(rows, "Collisions", "other").probability);
  EXPECT_FALSE(row_of(rows, "Collisions", "more").probability);
}

TEST(Comparison, TwoBatchesOfAnyGroupsAreOneTest) {
  Study study = sample_study();
  study.batches[1].group = "of its own";
  const Runs runs = sample_runs(0.0);
  EXPECT_FALSE(row_of(compare(study, runs), "Score", "other").probability) << "it has no reference in its group";
  const Row row = compare_two(study.metrics[1], study.batches[1], study.batches[0], runs);
  EXPECT_EQ(row.batch, &study.batches[1]);
  EXPECT_EQ(row.runs, 8U);
  EXPECT_EQ(row.spread->mean, 3.5);
  EXPECT_TRUE(row.worse());
  EXPECT_NEAR(*row.probability, 2.0 / 256.0, 1e-12) << "all of eight differences have one sign";
  EXPECT_FALSE(compare_two(study.metrics[1], study.batches[1], study.batches[0], {}).probability);
}

TEST(Comparison, SeveralTestsOfOneFigureAskForMore) {
  Study study = sample_study();
  Runs runs = sample_runs(0.0);
  const double alone = *row_of(compare(study, runs), "Collisions", "other").probability;
  Batch more = study.batches[1];
  more.name = "more";
  study.batches.push_back(more);
  runs["more"] = runs["other"];
  EXPECT_NEAR(*row_of(compare(study, runs), "Collisions", "other").probability, 2.0 * alone, 1e-12);
}

TEST(Comparison, LowestByTimeCountsStretches) {
  const Share share = lowest_by_time(sample_runs(0.0), "catan", {"other"}, "x_by_1s");
  EXPECT_EQ(share, (Share{1, 3})) << "lower in the first, equal in the second";
  EXPECT_EQ(lowest_by_time(sample_runs(0.0), "catan", {"other"}, "none"), (Share{0, 0}));
}

// Stretches in which one of them came to nothing were not counted, so that starving improved the share.
TEST(Comparison, LowestByTimeCountsWhatStarves) {
  const auto of = [](const ByTime& list) { return std::vector<StoredRun>(3, {1, {}, {{"x_by_1s", list}}}); };
  const std::optional<double> none;
  const auto share = [&](const ByTime& ours, const ByTime& theirs) {
    return lowest_by_time({{"catan", of(ours)}, {"other", of(theirs)}}, "catan", {"other"}, "x_by_1s");
  };
  EXPECT_EQ(share({1.0, none, none}, {2.0, 2.0, 2.0}), (Share{1, 3})) << "it is not lowest where it has none";
  EXPECT_EQ(share({1.0, 1.0}, {2.0, none}), (Share{2, 2})) << "it is where the other has none";
  EXPECT_EQ(share({none, 1.0}, {none, 2.0}), (Share{1, 1})) << "nobody had begun";
  EXPECT_EQ(share({1.0, 1.0}, {2.0}), (Share{1, 1})) << "the other had come to its end";
}

TEST(Comparison, ProbabilitiesAsText) {
  EXPECT_EQ(probability_text(0.0002), "< 0.001");
  EXPECT_EQ(probability_text(0.0312), "0.031");
  EXPECT_EQ(probability_text(0.514), "0.51");
}

}  // namespace
}  // namespace ctn::case_studies
