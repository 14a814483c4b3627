// Late responses and their causes while an app runs.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <optional>
#include <utility>

#include <nlohmann/json.hpp>

#include "view/json.h"
#include "view/testing/live_view_fixture.h"

namespace ctn::view {
namespace {

using testing::ElementsAre;

// `fast` every 20 ms; the bound is 30 ms, where responses usually take 26.
class LateCausesTest : public LiveViewTest {
 protected:
  LateCausesTest() { bound(view); }

  void bound(LiveView& of) const {
    of.add(record::AppChange{at_ms(10), record::AppChange::What::kMax, 0, std::nullopt, 30.0});
  }
  void rounds(std::uint64_t from, std::uint64_t to) {
    for (std::uint64_t k = from; k <= to; ++k) fast(k, 20 * static_cast<int>(k));
  }
  // A run of steer that takes 10 ms more than it usually does.
  void long_run(std::uint64_t number) { fast(number, 20 * static_cast<int>(number), 16); }
};

TEST_F(LateCausesTest, EachLateResponseIsGivenOne) {
  rounds(1, 100);
  EXPECT_TRUE(picture(2010).chains[0].late_by.empty());
  long_run(101);
  rounds(102, 130);
  EXPECT_TRUE(picture(2610).chains[0].late_by.empty()) << "what took part in it may not have ended";
  rounds(131, 160);
  const Chain chain = picture(3210).chains[0];
  EXPECT_EQ(chain.over_bound, 1U);
  EXPECT_THAT(chain.late_by, ElementsAre(LateBy{"long-run", 1}));
  EXPECT_EQ(chain.late_by_in_all, chain.late_by);
  EXPECT_TRUE(picture(3210).chains[1].late_by.empty());
  const auto json = nlohmann::json::parse(to_json(picture(3210)));
  EXPECT_EQ(json["chains"][0]["late_by"], (nlohmann::json{{"long-run", 1}}));
  EXPECT_EQ(json["chains"][1]["late_by_in_all"], nlohmann::json::object());
}

TEST_F(LateCausesTest, TheLookForThemIsSeldom) {
  rounds(1, 100);
  long_run(101);
  rounds(102, 160);
  long_run(161);
  rounds(162, 390);
  EXPECT_EQ(picture(7810).chains[0].late_by_in_all[0].count, 1U) << "less than 5 s after the last";
  rounds(391, 420);
  EXPECT_THAT(picture(8410).chains[0].late_by_in_all, ElementsAre(LateBy{"long-run", 2}));
  rounds(421, 700);
  EXPECT_TRUE(picture(14'010).chains[0].late_by.empty()) << "of the last 10 s";
  EXPECT_THAT(picture(14'010).chains[0].late_by_in_all, ElementsAre(LateBy{"long-run", 2}));
}

TEST_F(LateCausesTest, OnceItHasEndedAllAreTold) {
  rounds(1, 100);
  long_run(101);
  view.ended();
  EXPECT_THAT(picture(2040).chains[0].late_by, ElementsAre(LateBy{"long-run", 1}));
}

TEST_F(LateCausesTest, AnotherViewOfTheSameRunGoesOnCounting) {
  rounds(1, 100);
  long_run(101);
  view.ended();
  LiveView first = std::move(view);
  view = LiveView(app, header_of_test());
  view.go_on_from(first.late_so_far());
  bound(view);
  rounds(1, 100);
  long_run(101);
  rounds(102, 150);
  long_run(151);
  view.ended();
  EXPECT_THAT(picture(3040).chains[0].late_by_in_all, ElementsAre(LateBy{"long-run", 2})) << "none of them twice";
}

TEST_F(LateCausesTest, WithoutABoundItIsWhatWasPromised) {
  view = LiveView(app, header_of_test());
  plan_comes(10, plan);
  const double promised = plan.chains[0].response.count();
  rounds(1, 100);
  const int longer = static_cast<int>(promised) - 20 + 1;
  fast(101, 2020, longer);
  view.ended();
  EXPECT_EQ(picture(3000).chains[0].over_promise, 1U);
  EXPECT_THAT(picture(3000).chains[0].late_by, ElementsAre(LateBy{"long-run", 1}));
}

TEST_F(LateCausesTest, WhatIsLostIsNotLookedAt) {
  rounds(1, 100);
  long_run(101);
  view.lost();
  rounds(200, 400);
  EXPECT_THAT(picture(8010).chains[0].late_by_in_all, ElementsAre(LateBy{"long-run", 1})) << "it was told by then";
}

}  // namespace
}  // namespace ctn::view
