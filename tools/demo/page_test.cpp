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

TEST(Text, NamesEveryClaim) {
  const std::string text = to_text(sample_results());
  EXPECT_THAT(text, HasSubstr("held 1 core: Response time within 5 %"));
  EXPECT_THAT(text, HasSubstr("slowdown 1"));
}

}  // namespace
}  // namespace ctn::demo
