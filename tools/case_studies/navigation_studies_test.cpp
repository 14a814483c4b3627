#include "navigation_studies.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "comparison.h"
#include "report/plot.h"
#include "sample.h"

namespace ctn::case_studies {
namespace {

using ::testing::Contains;
using ::testing::IsEmpty;
using ::testing::Not;

// Runs as they would come out if all went as one hopes: what is lower the better is 1 under Catan, and 2 under the
// others.
Runs hoped_for(const Study& study) {
  Runs runs;
  for (const Batch& batch : study.batches) {
    const bool ours = batch.reference || study.id == "life";
    const double value = ours ? 1.0 : 2.0;
    for (int number = 0; number < 12; ++number) {
      StoredRun run;
      run.seed = 1 + static_cast<std::uint64_t>(number);
      for (const char* figure :
           {"staleness_ms_p95", "staleness_ms_mean", "explored_90_s", "objective_ms", "goal_s", "reaction_ms_mean",
            "reaction_ms_p95", "response_ms_mean laser -> scan -> LM -> LP -> base"}) {
        run.figures[figure] = value + 0.01 * number;
      }
      run.figures["collided"] = ours ? 0.0 : 1.0;
      run.figures["reached_goal"] = 1.0;
      run.figures["barn_score"] = ours ? 0.5 : 0.0;
      run.figures["appearances"] = 2.0;
      run.figures["reacted"] = ours ? 2.0 : 1.0;
      const bool without = batch.name.ends_with("without-stealing");
      run.by_time["staleness_ms_p95_by_5s"] = ByTime(20, without ? 3.0 : value);
      run.by_time["detector_period_ms_by_10s"] = ByTime(10, value);
      run.by_time["objective_ms_by_10s"] = ByTime(10, value);
      runs[batch.name].push_back(run);
    }
  }
  return runs;
}

class NavigationStudies : public ::testing::TestWithParam<std::string> {
 protected:
  Study study(const Setting& setting = {}) const { return study_with(GetParam(), setting); }
};

TEST_P(NavigationStudies, HoldIfAllIsAsHopedFor) {
  const Study of = study();
  const Runs runs = hoped_for(of);
  ASSERT_TRUE(is_complete_enough(of, runs));
  const std::vector<Claim> claims = of.claim(of, runs);
  EXPECT_THAT(claims, Not(IsEmpty()));
  for (const Claim& claim : claims) EXPECT_EQ(claim.verdict, Verdict::kHeld) << claim.text << ": " << claim.measured;
}

TEST_P(NavigationStudies, DoNotHoldWhereOthersAreTheBetterOnes) {
  const Study of = study();
  Runs runs = hoped_for(of);
  for (auto& [name, batch] : runs) {
    const bool ours = name.ends_with("catan") || name.ends_with("virtual");
    const bool longer = ours || name == "paper";  // stealing makes it so
    for (StoredRun& run : batch) {
      for (auto& [figure, value] : run.figures) value = ours ? 3.0 : 0.0;
      for (auto& [list, values] : run.by_time) std::ranges::fill(values, longer ? 3.0 : 1.0);
    }
  }
  for (const Claim& claim : of.claim(of, runs)) {
    if (claim.text.find("BARN") == std::string::npos) {
      EXPECT_EQ(claim.verdict, Verdict::kFailed) << claim.text << ": " << claim.measured;
    }
  }
}

TEST_P(NavigationStudies, DrawFigures) {
  const Study of = study();
  if (!of.draw) return;
  for (const Drawn& drawn : of.draw(of, hoped_for(of))) {
    const auto svg = report::render_svg(drawn.figure);
    EXPECT_TRUE(svg.ok()) << svg.error().message();
  }
}

TEST_P(NavigationStudies, AreOnTheMapsThatAreAsked) {
  Setting setting;
  setting.map1 = "mine.yaml";
  setting.map2 = "other.yaml";
  const Study of = study(setting);
  for (const Batch& batch : of.batches) {
    EXPECT_THAT(batch.arguments, Not(Contains("1.yaml")));
    const auto map = std::ranges::find(batch.arguments, "--map") + 1;
    EXPECT_TRUE(*map == "mine.yaml" || *map == "other.yaml" || *map == "crowd") << *map;
  }
}

INSTANTIATE_TEST_SUITE_P(All, NavigationStudies, ::testing::ValuesIn(ids_of_studies("navigation")), as_name);

Verdict verdict_on(const Study& study, const Runs& runs, const std::string& text) {
  for (const Claim& claim : study.claim(study, runs)) {
    if (claim.text.find(text) != std::string::npos) return claim.verdict;
  }
  ADD_FAILURE() << "no claim says " << text;
  return {};
}

// Runs without a value were left out, so that the worst runs of a scheduler improved its figure.
TEST(DetectorStudy, WhatStarvesCounts) {
  const Study study = detector({});
  Runs runs = hoped_for(study);
  for (const char* batch : {"1-core/catan", "2-cores/catan"}) {
    for (std::size_t number = 0; number < 7; ++number) {
      StoredRun& run = runs.at(batch)[number];
      run.figures.erase("objective_ms");
      for (auto& [list, values] : run.by_time) {
        std::fill(values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end(), std::nullopt);
      }
    }
  }
  EXPECT_NE(verdict_on(study, runs, "staleness is lower than Static-20s's in the second half"), Verdict::kHeld);
  EXPECT_NE(verdict_on(study, runs, "objective of whole runs is lower than Static-FullRun's"), Verdict::kHeld);
  EXPECT_NE(verdict_on(study, runs, "lower than that of both in 95 %"), Verdict::kHeld);
  EXPECT_EQ(verdict_on(study, runs, "period is shorter than Static-FullRun's in the first half"), Verdict::kHeld);
  for (StoredRun& run : runs.at("2-cores/catan")) std::ranges::fill(run.by_time.begin()->second, std::nullopt);
  EXPECT_NE(verdict_on(study, runs, "at most 0.6 of Static-FullRun's"), Verdict::kHeld);
}

// So many runs with a collision, of those in life beside those in virtual time of one scheduler.
Runs colliding(const Study& study, std::size_t runs_each, std::size_t in_life, std::size_t in_virtual_time) {
  Runs runs = hoped_for(study);
  for (auto& [name, batch] : runs) {
    batch.resize(runs_each);
    const std::size_t count = name.ends_with("/life") ? in_life : in_virtual_time;
    for (std::size_t i = 0; i < runs_each; ++i) batch[i].figures["collided"] = i < count ? 1.0 : 0.0;
  }
  return runs;
}

TEST(LifeStudy, DifferencesMayNotHideBehindFewRunsOrSeveralTests) {
  const Study study = life({});
  const auto verdict = [&](const Runs& runs) {
    return verdict_on(study, runs, "Catan: collisions in life and in virtual time differ by chance alone");
  };
  EXPECT_EQ(verdict(colliding(study, 10, 0, 5)), Verdict::kFailed) << "p is 0.033, and that of three tests is not";
  EXPECT_EQ(verdict(colliding(study, 2, 0, 0)), Verdict::kNotShown) << "0 of 2 beside 2 of 2 may be chance";
  EXPECT_EQ(verdict(colliding(study, 10, 1, 2)), Verdict::kHeld);
}

TEST(LifeStudy, IsLeftOutWhereItCannotBeRun) {
  Setting setting;
  setting.no_life = "It takes two CPUs.";
  EXPECT_EQ(life(setting).missing, setting.no_life);
  EXPECT_TRUE(life({}).missing.empty());
}

}  // namespace
}  // namespace ctn::case_studies
