#include "page/page.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <memory>
#include <set>
#include <string>
#include <utility>

#include <nlohmann/json.hpp>

#include "page/assets.h"
#include "page/buckets.h"
#include "page/comparison.h"
#include "page/detail.h"
#include "page/graph_picture.h"
#include "page/late.h"
#include "page/losses.h"
#include "page/pack.h"
#include "plan/json.h"
#include "record/testing/record_fixture.h"
#include "why/history.h"

namespace ctn::page {
namespace {

using namespace record::test;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

TEST(Pack, NumbersTakeAsManyBytesAsTheyNeed) {
  Packer packed;
  for (const std::int64_t number : {0, 127, 128, 300}) packed.add(number);
  EXPECT_EQ(packed.text(), "AH+AAawC") << "00 7f 80 01 ac 02";
  Packer negative;
  negative.add(-5);
  EXPECT_EQ(negative.text(), "AA==") << "0";
}

TEST(Palette, IsThatOfTheScript) {
  ASSERT_EQ(palette().size(), 10U);
  for (const char* const colour : palette()) {
    EXPECT_THAT(colour, testing::MatchesRegex("#[0-9a-f]{6}"));
    EXPECT_THAT(kScript, HasSubstr(std::string("'") + colour + "'"));
  }
}

TEST(Detail, TakesWhatIsWantedFirstAndThenWhatFits) {
  const std::vector<std::size_t> cost{4, 1, 1, 5, 1, 1};
  const std::vector<std::size_t> wanted{3, 5, 3};
  EXPECT_THAT(choose(cost, wanted, 7), ElementsAre(false, true, false, true, false, true));
  EXPECT_THAT(choose(cost, wanted, 4), ElementsAre(false, true, true, false, true, true)) << "3 costs too much";
  EXPECT_THAT(choose(cost, wanted, 0), ElementsAre(false, false, false, false, false, false));
  EXPECT_THAT(choose(cost, wanted, 13), ElementsAre(true, true, true, true, true, true));
}

TEST(Detail, NeighboursAreOneWindow) {
  const Detail detail{.duration = 500, .cells = {true, true, false, false, true}};
  EXPECT_THAT(detail.windows(), ElementsAre(0, 200, 400, 500));
  EXPECT_EQ(detail.covered(), 300);
  EXPECT_TRUE(detail.has(199));
  EXPECT_FALSE(detail.has(200));
  EXPECT_TRUE(detail.has(500)) << "the last instant";
  EXPECT_FALSE(detail.whole());
}

TEST(Bands, AreOfEachBucketThatHasSamples) {
  std::vector<Sample> samples;
  for (int i = 1; i <= 20; ++i) samples.push_back({10, static_cast<double>(i)});
  samples.push_back({100, 7.0});
  EXPECT_THAT(bands(samples, 100, 4), ElementsAre(Band{0, 20, 1.0, 10.5, 19.0, 20.0}, Band{3, 1, 7.0, 7.0, 7.0, 7.0}));
  EXPECT_THAT(bands({}, 100, 4), IsEmpty());
}

// The robot, its lanes by hand: local, GL and imu.
class StoryTest : public testing::Test {
 protected:
  StoryTest() {
    story_.app = robot();
    story_.duration = 40'000;
    story_.cores = 1;
    story_.lane_of.assign(story_.app.graph.nodes().size(), kNoLane);
    add_lane({"scan", "LM", "LP"});
    add_lane({"GL"});
    add_lane({"imu"});
  }

  void add_lane(const std::vector<const char*>& names) {
    for (const char* name : names) story_.lane_of[node(name)] = story_.lanes.size();
    story_.lanes.push_back({names.front(), {}});
    story_.triggers.emplace_back();
  }
  std::size_t node(const char* name) const { return story_.app.graph.find_node(name)->index(); }
  RunSpan& add(const char* name, Micros begin, Micros end, float cpu_ms) {
    return story_.runs.emplace_back(
        RunSpan{static_cast<std::uint32_t>(node(name)), 0, story_.runs.size() + 1, begin, end, cpu_ms, 0.0F});
  }
  // The runs, on one CPU; where `turns`, local and GL took turns there in these slots.
  void happened(const std::vector<SlotSpan>& turns = {}) {
    auto history = std::make_shared<why::History>(story_.app, 1);
    for (const SlotSpan& slot : turns) {
      history->add(record::SlotUse{0, SubchainId(slot.lane), at(microseconds{slot.begin}), at(microseconds{slot.begin}),
                                   at(microseconds{slot.end})});
    }
    if (!turns.empty()) {
      EXPECT_TRUE(history->add(in_turns()).ok());
    }
    for (const RunSpan& run : story_.runs) {
      record::Run of;
      of.node = NodeId(run.node);
      of.number = run.number;
      of.begin = at(microseconds{run.begin});
      of.end = at(microseconds{run.end});
      of.cpu = to_nanos(Millis{run.cpu_ms});
      of.wait = to_nanos(Millis{run.wait_ms});
      history->add(of);
    }
    history->sort();
    story_.figures.header.started = at(Nanos{0});
    story_.history = std::move(history);
  }
  record::PlanChange in_turns() const {
    plan::Plan plan;
    plan.planner = "by hand";
    plan.cores.resize(1);
    for (std::size_t id = 0; id < story_.app.graph.subchains().size(); ++id) {
      plan.subchains.push_back({{0}, Millis{20}, Millis{9}, 1, 1.0, Millis{9}, 1});
      plan.cores.front().slots.push_back({SubchainId(id), Millis{0}, Millis{9}, 1, 0});
    }
    for (const graph::Term& term : story_.app.objective) {
      if (term.metric == graph::Metric::kPeriod) {
        plan.nodes.push_back({term.path.front(), Millis{20}, term.weight});
      } else {
        plan.chains.push_back({term.path, Millis{29}, Millis{9}, Millis{20}, term.weight});
      }
    }
    return {at(Nanos{0}), "static", plan::to_json(plan, story_.app)};
  }
  void plan(std::vector<Placement> placements) { story_.plans.push_back({0, "static", std::move(placements), {}}); }

  Story story_;
};

TEST_F(StoryTest, SharesSpreadCpuTimeOverTheRun) {
  add("scan", 5'000, 25'000, 10.0F);  // half of a core, over three of four buckets
  add("GL", 30'000, 40'000, 20.0F);   // on several threads
  const auto shares = busy_shares(story_, 4);
  EXPECT_THAT(shares[0], ElementsAre(64, 128, 64, 0));
  EXPECT_THAT(shares[1], ElementsAre(0, 0, 0, 255)) << "no more than all";
  plan({{1, 0, 0}, {1, 1, 0}});
  EXPECT_THAT(busy_shares(story_, 4)[1], ElementsAre(0, 0, 0, 255)) << "two cores, both busy";
}

TEST_F(StoryTest, RunsThatBeganMeanwhileTookTheCore) {
  add("scan", 2'000, 4'000, 2.0F);
  add("LM", 4'000, 5'000, 1.0F);
  add("scan", 8'000, 9'000, 1.0F);
  const RunSpan low = add("GL", 1'000, 11'000, 6.0F);
  add("LP", 20'000, 30'000, 9.99F);
  const RunSpan high = add("LP", 30'000, 40'000, 9.99F);
  happened();
  EXPECT_THAT(losses_of(story_, low), ElementsAre(Loss{2'000, 5'000, 0}, Loss{8'000, 9'000, 0}));
  EXPECT_THAT(losses_of(story_, high), IsEmpty()) << "so little is no loss";
}

TEST_F(StoryTest, NoMoreIsLostThanIsUnexplained) {
  add("scan", 2'000, 6'000, 4.0F);
  const RunSpan lost_two = add("GL", 1'000, 11'000, 8.0F);
  RunSpan waits = add("GL", 1'000, 11'000, 8.0F);
  waits.wait_ms = 2.0F;
  happened();
  EXPECT_THAT(losses_of(story_, lost_two), ElementsAre(Loss{2'000, 4'000, 0}));
  EXPECT_THAT(losses_of(story_, waits), IsEmpty());
}

TEST_F(StoryTest, WhatOthersRunBetweenItsSlotsTakesTheCore) {
  add("scan", 2'000, 4'500, 2.5F);
  add("LM", 6'000, 7'000, 1.0F);
  const RunSpan low = add("GL", 1'000, 9'000, 4.5F);
  happened(
      {{0, 1, 500, 2'000}, {0, 0, 2'000, 4'500}, {0, 1, 4'500, 6'000}, {0, 0, 6'000, 7'000}, {0, 1, 7'000, 9'000}});
  EXPECT_THAT(losses_of(story_, low), ElementsAre(Loss{2'000, 4'500, 0}, Loss{6'000, 7'000, 0}));
}

TEST_F(StoryTest, WhatTheLaneItselfRunsIsNoLoss) {
  const RunSpan before = add("scan", 1'000, 6'000, 3.0F);
  add("LM", 2'000, 4'000, 2.0F);
  happened();
  EXPECT_THAT(losses_of(story_, before), IsEmpty());
}

TEST_F(StoryTest, TheBeginningAndTheWorstAreInDetail) {
  story_.duration = 2'048'000;
  for (Micros at = 0; at < story_.duration; at += 100) add("imu", at, at + 10, 0.01F);
  story_.responses = {{{500'500, 10.0}, {1'500'500, 80.0}}};
  const Detail detail = choose_detail(story_, 20'000);
  EXPECT_TRUE(detail.has(0));
  EXPECT_TRUE(detail.has(1'500'000));
  EXPECT_TRUE(detail.has(1'421'000)) << "since the begin of the source run before";
  EXPECT_FALSE(detail.has(1'000'000));
  EXPECT_TRUE(choose_detail(story_, 1'000'000).whole());
}

std::vector<std::pair<why::PartKind, std::size_t>> columns_of(const std::vector<Stretch>& bar) {
  std::vector<std::pair<why::PartKind, std::size_t>> columns;
  for (const Stretch& stretch : bar) columns.emplace_back(stretch.part.kind, stretch.columns);
  return columns;
}

TEST(Late, ABarHasWhatIsLongestInEachColumn) {
  using why::PartKind;
  why::Response response{.begin = at(Nanos{0}), .end = at(milliseconds{10})};
  const auto add = [&](PartKind kind, Nanos length) {
    const TimePoint begin = response.parts.empty() ? response.begin : response.parts.back().end;
    response.parts.push_back({kind, begin, begin + length, NodeId{0}});
  };
  add(PartKind::kWaitingForSample, milliseconds{4});
  add(PartKind::kKernel, microseconds{100});
  add(PartKind::kRunning, microseconds{3300});
  add(PartKind::kDevice, microseconds{2600});
  EXPECT_THAT(columns_of(bar_of(response, 10)),
              ElementsAre(std::pair(PartKind::kWaitingForSample, 4), std::pair(PartKind::kRunning, 3),
                          std::pair(PartKind::kDevice, 3)))
      << "the kernel's is longest in none";
  EXPECT_THAT(columns_of(bar_of(response, 100)),
              ElementsAre(std::pair(PartKind::kWaitingForSample, 40), std::pair(PartKind::kKernel, 1),
                          std::pair(PartKind::kRunning, 33), std::pair(PartKind::kDevice, 26)));
}

TEST(GraphPicture, SubchainsHaveRowsOfTheirOwn) {
  const graph::App app = robot();
  const std::vector<Cell> cells = lay_out(app.graph);
  const auto cell = [&](const char* name) { return cells[app.graph.find_node(name)->index()]; };
  EXPECT_EQ(cell("scan").column, 0U);
  EXPECT_EQ(cell("LP").column, 2U);
  EXPECT_EQ(cell("base").column, 3U);
  EXPECT_EQ(cell("scan").row, cell("LM").row);
  EXPECT_EQ(cell("scan").row, cell("LP").row);
  std::set<std::pair<std::size_t, std::size_t>> taken;
  for (const Cell& one : cells) EXPECT_TRUE(taken.emplace(one.column, one.row).second);
  EXPECT_NE(cell("GL").row, cell("LM").row) << "not in the subchain's box";
  const std::string svg =
      graph_picture(app.graph, std::vector<std::string>(cells.size(), "a < b"), std::vector<std::string>(cells.size()));
  EXPECT_THAT(svg, HasSubstr("a &lt; b"));
}

constexpr const char* kEvil = "</script><script>alert(1)</script><!-- & \"quotes\" 'too' \x1b[2J \xff";

class PageTest : public testing::Test {
 protected:
  // 20 s of the robot's local loop, the first two of them warm-up.
  Story story(const graph::App& app, Nanos length = seconds{20}) {
    const std::string path = folder_.file("record");
    {
      const auto writer = make(path, app);
      std::uint64_t number = 1;
      for (Nanos t = seconds{100}; t < seconds{100} + length; t += milliseconds{40}, number += 2) {
        for (const record::Run& run : runs(app, t, number)) writer->add(run);
        writer->add(record::Trigger{SubchainId{0}, number, at(t), at(t + microseconds{30})});
      }
      writer->add(record::SlotUse{0, SubchainId{0}, at(seconds{101}), at(seconds{101}), at(seconds{102})});
      writer->add(record::Steal{1, SubchainId{0}, SubchainId{1}, at(seconds{101}), at(seconds{102})});
      writer->add(record::Overrun{SubchainId{0}, 3, at(seconds{103}), milliseconds{9}});
      writer->add(record::CostChange{at(seconds{104}), *app.graph.find_node("GL"), 1, 0, ms(5), ms(8), 60});
      writer->add(record::Notice{at(seconds{105}), "watchdog", kEvil});
      EXPECT_TRUE(writer->close(at(seconds{100} + length), header().host).ok());
    }
    auto told = tell(open(path));
    EXPECT_TRUE(told.ok()) << (told ? "" : told.error().message());
    return std::move(*told);
  }

  Folder folder_;
  graph::App app_ = robot();
};

TEST_F(PageTest, TellsWhatARecordHas) {
  const Story told = story(app_);
  EXPECT_EQ(told.duration, 20'000'000);
  EXPECT_EQ(told.measured_from, 2'000'000);
  ASSERT_EQ(told.lanes.size(), 3U);
  EXPECT_EQ(told.lanes[2].name, "imu");
  EXPECT_FALSE(told.lanes[2].scheduled);
  EXPECT_EQ(told.runs.size(), 500U * 7U);
  EXPECT_EQ(told.runs.front().end, 1'000);
  EXPECT_EQ(told.triggers[0].size(), 500U);
  EXPECT_EQ(told.triggers[0][1].sent, 40'030);
  EXPECT_EQ(told.triggers[0][1].late, 30);
  EXPECT_EQ(told.cores, 2U) << "by its slots and steals";
  ASSERT_EQ(told.events.size(), 3U);
  EXPECT_EQ(told.events[0].kind, EventKind::kOverrun);
  EXPECT_EQ(told.events[1].text, "GL (match) costs 8 ms, before 5 ms");
  EXPECT_EQ(told.events[2].at, 5'000'000);
  ASSERT_EQ(told.responses.size(), 2U);
  EXPECT_EQ(told.responses[0].size(), 999U) << "two runs of each node every 40 ms; the first has no run before it";
  EXPECT_NEAR(told.responses[0][1].response_ms, 24.0, 1e-9);
}

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t found = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++found;
  return found;
}

TEST_F(PageTest, TextOfARecordStaysText) {
  const Story told = story(app_);
  const std::string html = to_html({kEvil, told});
  EXPECT_EQ(count(html, "</script"), 2U) << "of the data and of the script";
  EXPECT_EQ(count(html, "<script"), 2U);
  EXPECT_THAT(html, HasSubstr("&lt;script&gt;alert(1)"));
  EXPECT_THAT(html, HasSubstr("\\u003cscript>alert(1)"));
  EXPECT_THAT(html, Not(HasSubstr("\x1b")));
  EXPECT_THAT(html, Not(HasSubstr("http:"))) << "nothing is fetched";
  EXPECT_THAT(html, Not(HasSubstr("https:")));
  const std::size_t begin = html.find('[', html.find("id=\"catan-data\""));
  const auto data = nlohmann::json::parse(html.substr(begin, html.find("</script", begin) - begin));
  EXPECT_THAT(data[0]["events"][2]["text"].get<std::string>(), HasSubstr("watchdog: </script><script>alert(1)"));
}

TEST_F(PageTest, HasEveryPart) {
  const Story told = story(app_);
  const std::string html = to_html({"run", told});
  for (const char* part : {"<svg class=\"graph\"", "id=\"cores\"", "data-kind=\"cores\"", "data-kind=\"response\"",
                           "data-kind=\"compute\"", "Chains: predicted beside measured", "GL (match) costs 8 ms",
                           "prefers-color-scheme", "@media print", "A &quot;fast&quot; one", ", complete"}) {
    EXPECT_THAT(html, HasSubstr(part));
  }
  EXPECT_THAT(html, Not(HasSubstr("In full detail"))) << "nothing is left out";
}

TEST_F(PageTest, ShowsWhatTheLongestResponsesConsistOf) {
  const Story told = story(app_);
  const why::Analysis& late = *told.figures.chains[0].late;
  ASSERT_EQ(late.worst.size(), kWorstShown);
  const std::string html = to_html({"run", told});
  const std::size_t begin = html.find("<div class=\"late\">");
  ASSERT_NE(begin, std::string::npos);
  const std::string of_chain = html.substr(begin, html.find("<p class=\"legend\">", begin) - begin);
  EXPECT_THAT(of_chain, HasSubstr("0 of 899 late: over 60 ms, the bound.</p>"));
  EXPECT_EQ(count(of_chain, "<summary>"), kWorstShown) << "can be reached with the keyboard";
  EXPECT_EQ(count(of_chain, "role=\"img\" aria-label="), kWorstShown);
  EXPECT_THAT(of_chain, HasSubstr("class=\"part running\""));
  EXPECT_THAT(of_chain, HasSubstr("width:100.00%"));
}

TEST_F(PageTest, NoPageIsLargerThanItMayBe) {
  Story told = story(app_, seconds{2});
  told.duration = 3'600'000'000;
  told.runs.clear();
  const auto scan = static_cast<std::uint32_t>(app_.graph.find_node("scan")->index());
  for (Micros at = 0; at < told.duration; at += 24'000) {
    told.runs.push_back({scan, 0, told.runs.size() + 1, at, at + 7'000, 5.5F, 0.0F});
  }
  for (const std::size_t max : {1'500'000U, 800'000U}) {
    const std::string html = to_html({"hour", told}, max);
    EXPECT_LE(html.size(), max);
    EXPECT_GE(html.size(), max / 4) << "what fits is there";
    EXPECT_THAT(html, HasSubstr("In full detail: "));
  }
}

TEST_F(PageTest, ComparesWhatBothHave) {
  const Story told = story(app_);
  const auto same = compare_html({"a.catan", told}, {"b.catan", told});
  ASSERT_TRUE(same.ok());
  EXPECT_THAT(*same, HasSubstr("data-other=\"0\""));
  EXPECT_THAT(*same, HasSubstr("a is a.catan, b is b.catan"));
  EXPECT_THAT(*same, HasSubstr(" (+0.0\u00a0%)"));
  EXPECT_THAT(*same, Not(HasSubstr("The apps differ")));
  EXPECT_EQ(count(*same, "data-kind=\"cores\""), 2U);

  graph::AppSpec spec;
  spec.name.value = "less";
  for (const char* name : {"scan", "LM"}) {
    spec.nodes.push_back({});
    spec.nodes.back().name.value = name;
  }
  spec.edges = {{names("scan LM"), {}}};
  spec.objective.resize(1);
  spec.objective[0].path = names("scan LM");
  spec.objective[0].weight.value = 1.0;
  const auto less = graph::build_app(spec);
  ASSERT_TRUE(less.ok());
  const auto differences = differences_of(app_, "a", *less, "b");
  ASSERT_TRUE(differences.ok());
  EXPECT_THAT(*differences, testing::Contains(HasSubstr("Only a has the nodes 'GL'")));
  EXPECT_THAT(*differences, testing::Contains(HasSubstr("Only b has the response times 'scan -> LM'")));

  spec.nodes[0].name.value = "x";
  spec.nodes[1].name.value = "y";
  spec.edges = {{names("x y"), {}}};
  spec.objective[0].path = names("x y");
  const auto foreign = graph::build_app(spec);
  ASSERT_TRUE(foreign.ok());
  const auto none = differences_of(app_, "a", *foreign, "b");
  ASSERT_FALSE(none.ok());
  EXPECT_EQ(none.error().kind(), ErrorKind::kCaller);
  EXPECT_THAT(none.error().message(), HasSubstr("no node in common"));
}

// So that tables of two runs are no wider than the page.
TEST_F(PageTest, FiguresOfTwoRunsAreInOneCell) {
  report::RunFigures run;
  run.chains.resize(1);
  run.chains[0].path = "scan -> LM";
  run.chains[0].response_ms = {.count = 2, .mean = 12.5, .p95 = 20.0, .p99 = 20.0, .max = 20.0};
  run.nodes.resize(1);
  run.nodes[0].name = "LM";
  run.nodes[0].period_ms = run.chains[0].response_ms;
  run.cores_used = 1.0;
  report::RunFigures other = run;
  other.chains[0].response_ms.mean = 10.0;
  other.chains[0].response_ms.max = 45.0;
  other.cores_used = 1.5;
  const std::vector<report::Table> tables = comparison_tables(run, "new", other, "old");
  ASSERT_EQ(tables.size(), 3U);
  using Row = std::vector<std::string>;
  EXPECT_EQ(tables[0].rows, std::vector<Row>({{"cores used", "1\u00a0/\u00a01.5 (+50.0\u00a0%)"}}));
  EXPECT_EQ(tables[1].header, Row({"chain", "in ms", "mean: a / b", "p95: a / b", "p99: a / b", "max: a / b"}));
  const std::string same = "20\u00a0/\u00a020 (+0.0\u00a0%)";
  EXPECT_EQ(tables[1].rows, std::vector<Row>({{"scan -> LM", "response time", "12.5\u00a0/\u00a010 (-20.0\u00a0%)",
                                               same, same, "20\u00a0/\u00a045 (+125\u00a0%)"}}));
  ASSERT_EQ(tables[2].rows.size(), 1U);
  EXPECT_EQ(tables[2].rows[0][0], "LM") << "also where its first figure is missing";
  EXPECT_EQ(tables[2].rows[0][1], "period");
  for (const report::Table& table : tables) EXPECT_THAT(table.caption, testing::EndsWith("a is new, b is old"));
}

TEST_F(PageTest, ARecordIsNotWrittenOver) {
  story(app_);
  const Status over = save("<html>", folder_.file("record"));
  ASSERT_FALSE(over.ok());
  EXPECT_EQ(over.error().kind(), ErrorKind::kCaller);
  EXPECT_TRUE(save("<html>", folder_.file("page")).ok());
  EXPECT_TRUE(save("<html2>", folder_.file("page")).ok()) << "another page is";
  const Status nowhere = save("<html>", folder_.file("no/page"));
  ASSERT_FALSE(nowhere.ok());
  EXPECT_EQ(nowhere.error().kind(), ErrorKind::kEnvironment);
}

}  // namespace
}  // namespace ctn::page
