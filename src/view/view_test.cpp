// Feeds the events of a made-up run, and expects exact figures. The app and its plan: plan/testing/sample_plan.h.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "base/testing/times.h"
#include "os/cpu_set.h"
#include "plan/json.h"
#include "plan/testing/sample_plan.h"
#include "view/json.h"
#include "view/live_view.h"
#include "view/testing/live_view_fixture.h"

namespace ctn::view {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using testing::Each;
using testing::ElementsAre;

TEST_F(LiveViewTest, BeforeAnythingHasRun) {
  const Picture picture = LiveView(app, header_of_test()).picture(at_ms(5), {.seen_alive = at_ms(5)});
  EXPECT_EQ(picture.state, State::kRunning);
  EXPECT_EQ(picture.window_s, 0.0);
  EXPECT_FALSE(picture.plan);
  EXPECT_FALSE(picture.objective);
  ASSERT_EQ(picture.chains.size(), 3U);
  EXPECT_EQ(picture.chains[1].path, "grab -> detect -> base");
  EXPECT_EQ(picture.chains[1].bound_ms, 25.0);
  EXPECT_FALSE(picture.chains[1].promised_ms);
  EXPECT_FALSE(picture.chains[1].newest_ms);
  ASSERT_EQ(picture.cores.size(), 3U);
  EXPECT_EQ(picture.cores[2].cpu, 5);
  EXPECT_FALSE(picture.cores[2].core);
  EXPECT_EQ(picture.nodes.size(), 6U) << "an external node is none that runs";
  EXPECT_FALSE(picture.nodes[0].silent_ms);
}

TEST_F(LiveViewTest, WhatHasRunBesideWhatWasPlanned) {
  plan_comes(10, plan);
  for (int k = 1; k <= 100; ++k) fast(static_cast<std::uint64_t>(k), 20 * k);
  const Picture picture = this->picture(2010);
  EXPECT_EQ(picture.window_s, 2.0);

  const Chain& chain = picture.chains[0];
  EXPECT_EQ(chain.latency_ms.count, 100U);
  EXPECT_EQ(chain.latency_ms.max, 6.0);
  EXPECT_EQ(chain.response_ms.count, 99U);
  EXPECT_EQ(chain.response_ms.p95, 26.0);
  EXPECT_EQ(chain.newest_ms, 26.0);
  EXPECT_EQ(chain.promised_ms, plan.chains[0].response.count());
  EXPECT_EQ(chain.expected_ms, chain.promised_ms) << "the plan expects nothing else";
  EXPECT_EQ(chain.over_promise, 0U);
  EXPECT_EQ(chain.distribution.counts[0], 99U) << "all are alike";

  const Subchain& subchain = picture.subchains[plan::kFast.index()];
  EXPECT_EQ(subchain.name, "fast");
  EXPECT_THAT(subchain.cores, ElementsAre(0));
  EXPECT_EQ(subchain.sharing, Sharing::kFrames);
  EXPECT_EQ(subchain.share, 1.0);
  EXPECT_FALSE(subchain.priority);
  EXPECT_EQ(subchain.expected_period_ms, plan.subchains[0].period.count());
  EXPECT_EQ(subchain.budget_ms, 6.0);
  EXPECT_EQ(picture.subchains[plan::kSlow.index()].budget_ms, 20.0) << "a quarter of it in each slot";
  EXPECT_EQ(subchain.runs, 100U);
  EXPECT_EQ(subchain.used_ms.max, 6.0);
  EXPECT_EQ(subchain.execution_ms.mean, 6.0);
  EXPECT_EQ(subchain.period_ms.count, 99U);
  EXPECT_EQ(subchain.period_ms.mean, 20.0);
  EXPECT_EQ(subchain.trigger_late_ms.count, 0U) << "that of the first event, from which the window is";
  EXPECT_EQ(subchain.silent_ms, 4.0);
  EXPECT_FALSE(picture.subchains[plan::kSlow.index()].silent_ms);

  ASSERT_EQ(picture.cores.size(), 3U);
  const Core& core = picture.cores[0];
  EXPECT_EQ(core.cpu, 2);
  EXPECT_EQ(core.core, 0);
  EXPECT_EQ(core.sharing, Sharing::kFrames);
  EXPECT_EQ(core.frame_ms, plan.cores[0].frame.count());
  ASSERT_EQ(core.uses.size(), 3U);
  EXPECT_EQ(core.uses[0].name, "fast");
  EXPECT_TRUE(core.uses[0].planned);
  EXPECT_NEAR(core.uses[0].cores, 0.3, 1e-9);
  EXPECT_NEAR(core.busy, 0.3, 1e-9);
  EXPECT_EQ(picture.cores[2].sharing, Sharing::kOwned);
  EXPECT_EQ(picture.cores[2].uses[0].name, "see");

  const Node& steer = picture.nodes[1];
  EXPECT_EQ(steer.name, "steer");
  EXPECT_EQ(steer.runs, 100U);
  EXPECT_EQ(steer.rate_hz, 50.0);
  EXPECT_EQ(steer.compute_ms.p50, 4.0);
  EXPECT_NEAR(steer.cores, 0.2, 1e-9);
  EXPECT_EQ(steer.wait_ms.count, 0U);
  EXPECT_FALSE(picture.objective) << "other terms have no sample";
}

TEST_F(LiveViewTest, ThoseThatOwnCoresUseAllOfThem) {
  plan_comes(10, plan);
  view.add(record::Run{id("grab"), 1, at_ms(20), at_ms(60), ms(80), 0, true, {}, 5});
  const Picture picture = this->picture(110);
  EXPECT_NEAR(picture.cores[1].busy, 0.4, 1e-9);
  EXPECT_NEAR(picture.cores[2].busy, 0.4, 1e-9);
}

TEST_F(LiveViewTest, WithoutAPlanCoresShowWhoseRunsEndedThere) {
  view.add(record::Run{id("map"), 1, at_ms(20), at_ms(50), ms(25), 0, true, {}, 3});
  view.add(record::Run{id("log"), 1, at_ms(20), at_ms(50), ms(10), 0, true, {}, 7});
  const Picture picture = this->picture(110);
  ASSERT_EQ(picture.cores.size(), 4U);
  EXPECT_EQ(picture.cores[1].uses[0].name, "slow");
  EXPECT_FALSE(picture.cores[1].uses[0].planned);
  EXPECT_NEAR(picture.cores[1].busy, 0.25, 1e-9);
  EXPECT_EQ(picture.cores[3].cpu, 7) << "one that it was not started with";
  EXPECT_EQ(picture.cores[1].sharing, Sharing::kNone);
}

// Of three CPUs, one was taken away: core 0 of the plan is where its subchains run.
TEST_F(LiveViewTest, RunsTellWhereCoresAreOnceCpusWereTakenAway) {
  plan.cores.pop_back();
  plan.subchains[plan::kSee.index()].cores = {1};
  plan_comes(10, plan, "cpus");
  view.add(record::Run{id("map"), 1, at_ms(20), at_ms(50), ms(25), 0, true, {}, 3});
  const Picture picture = this->picture(110);
  EXPECT_EQ(picture.cores[0].cpu, 2);
  EXPECT_FALSE(picture.cores[0].core);
  EXPECT_EQ(picture.cores[1].cpu, 3);
  EXPECT_EQ(picture.cores[1].core, 0);
  ASSERT_EQ(picture.cores.size(), 4U);
  EXPECT_EQ(picture.cores[3].core, 1);
  EXPECT_FALSE(picture.cores[3].cpu) << "nothing has run there";
}

TEST_F(LiveViewTest, SlotsAndSteals) {
  plan_comes(10, plan);
  view.add(record::SlotUse{0, plan::kFast, at_ms(10), at_ms(10), at_ms(20)});
  view.add(record::SlotUse{0, plan::kSlow, at_ms(20), at_ms(25), at_ms(30)});
  view.add(record::SlotUse{9, plan::kSlow, at_ms(20), at_ms(25), at_ms(30)});
  view.add(record::Steal{0, plan::kFast, plan::kSlow, at_ms(20), at_ms(25)});
  view.add(record::Overrun{plan::kSlow, 1, at_ms(30), ms(21)});
  view.add(record::Trigger{plan::kSlow, 1, at_ms(20), at_ms(23)});
  const Picture picture = this->picture(110);
  EXPECT_NEAR(picture.cores[0].uses[0].slots.value(), 0.1, 1e-9);
  EXPECT_NEAR(picture.cores[0].uses[1].slots.value(), 0.05, 1e-9);
  EXPECT_FALSE(picture.cores[0].uses[2].slots);
  const Subchain& fast = picture.subchains[plan::kFast.index()];
  const Subchain& slow = picture.subchains[plan::kSlow.index()];
  EXPECT_EQ(std::pair(fast.stole, fast.stole_ms), std::pair(std::uint64_t{1}, 5.0));
  EXPECT_EQ(std::pair(slow.stolen, slow.stolen_ms), std::pair(std::uint64_t{1}, 5.0));
  EXPECT_EQ(fast.stolen + slow.stole, 0U);
  EXPECT_EQ(slow.overruns, 1U);
  EXPECT_EQ(slow.trigger_late_ms.max, 3.0);
}

TEST_F(LiveViewTest, FixedPrioritiesAndTheirBudgets) {
  plan_comes(10, plan::sample_priorities(app, plan::sample_costs(app)));
  const Picture picture = this->picture(110);
  const Subchain& slow = picture.subchains[plan::kSlow.index()];
  EXPECT_EQ(slow.sharing, Sharing::kPriorities);
  EXPECT_EQ(slow.priority, 2);
  EXPECT_FALSE(slow.share);
  EXPECT_EQ(slow.budget_ms, 25.0);
  EXPECT_EQ(picture.cores[0].sharing, Sharing::kPriorities);
  EXPECT_EQ(picture.cores[0].uses[2].name, "log");
}

// Promised are 20 ms for a run of `fast`, until the plan of 1 s promises 5.
TEST_F(LiveViewTest, LateIsWhatTookLongerThanWasPromisedWhenItBegan) {
  fast(1, 20, 30);  // before there is a plan
  plan_comes(60, plan);
  fast(2, 100, 20);
  fast(3, 140, 21);
  plan.subchains[plan::kFast.index()].execution = Millis{5};
  plan.chains[0].response = Millis{30};
  plan_comes(1000, plan);
  fast(4, 1100, 20);
  fast(5, 1120, 4);
  fast(6, 1140, 5);
  const Picture picture = this->picture(1200);
  EXPECT_EQ(picture.subchains[plan::kFast.index()].late, 2U) << "the third and the fourth";
  // Responses: 100, 61, 980, 24 and 25 ms; the plan of 60 ms promises 2 x 20 ms.
  EXPECT_EQ(picture.chains[0].response_ms.count, 5U);
  EXPECT_EQ(picture.chains[0].over_promise, 2U) << "the first began without a plan, the last two are shorter than 30";
}

TEST_F(LiveViewTest, BoundsAndWeightsAreThoseThatHold) {
  fast(1, 20);
  fast(2, 40);
  fast(3, 90);
  EXPECT_EQ(picture(100).chains[0].over_bound, 0U);
  view.add(record::AppChange{at_ms(95), record::AppChange::What::kMax, 0, std::nullopt, 50.0});
  view.add(record::AppChange{at_ms(95), record::AppChange::What::kWeight, 0, 1.0, 3.0});
  view.add(record::AppChange{at_ms(95), record::AppChange::What::kWeight, 99, 1.0, 3.0});
  const Chain chain = picture(100).chains[0];
  EXPECT_EQ(chain.bound_ms, 50.0);
  EXPECT_EQ(chain.weight, 3.0);
  EXPECT_EQ(chain.over_bound, 1U);
}

TEST_F(LiveViewTest, PlansAndNoticesAreTold) {
  plan.relax_factor = 1.5;
  plan.relaxed = {{"objective[1].max", Millis{25}, Millis{37.5}}};
  plan.assumed = {{id("map"), Millis{5}}};
  plan_comes(10, plan, "bootstrap");
  plan_comes(10, plan, "bootstrap");
  view.add(record::Notice{at_ms(500), "starved", "CPU 2"});
  view.add(record::CostChange{at_ms(600), id("map"), 0, 0, ms(20), ms(30), 12});
  view.set_totals({.plans_made = 7, .planning_cpu = ms(3), .starved = 1, .starved_for = ms(50)});
  view.add(record::PlanChange{at_ms(700), "change", "{}"});
  const Picture picture = this->picture(1000);
  ASSERT_TRUE(picture.plan);
  EXPECT_EQ(picture.plan->reason, "bootstrap");
  EXPECT_EQ(picture.plan->at_s, 0.01);
  EXPECT_EQ(picture.plan->relaxed[0].planned_ms, 37.5);
  EXPECT_EQ(picture.plan->assumed[0].node, "map");
  ASSERT_EQ(picture.events.size(), 4U) << "a plan that was told twice is one";
  EXPECT_EQ(picture.events[0].kind, "plan");
  EXPECT_THAT(picture.events[0].detail, testing::HasSubstr("bounds relaxed by 1.5"));
  EXPECT_EQ(picture.events[1], (Event{0.5, "starved", "CPU 2"}));
  EXPECT_EQ(picture.events[2], (Event{0.6, "cost-change", "map: 20 ms -> 30 ms"}));
  EXPECT_EQ(picture.events[3].detail, "change: this version of catan cannot read it");
  EXPECT_EQ(picture.plans_made, 7U);
  EXPECT_EQ(picture.starved_ms, 50.0);
}

TEST_F(LiveViewTest, ThePastIsForgotten) {
  fast(1, 20);
  fast(2, 1040);                                                                      // response: 1026 ms
  for (int k = 3; k <= 5; ++k) fast(static_cast<std::uint64_t>(k), 20'000 + 20 * k);  // 19020 + 6, 26, 26 ms
  const Picture picture = this->picture(20'500);
  EXPECT_EQ(picture.window_s, 10.0);
  EXPECT_EQ(picture.subchains[0].runs, 3U);
  EXPECT_EQ(picture.nodes[0].runs, 3U);
  const Chain& chain = picture.chains[0];
  EXPECT_EQ(chain.response_ms.count, 3U);
  EXPECT_EQ(chain.response_ms.max, 19'026.0);
  EXPECT_EQ(chain.distribution.counts.front(), 2U);
  EXPECT_EQ(chain.distribution.counts.back(), 1U);
  ASSERT_EQ(chain.worst_ms.size(), 60U);
  EXPECT_EQ(chain.worst_ms[59], 19'026.0);
  EXPECT_FALSE(chain.worst_ms[58]);
  EXPECT_EQ(chain.worst_ms[40], 1026.0) << "19 seconds before";
  EXPECT_FALSE(this->picture(80'500).chains[0].worst_ms[0]);
  EXPECT_EQ(this->picture(80'500).chains[0].newest_ms, 26.0) << "however old";
}

TEST_F(LiveViewTest, NeverKeepsMoreThanItMay) {
  for (std::uint64_t k = 1; k <= 40'000; ++k) {
    const TimePoint begin = at(milliseconds{20} + std::chrono::microseconds{10} * k);
    view.add(record::Run{
        id("scan"), k, begin, begin + std::chrono::microseconds{5}, std::chrono::microseconds{5}, 0, true, {}, 2});
  }
  EXPECT_EQ(picture(500).nodes[0].runs, kMaxSamples);
  for (int k = 0; k < 1000; ++k) view.add(record::Notice{at_ms(k), "n", std::to_string(k)});
  EXPECT_EQ(picture(1000).events.size(), kMaxEvents);
  EXPECT_EQ(picture(1000).events.back().detail, "999");
}

TEST_F(LiveViewTest, AbsentAreThoseWithoutARunForTenPeriodsAndASecond) {
  plan_comes(10, plan);
  const auto absent = [&](int now, const Life& life) {
    const Picture shown = view.picture(at_ms(now), life);
    return std::vector{shown.subchains[plan::kFast.index()].absent, shown.nodes[1].absent};
  };
  const auto absent_at = [&](int now) { return absent(now, {.seen_alive = at_ms(now)}); };
  EXPECT_THAT(absent_at(1000), Each(false)) << "it may yet come";
  EXPECT_THAT(absent_at(1001), Each(true)) << "ten periods are shorter than a second";
  fast(1, 1000);
  EXPECT_THAT(absent_at(2006), Each(false));
  EXPECT_THAT(absent_at(2007), Each(true)) << "a second after the end of its run, at 1006 ms";
  EXPECT_THAT(absent(2007, {.seen_alive = at_ms(2007), .over = true}), Each(false)) << "the app has ended";
  for (std::uint64_t k = 2; k < 5; ++k) fast(k, 1000 + 400 * static_cast<int>(k - 1));
  EXPECT_THAT(absent_at(6206), Each(false)) << "it was slower than planned, and ten of these periods are 4 s";
  EXPECT_THAT(absent_at(6207), Each(true));
}

TEST_F(LiveViewTest, FiguresStandStillOnceTheSessionDoes) {
  fast(1, 20);
  fast(2, 40);
  const auto at_time = [&](int now, const Life& life) { return view.picture(at_ms(now), life); };
  const TimePoint alive = at_ms(110);
  EXPECT_EQ(at_time(1110, {.seen_alive = alive}).state, State::kRunning) << "a busy machine delays it, too";
  const Picture stalled = at_time(20'000, {.seen_alive = alive});
  EXPECT_EQ(stalled.state, State::kStalled);
  EXPECT_EQ(stalled.silent_ms, 19'890.0);
  EXPECT_EQ(stalled.window_s, 0.1);
  EXPECT_EQ(stalled.up_s, 0.11);
  EXPECT_EQ(stalled.subchains[0].runs, 2U);
  EXPECT_EQ(at_time(20'000, {.seen_alive = alive, .gone = true}).state, State::kKilled);
  EXPECT_EQ(at_time(1000, {.seen_alive = alive, .gone = true}).state, State::kRunning) << "it may yet tell its end";
  EXPECT_EQ(at_time(120, {.seen_alive = alive, .over = true, .gone = true}).state, State::kEnded);
}

TEST_F(LiveViewTest, FiguresBeginAnewWhereEventsWereLost) {
  plan_comes(10, plan);
  fast(1, 20);
  fast(2, 40);
  view.lost();
  EXPECT_EQ(picture(1000).lost, 1U);
  EXPECT_EQ(picture(1000).window_s, 0.0);
  EXPECT_EQ(picture(1000).subchains[0].runs, 0U);
  fast(9, 2000);
  fast(10, 2020);
  const Picture picture = this->picture(2102);
  EXPECT_EQ(picture.window_s, 0.1) << "from the first event on";
  EXPECT_EQ(picture.subchains[0].runs, 2U);
  EXPECT_EQ(picture.chains[0].response_ms.max, 26.0) << "no response goes back to before";
  EXPECT_TRUE(picture.plan);
}

// A run that emits nothing ends its subchain's run. Where the run before was not seen, no run of the subchain counts.
TEST_F(LiveViewTest, RunsOfSubchainsThatDoNotReachTheirTail) {
  view.add(record::Run{id("scan"), 1, at_ms(20), at_ms(22), ms(2), 0, false, {}, 2});
  view.add(record::Run{id("steer"), 7, at_ms(42), at_ms(46), ms(4), 0, true, {{id("scan"), 6, 6}}, 2});
  const Picture picture = this->picture(110);
  EXPECT_EQ(picture.subchains[0].runs, 1U);
  EXPECT_EQ(picture.subchains[0].used_ms.max, 2.0);
}

TEST_F(LiveViewTest, TheObjectiveIsOfMeans) {
  for (int k = 1; k <= 10; ++k) {
    const auto number = static_cast<std::uint64_t>(k);
    const int begin = 40 * k;
    fast(number, begin);  // 46 ms
    view.add(record::Run{id("grab"), number, at_ms(begin), at_ms(begin + 10), ms(10), 0, true, {}, 3});
    view.add(record::Run{id("detect"),
                         number,
                         at_ms(begin + 10),
                         at_ms(begin + 20),
                         ms(10),
                         0,
                         true,
                         {{id("grab"), number, number}},
                         3});  // 60 ms
    view.add(record::Run{id("map"), number, at_ms(begin), at_ms(begin + 1), ms(1), 0, true, {}, 2});
    view.add(record::Run{id("log"),
                         number,
                         at_ms(begin + 6),
                         at_ms(begin + 7),
                         ms(1),
                         0,
                         true,
                         {{id("map"), number, number}},
                         2});  // 40 ms
    if (k < 10) continue;
    EXPECT_FALSE(picture(500).objective) << "map has not come to steer";
    view.add(record::Run{id("steer"),
                         number + 1,
                         at_ms(begin + 10),
                         at_ms(begin + 12),
                         ms(1),
                         0,
                         true,
                         {{id("map"), number - 1, number - 1}},
                         2});
    view.add(record::Run{id("steer"),
                         number + 2,
                         at_ms(begin + 12),
                         at_ms(begin + 14),
                         ms(1),
                         0,
                         true,
                         {{id("map"), number, number}},
                         2});  // 54 ms
  }
  EXPECT_NEAR(picture(500).objective.value(), 1.0 * 46 + 0.5 * 60 + 0.25 * 40 + 0.1 * 54, 1e-9);
}

TEST_F(LiveViewTest, AsJson) {
  plan_comes(10, plan);
  fast(1, 20);
  fast(2, 40);
  view.add(record::Notice{at_ms(50), "starved", "CPU \xff"});
  const auto json = nlohmann::json::parse(to_json(picture(110)));
  EXPECT_EQ(json["app"], "test");
  EXPECT_EQ(json["state"], "running");
  EXPECT_EQ(json["window_s"], 0.1);
  EXPECT_EQ(json["cpus"], (std::vector{2, 3, 5}));
  EXPECT_EQ(json["plan"]["reason"], "measured");
  EXPECT_EQ(json["chains"][0]["newest_ms"], 26.0);
  EXPECT_EQ(json["chains"][0]["response_ms"]["p95"], 26.0);
  EXPECT_TRUE(json["chains"][1]["response_ms"].is_null());
  EXPECT_EQ(json["chains"][0]["worst_ms"].size(), 60U);
  EXPECT_EQ(json["subchains"][0]["subchain"], "fast");
  EXPECT_EQ(json["subchains"][0]["sharing"], "frames");
  EXPECT_EQ(json["cores"][0]["uses"][0]["name"], "fast");
  EXPECT_EQ(json["nodes"][0]["subchain"], "fast");
  EXPECT_EQ(json["notices"].back()["kind"], "starved");
}

}  // namespace
}  // namespace ctn::view
