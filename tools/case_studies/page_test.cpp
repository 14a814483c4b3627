#include "page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "figures.h"
#include "map_picture.h"
#include "sample.h"

namespace ctn::case_studies {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

Results sample_results() {
  Results results;
  results.host = {{"Processor", "made up"}};
  results.seed = 11;
  results.studies = {{sample_study(), sample_runs(std::numeric_limits<double>::infinity())}};
  results.studies[0].study.draw = [](const Study& study, const Runs& runs) -> std::vector<Drawn> {
    return {{by_batch(study, runs, "Score"), "higher is better"},
            {over_time(study, runs, {{"catan", "other"}, "x_by_1s", 1.0, "X", "ms"}), "lower is better"}};
  };
  return results;
}

TEST(CaseStudiesPage, TellsItAll) {
  const auto page = render_page(sample_results());
  ASSERT_TRUE(page.ok()) << page.error().message();
  for (const char* text : {"A study &lt;made up&gt;", "<svg", "16 of 16", "1 held, 1 not shown, 1 did not hold",
                           "It is so", "&lt; 0.001", "not shown", "8 of 8", "68 to 100 %", "never", "4.5 \u00b1 2.4",
                           "<td>worse</td><td>0.001</td>", "higher is better", "Seeds from 11 on", "made up"}) {
    EXPECT_THAT(*page, HasSubstr(text));
  }
  EXPECT_THAT(*page, AllOf(Not(HasSubstr("src=\"http")), Not(HasSubstr("Not all runs")), Not(HasSubstr("quick run"))));
}

TEST(CaseStudiesPage, OwnsUpToWhatIsBetterThanCatan) {
  const auto page = render_page(sample_results());
  ASSERT_TRUE(page.ok());
  EXPECT_THAT(*page, Not(HasSubstr("Nowhere by more than chance"))) << "the other never collides";
  EXPECT_THAT(to_text(sample_results()), HasSubstr("better than the reference, by more than chance"));
  Results equal = sample_results();
  equal.studies[0].runs["other"] = equal.studies[0].runs["catan"];
  EXPECT_THAT(*render_page(equal), HasSubstr("Nowhere by more than chance"));
}

TEST(CaseStudiesPage, OwnsUpToWhatIsMissing) {
  Results results = sample_results();
  results.quick = true;
  results.failed = {"sample/other, run 3 of 8"};
  results.left_out = {"sample/other: run-3.json is of another map"};
  results.studies[0].runs["other"].resize(1);
  Study other = sample_study();
  other.title = "In life";
  other.missing = "It takes two CPUs.";
  results.studies.push_back({other, {}});
  const auto page = render_page(results);
  ASSERT_TRUE(page.ok());
  for (const char* text : {"Not all runs are there: 9 of 16", "A quick run", "Failed: sample/other, run 3 of 8",
                           "sample/other: run-3.json is of another map.", "Too few runs are there yet",
                           "In life: left out. It takes two CPUs."}) {
    EXPECT_THAT(*page, HasSubstr(text));
  }
  EXPECT_THAT(to_text(results), AllOf(HasSubstr("0 held"), HasSubstr("NOT USED   sample/other: run-3.json"),
                                      HasSubstr("left out   In life: It takes two CPUs.")));
}

TEST(Figures, OfBatchesHaveAPlaceAndAnIntervalEach) {
  const report::Figure figure = by_batch(sample_study(), sample_runs(0.0), "Collisions");
  const report::Panel& panel = figure.panels.at(0);
  ASSERT_EQ(panel.x.ticks.size(), 2U);
  EXPECT_EQ(panel.x.ticks[1].label, "another");
  EXPECT_EQ(panel.series[0].points.at(0).y, 0.0);
  EXPECT_EQ(panel.series[1].points.at(0).y, 100.0) << "the reference's";
  EXPECT_EQ(panel.series[1].points[0].high, 100.0);
  EXPECT_NEAR(*panel.series[1].points[0].low, 67.6, 0.1);
}

TEST(Figures, OverTimeArePointsInTheMiddleOfStretches) {
  const report::Figure figure =
      over_time(sample_study(), sample_runs(0.0), {{"other", "catan"}, "x_by_1s", 10.0, "X", "ms"});
  const report::Panel& panel = figure.panels.at(0);
  ASSERT_EQ(panel.series.size(), 2U);
  EXPECT_EQ(panel.series[0].label, "another");
  EXPECT_EQ(panel.series[1].points.at(2).x, 25.0);
  EXPECT_EQ(panel.series[1].points[2].y, 3.0);
  EXPECT_EQ(colour_of("1-core/catan"), report::Colour::kBlue);
}

TEST(Figures, MapsHaveWallsMoversAndAGoal) {
  const auto world = navigation::world::parse_world(R"(
catan_world: 1
name: a <room>
walls: [[[0, 0], [8, 0], [8, 5], [0, 5], [0, 0]]]
robot: { at: [1, 1], heading: 90 }
goal: [7, 4]
movers:
  - { path: [[4, 1], [4, 4]], speed: 0.5, radius: 0.3 }
  - { path: [[5, 1], [5, 4]], speed: 0.5, size: [0.5, 0.3], closed: true }
)",
                                                    "w", ".");
  ASSERT_TRUE(world.ok()) << world.error().message();
  const std::string picture = map_picture(*world);
  for (const char* part : {"<title>a &lt;room&gt;</title>", "currentColor", "<circle", "Z'", "rotate(-90 1 -1)"}) {
    EXPECT_THAT(picture, HasSubstr(part));
  }
}

}  // namespace
}  // namespace ctn::case_studies
