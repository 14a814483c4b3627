#include "report/plot.h"

#include <gmock/gmock.h>
#include <stdlib.h>  // setenv: POSIX

#include <filesystem>
#include <limits>

#include "base/numbers.h"
#include "report/escape.h"
#include "report/html.h"
#include "report/plot_script.h"

namespace ctn::report {
namespace {

using testing::HasSubstr;
using testing::Not;

Figure figure() {
  Panel panel{.title = "Response time", .x = {.label = "Source rate (Hz)"}, .y = {.label = "ms"}};
  panel.series.push_back({.label = "measured", .points = {{10, 122, 110, 140}, {30, 55, 50, 60}, {60, 59, 55, 66}}});
  panel.series.push_back({.label = "predicted", .points = {{10, 120}, {60, 40}}, .line = Line::kDashed});
  panel.markers.push_back({.x = 44, .label = "Catan: 44 Hz"});
  panel.levels.push_back({.y = 100, .label = "bound"});
  return {.title = "Face <tracking>", .panels = {panel, panel}};
}

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t found = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++found;
  return found;
}

TEST(Plot, IsOneSelfContainedElement) {
  const auto svg = render_svg(figure());
  ASSERT_TRUE(svg.ok()) << svg.error().message();
  EXPECT_EQ(svg->find("<svg"), 0U);
  EXPECT_EQ(count(*svg, "</svg>"), 1U);
  EXPECT_EQ(count(*svg, "Catan: 44 Hz"), 2U);
  EXPECT_EQ(count(*svg, "<title>Face &lt;tracking&gt;</title>"), 1U);
  EXPECT_GT(count(*svg, "currentColor"), 10U);
  EXPECT_EQ(count(*svg, "<title>"), 1U) << "gnuplot's own would show as tooltips";
  EXPECT_EQ(count(*svg, "<script"), 0U);
  EXPECT_EQ(count(*svg, "href=\"http"), 0U);
  for (const char* left : {"color=\"black\"", "fill=\"black\"", "color='white'", "CatanFont"}) {
    EXPECT_EQ(svg->find(left), std::string::npos) << left << " shows on a page of another colour";
  }
}

TEST(Plot, StandsAloneOnWhite) {
  const auto svg = render_svg(figure(), SvgUse::kStandalone);
  ASSERT_TRUE(svg.ok());
  EXPECT_EQ(svg->find("<?xml"), 0U);
  EXPECT_EQ(count(*svg, "fill=\"#ffffff\""), 1U);
}

TEST(Plot, FiguresOfOnePageShareNoIds) {
  Figure other = figure();
  other.panels.pop_back();
  const auto id = [](const std::string& svg) { return svg.substr(svg.find(" id="), 16); };
  EXPECT_NE(id(*render_svg(figure())), id(*render_svg(other)));
  EXPECT_EQ(*render_svg(other), *render_svg(other));
}

TEST(Plot, LabelsAreTextAndNothingElse) {
  const std::string mark = testing::TempDir() + "/catan-plot-test-ran";
  std::filesystem::remove(mark);
  Figure odd = figure();
  for (const std::string& text :
       {"`touch " + mark + "`", "'; system('touch " + mark + "') #", "\"; !touch " + mark,
        std::string("a\n!touch ") + mark + "\nb", std::string("\xff\xfe{/=80 x}_2^3 & <b>")}) {
    odd.title = odd.panels[0].title = odd.panels[0].x.label = odd.panels[0].series[0].label = text;
    odd.panels[0].markers[0].label = odd.panels[0].levels[0].label = text;
    const auto svg = render_svg(odd);
    ASSERT_TRUE(svg.ok()) << svg.error().message();
    EXPECT_EQ(svg->find("<b>"), std::string::npos);
    EXPECT_EQ(svg->find('\xff'), std::string::npos) << "no UTF-8: the page would be broken";
    EXPECT_FALSE(std::filesystem::exists(mark)) << text;
  }
}

TEST(Plot, DrawsWhatItCanOfOddData) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<std::vector<Point>> odd{{},
                                            {{1, nan}, {kInfinity, 2}},
                                            {{1, 1}},
                                            {{5, 5}, {5, 5}},
                                            {{-1, 0}, {0, -3}, {2, 7}},
                                            {{1e-300, 1e300}, {1e9, 1e-9}}};
  for (const auto& points : odd) {
    for (const bool log : {false, true}) {
      Panel panel{.x = {.log = log}, .y = {.log = log}, .series = {{.label = "s", .points = points}}};
      const auto svg = render_svg({.panels = {panel}});
      EXPECT_TRUE(svg.ok()) << svg.error().message();
    }
  }
}

TEST(Plot, NarrowLogarithmicAxesHaveTicsToo) {
  Panel panel{.y = {.log = true}, .series = {{.label = "s", .points = {{1, 74}, {2, 137}}}}};
  const auto svg = render_svg({.panels = {panel}});
  ASSERT_TRUE(svg.ok()) << svg.error().message();
  for (const char* tic : {"80", "100", "120"}) EXPECT_THAT(*svg, HasSubstr(std::string(">") + tic + "<"));
}

TEST(Plot, TicksHaveTextsOfTheirOwnWhichSlantWhereThereIsNoRoom) {
  Panel panel{.series = {{.label = "s", .points = {{1, 74}, {2, 137}}}}};
  panel.x.ticks = {{1, "one"}, {2, "the other's"}};
  const auto level = render_svg({.panels = {panel}});
  ASSERT_TRUE(level.ok()) << level.error().message();
  EXPECT_THAT(*level, HasSubstr("one"));
  EXPECT_THAT(*level, HasSubstr("the other\u2019s"));
  EXPECT_THAT(*level, Not(HasSubstr(">1.2<")));
  EXPECT_THAT(plot_script({.panels = {panel}}), Not(HasSubstr("rotate by 25")));
  panel.x.ticks[1].label = std::string(100, 'x');
  EXPECT_THAT(plot_script({.panels = {panel}}), HasSubstr("rotate by 25"));
}

TEST(Plot, SaysWhatToInstall) {
  const std::string path = getenv("PATH");
  setenv("PATH", "/nowhere", 1);
  const auto svg = render_svg(figure());
  setenv("PATH", path.c_str(), 1);
  ASSERT_FALSE(svg.ok());
  EXPECT_EQ(svg.error().kind(), ErrorKind::kEnvironment);
  EXPECT_THAT(svg.error().message(), HasSubstr("apt-get install gnuplot-nox"));
}

TEST(Escape, LeavesNothingThatMarksUp) {
  EXPECT_EQ(escaped("a<b>&\"'ü\n"), "a&lt;b&gt;&amp;&quot;&#39;ü\n");
  EXPECT_EQ(escaped("\x01\xff\xc0\xaf\xed\xa0\x80"),
            "\xEF\xBF\xBD\xEF\xBF\xBD\xEF\xBF\xBD\xEF\xBF\xBD\xEF\xBF\xBD\xEF\xBF\xBD\xEF\xBF\xBD");
}

TEST(PageTest, IsSelfContainedAndEscaped) {
  Page page("A <title>", "lead & more");
  page.section("S<").paragraph("p<").note("n<").code("c<").facts({{"f<", "v<"}}).figure("<svg></svg>", "caption<");
  page.table({{"h<", "n"}, {{"x<", "1.5 ms"}, {"y"}}, "t<"});
  const std::string html = page.html();
  EXPECT_EQ(html.find("<!DOCTYPE html>"), 0U);
  for (const char* text :
       {"S&lt;", "p&lt;", "n&lt;", "c&lt;", "f&lt;", "v&lt;", "caption&lt;", "h&lt;", "x&lt;", "t&lt;"}) {
    EXPECT_THAT(html, HasSubstr(text));
  }
  EXPECT_THAT(html, HasSubstr("<td class=\"number\">1.5 ms</td>"));
  EXPECT_THAT(html, HasSubstr("<svg></svg>"));
  EXPECT_THAT(html, Not(HasSubstr("http")));
}

TEST(TableTest, AlignsNumbersToTheRight) {
  EXPECT_EQ(to_text({{"name", "ms", "none"}, {{"a", "1.5", ""}, {"bü", "10.25"}}, ""}),
            "  name     ms\n  a       1.5\n  bü    10.25\n");
}

}  // namespace
}  // namespace ctn::report
