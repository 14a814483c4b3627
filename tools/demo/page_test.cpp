#include "page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sample.h"

namespace ctn::demo {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST(Figures, HaveAPanelForEachNumberOfCores) {
  const auto figure = response_figure(summarise(sample_results()), 1.0);
  ASSERT_EQ(figure.panels.size(), 2U);
  for (const auto& panel : figure.panels) {
    ASSERT_EQ(panel.series.size(), 3U);
    EXPECT_EQ(panel.series[0].points.size(), 3U);  // two rates and the default
    EXPECT_EQ(panel.series[1].points.size(), 1U);
    EXPECT_EQ(panel.series[2].points.size(), 1U);  // the prediction
    EXPECT_EQ(panel.markers.size(), 2U);
    EXPECT_LT(panel.series[0].points[0].x, panel.series[0].points[1].x);
  }
}

TEST(Page, TellsItAll) {
  const auto page = render_page(sample_results());
  ASSERT_TRUE(page.ok()) << page.error().message();
  EXPECT_THAT(*page, HasSubstr("within 5 %"));
  EXPECT_THAT(*page, HasSubstr("<svg"));
  EXPECT_THAT(*page, HasSubstr("made up"));
  EXPECT_THAT(*page, HasSubstr("Slowdown"));
  EXPECT_THAT(*page, Not(HasSubstr("Rates only")));
}

TEST(Page, OwnsUpToRatesOnlyAndToStoppingEarly) {
  Results results = sample_results();
  results.no_real_time = "the kernel said no.";
  results.complete = false;
  results.slowdown = 2.0;
  for (Measured& run : results.runs) run.others = 0.4;
  const auto page = render_page(results);
  ASSERT_TRUE(page.ok());
  EXPECT_THAT(*page, HasSubstr("Rates only: the kernel said no."));
  EXPECT_THAT(*page, HasSubstr("Stopped early"));
  EXPECT_THAT(*page, HasSubstr("Other programs used 40 %"));
  EXPECT_THAT(*page, HasSubstr("Slowdown 2"));
}

TEST(Rounds, SayInWhichOfThemRatesSetByHandWereTried) {
  const auto without_sweep_in_rounds_from = [](int first, int rounds) {
    Results results = sample_results();
    std::erase_if(results.runs, [&](const Measured& run) {
      return run.trial.round > rounds || (run.trial.round >= first && run.trial.scheduler.starts_with("rate:"));
    });
    return rounds_text(results);
  };
  EXPECT_THAT(without_sweep_in_rounds_from(3, 3),
              HasSubstr("three interleaved rounds, rates set by hand in the first two; all"));
  EXPECT_THAT(without_sweep_in_rounds_from(2, 3),
              HasSubstr("three interleaved rounds, rates set by hand in the first alone; all"));
  EXPECT_THAT(without_sweep_in_rounds_from(3, 2), HasSubstr("two interleaved rounds; all")) << "they were in both";
  EXPECT_EQ(without_sweep_in_rounds_from(2, 1),
            "12 trials of 3.0 s at most in one round, in which all give the face the same walk. The sweep was made at "
            "1.0 rad/s.");
  EXPECT_THAT(without_sweep_in_rounds_from(1, 2), Not(HasSubstr("sweep"))) << "there was none";
}

TEST(Text, NamesEveryClaim) {
  const std::string text = to_text(sample_results());
  EXPECT_THAT(text, HasSubstr("held 1 core: Response time within 5 %"));
  EXPECT_THAT(text, HasSubstr("slowdown 1"));
}

}  // namespace
}  // namespace ctn::demo
