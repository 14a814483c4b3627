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

TEST(LifeStudy, IsLeftOutWhereItCannotBeRun) {
  Setting setting;
  setting.no_life = "It takes two CPUs.";
  EXPECT_EQ(life(setting).missing, setting.no_life);
  EXPECT_TRUE(life({}).missing.empty());
}

}  // namespace
}  // namespace ctn::case_studies
