// What catan top shows, at any size, without a terminal.
#include "top_screen.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "top_table.h"
#include "view/picture.h"

namespace ctn::tool {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

view::Picture picture_of(int chains, int subchains, int notices) {
  view::Picture picture;
  picture.app = "robot";
  picture.scheduler = "catan";
  picture.real_time = true;
  picture.cpus = {0, 1};
  picture.up_s = 75.0;
  picture.window_s = 10.0;
  picture.objective = 123.4;
  picture.plans_made = 7;
  picture.plan = view::PlanInForce{70.0, "measured", "auto", false, 120.0, 1.0, {}, {}};
  for (int number = 0; number < chains; ++number) {
    view::Chain chain;
    chain.nodes = {"scan", "node" + std::to_string(number), "motor"};
    chain.path = "scan -> node" + std::to_string(number) + " -> motor";
    chain.response_ms = {100, 20.5, 20.0, 31.25, 33.0, 35.0};
    chain.newest_ms = 21.0;
    chain.expected_ms = 20.0;
    chain.promised_ms = 40.0;
    chain.worst_ms.assign(60, 30.0);
    chain.worst_ms[59] = 35.0;
    chain.distribution = {10.0, 1.0, std::vector<std::uint64_t>(24, 4)};
    picture.chains.push_back(std::move(chain));
  }
  for (int number = 0; number < subchains; ++number) {
    view::Subchain subchain;
    subchain.name = "sub" + std::to_string(number);
    subchain.weight = number;
    subchain.cores = {0};
    subchain.sharing = view::Sharing::kPriorities;
    subchain.priority = number + 1;
    subchain.expected_period_ms = 10.0;
    subchain.period_ms = {100, 10.5 - number, 10.0, 12.0, 12.0, 13.0};
    subchain.used_ms = {100, 2.0, 2.0, 3.0, 3.0, 3.0};
    subchain.budget_ms = 4.0;
    subchain.late = number == 1 ? 5 : 0;
    subchain.silent_ms = 3.0;
    picture.subchains.push_back(std::move(subchain));
    view::Node node;
    node.name = "node" + std::to_string(number);
    node.subchain = static_cast<std::size_t>(number);
    node.cores = number == 2 ? 0.4 : 0.1;
    node.rate_hz = 95.0;
    picture.nodes.push_back(std::move(node));
  }
  for (int cpu = 0; cpu < 2; ++cpu) {
    view::Core core;
    core.cpu = cpu;
    core.core = cpu;
    core.sharing = view::Sharing::kPriorities;
    core.busy = 0.5;
    core.uses = {{"sub0", true, 0.5, {}}};
    picture.cores.push_back(std::move(core));
  }
  for (int number = 0; number < notices; ++number) {
    picture.events.push_back({1.0 * number, "plan", "number " + std::to_string(number)});
  }
  return picture;
}

std::vector<std::string> texts_of(const std::vector<ScreenLine>& lines) {
  std::vector<std::string> texts;
  for (const ScreenLine& line : lines) {
    std::string& text = texts.emplace_back();
    for (const Span& span : line) text += span.text;
  }
  return texts;
}

std::string screen_of(const view::Picture& picture, const ScreenState& state, ScreenSize size) {
  std::string whole;
  for (const std::string& text : texts_of(top_screen(picture, state, size))) whole += text + "\n";
  return whole;
}

std::size_t place_of(const std::string& what, const std::string& where) { return where.find(what); }

TEST(TopScreen, FitsAnySize) {
  for (const bool open : {false, true}) {
    for (const bool help : {false, true}) {
      for (const std::size_t columns : {1U, 7U, 20U, 80U, 120U, 200U}) {
        for (const std::size_t rows : {0U, 1U, 2U, 3U, 5U, 10U, 24U, 50U, 200U}) {
          for (const int many : {0, 1, 30}) {
            ScreenState state;
            state.open = open;
            state.help = help;
            state.selected = 29;
            const auto lines = top_screen(picture_of(many, many, many), state, {columns, rows});
            EXPECT_EQ(lines.size(), rows);
            for (const std::string& text : texts_of(lines)) EXPECT_LE(screen_width(text), columns) << text;
          }
        }
      }
    }
  }
}

TEST(TopScreen, ShowsTheMostImportantAt80By24) {
  const std::string screen = screen_of(picture_of(2, 3, 40), {}, {80, 24});
  for (const char* part : {"robot", "real-time levels", "CPUs 0-1", "up 1:15", "objective 123.4, planned 120.0",
                           "plan 5.0 s old (measured)", "scan>node1>motor", "31.2", "40.0", "sub2", "p3", "CPU 1",
                           "50 %", "number 39", "more: they do not fit", "q quit"}) {
    EXPECT_THAT(screen, HasSubstr(part));
  }
  EXPECT_THAT(screen, Not(HasSubstr("number 0\n")));
  EXPECT_LT(place_of("RESPONSE", screen), place_of("SUBCHAIN", screen));
  EXPECT_LT(place_of("SUBCHAIN", screen), place_of("CORE", screen));
  EXPECT_LT(place_of("number 39", screen), place_of("number 38", screen)) << "the newest first";
}

TEST(TopScreen, SaysHowMuchIsLeftOut) {
  const std::string screen = screen_of(picture_of(12, 9, 0), {}, {80, 24});
  EXPECT_THAT(screen, HasSubstr("scan>node0>motor"));
  EXPECT_THAT(screen, Not(HasSubstr("scan>node11>motor")));
  EXPECT_THAT(screen, HasSubstr("  … 3 more: they do not fit\nSUBCHAIN"));
  ScreenState state;
  state.selected = 11;
  EXPECT_THAT(screen_of(picture_of(12, 9, 0), state, {80, 24}), HasSubstr("scan>node11>motor"));
  EXPECT_THAT(screen_of(picture_of(12, 9, 0), {}, {200, 60}), Not(HasSubstr("do not fit")));
}

TEST(TopScreen, AWideOneHasMore) {
  const std::string wide = screen_of(picture_of(4, 8, 5), {}, {200, 50});
  const std::string narrow = screen_of(picture_of(4, 8, 5), {}, {80, 24});
  for (const char* part : {"p99", "trigger late", "NODE", "compute ms"}) {
    EXPECT_THAT(wide, HasSubstr(part));
    EXPECT_THAT(narrow, Not(HasSubstr(part)));
  }
}

TEST(TopScreen, SaysWhatMadeResponsesLate) {
  view::Picture picture = picture_of(2, 3, 3);
  EXPECT_THAT(screen_of(picture, {}, {80, 24}), Not(HasSubstr("WHY LATE")));
  picture.chains[1].late_by = {{"pre-empted", 12}, {"long-run", 3}};
  const std::string screen = screen_of(picture, {}, {80, 24});
  EXPECT_THAT(screen, HasSubstr("WHY LATE, by cause\nscan>node1>motor  pre-empted 12, long-run 3\n"));
  EXPECT_LT(place_of("RESPONSE", screen), place_of("WHY LATE", screen));
  EXPECT_LT(place_of("WHY LATE", screen), place_of("SUBCHAIN", screen));
  ScreenState state;
  state.open = true;
  EXPECT_THAT(screen_of(picture, state, {80, 24}), Not(HasSubstr("pre-empted")));
  state.selected = 1;
  EXPECT_THAT(screen_of(picture, state, {80, 24}), HasSubstr("why late: pre-empted 12, long-run 3\n"));
  EXPECT_THAT(top_text(picture), HasSubstr("scan>node1>motor  pre-empted 12, long-run 3\n"));
}

TEST(TopScreen, OpensAChain) {
  ScreenState state;
  EXPECT_TRUE(press(state, kKeyDown, 2));
  EXPECT_TRUE(press(state, kKeyEnter, 2));
  const std::string screen = screen_of(picture_of(2, 3, 3), state, {80, 24});
  for (const char* part : {"scan -> node1 -> motor", "expected 20.0, promised 40.0", "response time", "RESPONSE TIMES",
                           "node1", "Esc back"}) {
    EXPECT_THAT(screen, HasSubstr(part));
  }
  EXPECT_THAT(screen, Not(HasSubstr("SUBCHAIN")));
  state.causes = {"WHY LATE: 3 of 100", "     3  pre-empted"};
  EXPECT_THAT(screen_of(picture_of(2, 3, 3), state, {80, 24}), HasSubstr("3  pre-empted"));
  EXPECT_TRUE(press(state, kKeyEscape, 2));
  EXPECT_TRUE(state.causes.empty());
  EXPECT_THAT(screen_of(picture_of(2, 3, 3), state, {80, 24}), HasSubstr("SUBCHAIN"));
}

TEST(TopScreen, SortsSubchains) {
  const view::Picture picture = picture_of(1, 3, 0);
  const auto order = [&](const ScreenState& state) {
    const std::string screen = screen_of(picture, state, {80, 24});
    const std::string table = screen.substr(place_of("SUBCHAIN", screen), place_of("CORE ", screen));
    std::vector<std::pair<std::size_t, int>> places;
    for (int number = 0; number < 3; ++number)
      places.emplace_back(table.find("\nsub" + std::to_string(number)), number);
    std::sort(places.begin(), places.end());
    return std::vector<int>{places[0].second, places[1].second, places[2].second};
  };
  ScreenState state;
  EXPECT_THAT(order(state), ElementsAre(0, 1, 2));
  press(state, 's', 1);
  EXPECT_EQ(state.sort, SortBy::kWeight);
  EXPECT_THAT(order(state), ElementsAre(2, 1, 0));
  press(state, 'S', 1);
  EXPECT_THAT(order(state), ElementsAre(0, 1, 2));
  press(state, 'S', 1);
  press(state, 's', 1);
  EXPECT_THAT(order(state), ElementsAre(2, 0, 1)) << "by CPU";
  press(state, 's', 1);
  EXPECT_THAT(order(state), ElementsAre(1, 0, 2)) << "by late";
  press(state, 's', 1);
  EXPECT_THAT(order(state), ElementsAre(0, 1, 2)) << "by period";
  press(state, 's', 1);
  EXPECT_EQ(state.sort, SortBy::kApp);
}

TEST(TopScreen, Keys) {
  ScreenState state;
  press(state, kKeyUp, 2);
  EXPECT_EQ(state.selected, 0U);
  for (int times = 0; times < 5; ++times) press(state, kKeyDown, 2);
  EXPECT_EQ(state.selected, 1U);
  press(state, kKeyEnter, 0);
  EXPECT_FALSE(state.open) << "there is no chain";
  press(state, 'p', 2);
  EXPECT_TRUE(state.paused);
  EXPECT_THAT(screen_of(picture_of(1, 1, 0), state, {80, 24}), HasSubstr("PAUSED"));
  press(state, '?', 2);
  EXPECT_THAT(screen_of(picture_of(1, 1, 0), state, {80, 24}), HasSubstr("sort subchains; reverse"));
  press(state, kKeyEscape, 2);
  EXPECT_FALSE(state.help);
  EXPECT_FALSE(press(state, 'x', 2));
}

TEST(TopScreen, SaysWhenTheAppNoLongerRuns) {
  view::Picture picture = picture_of(1, 1, 0);
  picture.silent_ms = 3000.0;
  const auto second_line = [&](view::State state) {
    picture.state = state;
    return texts_of(top_screen(picture, {}, {80, 24}))[1];
  };
  EXPECT_THAT(second_line(view::State::kStalled), HasSubstr("no sign of life for 3.0 s"));
  EXPECT_THAT(second_line(view::State::kKilled), HasSubstr("killed"));
  EXPECT_THAT(second_line(view::State::kEnded), HasSubstr("has ended"));
}

TEST(TopScreen, SaysWhatThePlanGaveUpAndWhoIsSilent) {
  view::Picture picture = picture_of(1, 2, 0);
  picture.plan->relax_factor = 1.5;
  picture.plan->relaxed = {{"objective[0].max", 20.0, 30.0}, {"nodes.GM.min_rate", 100.0, 200.0}};
  picture.plan->assumed = {{"map", 5.0}};
  picture.subchains[0].silent_ms = 4000.0;
  picture.subchains[0].absent = picture.subchains[1].absent = true;
  picture.subchains[1].silent_ms.reset();
  const std::string screen = screen_of(picture, {}, {120, 24});
  EXPECT_THAT(screen, HasSubstr("bounds relaxed by 1.5: objective[0].max 30.0 ms, not 20.0 ms, nodes.GM.min_rate 5.00 "
                                "Hz, not 10.0 Hz"));
  EXPECT_THAT(screen, HasSubstr("assumed: map"));
  EXPECT_THAT(screen, HasSubstr("silent 4.0 s"));
  EXPECT_THAT(screen, HasSubstr("no run"));
}

TEST(TopScreen, WhatIsLateIsMarked) {
  view::Picture picture = picture_of(1, 1, 0);
  const auto style_of_newest = [&] {
    ScreenState state;
    state.selected = 9;
    for (const ScreenLine& line : top_screen(picture, state, {80, 24})) {
      for (const Span& span : line) {
        if (span.text == "21.0") return span.style;
      }
    }
    return Style::kDim;
  };
  EXPECT_EQ(style_of_newest(), Style::kPlain);
  picture.chains[0].promised_ms = 20.5;
  EXPECT_EQ(style_of_newest(), Style::kWarning);
  picture.chains[0].bound_ms = 20.9;
  EXPECT_EQ(style_of_newest(), Style::kBad);
}

TEST(TopScreen, DrawsWithoutUnicodeToo) {
  ScreenState state;
  state.unicode = false;
  for (const ScreenLine& line : top_screen(picture_of(3, 3, 30), state, {80, 24})) {
    for (const Span& span : line) {
      for (const char c : span.text) EXPECT_GE(c, ' ') << span.text;
    }
  }
}

TEST(TopScreen, NamesCannotUpsetTheTerminal) {
  view::Picture picture = picture_of(1, 1, 0);
  picture.app = "a\x1b[2Jb";
  picture.events = {{1.0, "k\n", "\x07"}};
  EXPECT_THAT(screen_of(picture, {}, {80, 24}), Not(HasSubstr("\x1b")));
  EXPECT_THAT(screen_of(picture, {}, {80, 24}), Not(HasSubstr("\x07")));
}

TEST(TopTable, ShortensNamesInTheirMiddle) {
  EXPECT_EQ(shortened("scan -> LM", 10, true), "scan -> LM");
  EXPECT_EQ(shortened("scan -> LM -> LP", 9, true), "scan…> LP");
  EXPECT_EQ(shortened("scan -> LM -> LP", 9, false), "scan~> LP");
  EXPECT_EQ(shortened("ääääääää", 5, true), "ää…ää");
}

TEST(TopTable, LeavesOutColumnsByTheirRank) {
  ScreenTable table({{"NAME", 0}, {"a", 0}, {"b", 2}, {"c", 1}});
  table.add({{"name"}, {"1"}, {"2"}, {"3"}});
  const auto lines = [&](std::size_t width) { return texts_of(table.lines(width, true)); };
  EXPECT_THAT(lines(13), ElementsAre("NAME  a  b  c", "name  1  2  3"));
  EXPECT_THAT(lines(10), ElementsAre("NAME a b c", "name 1 2 3"));
  EXPECT_THAT(lines(9), ElementsAre("NAME a c", "name 1 3"));
  EXPECT_THAT(lines(6), ElementsAre("NAME a", "name 1"));
}

TEST(TopText, HasAll) {
  const std::string text = top_text(picture_of(12, 9, 40));
  EXPECT_THAT(text, HasSubstr("scan -> node11 -> motor"));
  EXPECT_THAT(text, HasSubstr("number 0\n"));
  EXPECT_THAT(text, HasSubstr("NODE"));
  EXPECT_THAT(text, Not(HasSubstr(" \n")));
}

}  // namespace
}  // namespace ctn::tool
