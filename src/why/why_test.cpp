#include "why/why.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <functional>
#include <random>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "base/testing/times.h"
#include "plan/json.h"
#include "why/json.h"
#include "why/testing/story.h"

namespace ctn::why {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

TEST(Why, TakesAResponseApart) {
  Story story;
  story.rounds(0, 2);
  EXPECT_THAT(story.longest(),
              ElementsAre("running scan 2.0", "running LM 3.0", "running LP 4.0", "waiting-for-trigger scan 11.0",
                          "running scan 2.0", "running LM 3.0", "running LP 4.0"));
  EXPECT_EQ(story.cause(), "none") << "29 ms are within the bound";
}

TEST(Why, ATriggerThatWasSentLate) {
  Story story;
  story.rounds(0, 5);
  story.round(100, 104);
  EXPECT_THAT(story.longest(),
              ElementsAre("running scan 2.0", "running LM 3.0", "running LP 4.0", "waiting-for-trigger scan 11.0",
                          "late-trigger scan 4.0", "running scan 2.0", "running LM 3.0", "running LP 4.0"));
  EXPECT_EQ(story.cause(), "late-trigger scan");
}

TEST(Why, ARunThatWasLongAndTheOneThatItKeptBack) {
  Story story;
  story.rounds(0, 5);
  story.trigger(100, 100);
  story.run("scan", {100, 102});
  story.run("LM", {102, 122});
  story.run("LP", {122, 126});
  story.round(120, 126);
  EXPECT_THAT(story.longest(),
              ElementsAre("running scan 2.0", "running LM 3.0", "running LP 4.0", "waiting-for-trigger scan 11.0",
                          "running scan 2.0", "running LM 3.0", "running-longer LM 17.0", "running LP 4.0"));
  EXPECT_EQ(story.cause(), "long-run LM");
}

// Of those that are named, whatever their bound; one that never was is unexplained.
TEST(Why, CausesOfSomeResponses) {
  const auto tell = [](Story& story) {
    story.rounds(0, 5);
    story.round(100, 104);
    story.trigger(124, 124);
    story.run("scan", {124, 126});
    story.run("LM", {126, 146});
    story.run("LP", {146, 150});
  };
  const auto span = [](int begin, int end) { return Span{at(ms(begin)), at(ms(end))}; };
  Story story;
  tell(story);
  EXPECT_THAT(story.analyser().causes_of({{span(80, 113), span(104, 150), span(70, 112), span(0, 40)}}),
              ElementsAre(ElementsAre(CauseKind::kLateTrigger, CauseKind::kLongRun, CauseKind::kUnexplained,
                                      CauseKind::kUnexplained)));
  Story other;
  tell(other);
  EXPECT_THAT(other.analyser().causes_of(std::vector<std::vector<Span>>(1)), ElementsAre(IsEmpty()));
}

TEST(Why, PreEmptedInARunAndBeforeOne) {
  Story story;
  story.rounds(0, 5);
  story.trigger(100, 100);
  story.run("hog", {101, 104});
  story.run("scan", {100, 105, 2});
  story.run("hog", {106, 109});
  story.run("LM", {109, 112});
  story.run("LP", {112, 116});
  EXPECT_THAT(story.longest(),
              ElementsAre("running scan 2.0", "running LM 3.0", "running LP 4.0", "waiting-for-trigger scan 11.0",
                          "running scan 1.0", "pre-empted scan by hog 3.0", "running scan 1.0", "kernel LM 1.0",
                          "pre-empted LM by hog 3.0", "running LM 3.0", "running LP 4.0"));
  EXPECT_EQ(story.cause(), "pre-empted scan by hog");
}

TEST(Why, NobodyOfTheAppHadTheCore) {
  Story story;
  story.rounds(0, 5);
  story.trigger(100, 100);
  story.run("scan", {107, 109});
  story.run("LM", {109, 114, 3});
  story.run("LP", {114, 118});
  const auto parts = story.longest();
  EXPECT_THAT(parts, testing::Contains("kernel scan 7.0"));
  EXPECT_THAT(parts, testing::Contains("kernel LM 2.0"));
  EXPECT_EQ(story.cause(), "starved scan");
}

TEST(Why, ARunThatWaitedForADevice) {
  Story story;
  story.rounds(0, 5);
  story.trigger(100, 100);
  story.run("scan", {100, 102});
  story.run("LM", {102, 115, 3, 10});
  story.run("LP", {115, 119});
  EXPECT_THAT(story.longest(),
              ElementsAre("running scan 2.0", "running LM 3.0", "running LP 4.0", "waiting-for-trigger scan 11.0",
                          "running scan 2.0", "running LM 1.5", "device LM 10.0", "running LM 1.5", "running LP 4.0"));
  EXPECT_EQ(story.cause(), "device LM");
}

TEST(Why, AnOutputThatWasLeftOut) {
  Story story;
  story.rounds(0, 5);
  story.trigger(100, 100);
  story.run("scan", {100, 102});
  story.run("LM", {102, 105, -1, 0, false});
  story.round(120);
  EXPECT_THAT(story.longest(),
              ElementsAre("running scan 2.0", "running LM 3.0", "running LP 4.0", "no-output LM 16.0",
                          "waiting-for-trigger scan 15.0", "running scan 2.0", "running LM 3.0", "running LP 4.0"));
  EXPECT_EQ(story.cause(), "no-output LM");
}

TEST(Why, AnInputThatLayInFrontOfABusyNode) {
  Story story(2);
  for (int i = 0; i < 3; ++i) {
    story.run("scan", {20.0 * i, 20.0 * i + 2});
    story.run("map", {20.0 * i + 3, 20.0 * i + 8});
  }
  const Analysis analysis = story.finish();
  ASSERT_EQ(analysis.responses, 2U);
  for (const Response& response : analysis.worst) {
    EXPECT_EQ(response.length(), ms(28));
    EXPECT_EQ(response.parts.front().kind, PartKind::kRunning);
    EXPECT_EQ(response.parts[1].kind, PartKind::kUnexplained) << "no trigger of map was recorded";
  }
  EXPECT_EQ(analysis.explained, 0U);
}

TEST(Why, ADisplayThatTakesWhatIsDoneAtItsTicks) {
  Story story(3);
  story.clock("lamp", 0, 16);
  story.rounds(0, 4);
  const Analysis analysis = story.finish();
  ASSERT_FALSE(analysis.worst.empty());
  for (const Response& response : analysis.worst) {
    EXPECT_EQ(response.end.time_since_epoch() % ms(16), Nanos{0});
    EXPECT_EQ(response.parts.back().kind, PartKind::kWaitingForTick);
  }
}

TEST(Why, OfSeveralCpusThatAreNotKnownItIsNotSaidWhoHadTheCore) {
  Story story(0, 2);
  story.rounds(0, 2);
  story.trigger(40, 40);
  story.run("hog", {41, 52});
  story.run("map", {41, 52});
  story.run("scan", {40, 53, 2});
  story.run("LM", {53, 56});
  story.run("LP", {56, 60});
  EXPECT_THAT(story.longest(), testing::Contains("unexplained scan 11.0"));
  Story alone(0, 2);
  alone.rounds(0, 2);
  alone.trigger(40, 40);
  alone.run("hog", {41, 52});
  alone.run("scan", {40, 53, 2});
  alone.run("LM", {53, 56});
  alone.run("LP", {56, 60});
  EXPECT_THAT(alone.longest(), testing::Contains("pre-empted scan by hog 11.0")) << "it can have been no other";
}

TEST(Why, LateWithoutABoundIsOverThe99thPercentile) {
  Story story(2);
  for (int i = 0; i < 201; ++i) {
    story.run("scan", {20.0 * i, 20.0 * i + 2});
    story.run("map", {20.0 * i + 2, 20.0 * i + (i == 100 ? 14 : 8)});
  }
  const Analysis analysis = story.finish();
  EXPECT_FALSE(analysis.bound);
  EXPECT_EQ(analysis.late_over, ms(28));
  EXPECT_EQ(analysis.late, 1U);
  EXPECT_EQ(analysis.causes[static_cast<std::size_t>(CauseKind::kLongRun)], 1U);
}

TEST(Why, WhereAChainIsUsuallyLateTheLongestPartIsTheCause) {
  Story story;
  for (int i = 0; i < 5; ++i) story.round(30.0 * i);
  const Analysis analysis = story.finish();
  EXPECT_EQ(analysis.late, 4U);
  EXPECT_EQ(analysis.causes[static_cast<std::size_t>(CauseKind::kWaitedForTrigger)], 4U);
}

// LM gives the sample twice before LP takes it: what it waited for is LP, not LM's second run.
TEST(Why, ASampleWaitsWhereItCameFirst) {
  Story story;
  story.rounds(0, 2);
  story.trigger(40, 40);
  story.run("scan", {40, 42});
  story.run("LM", {42, 45});
  story.run("LM", {46, 48});
  story.run("LP", {53, 57});
  EXPECT_THAT(story.longest(), ElementsAre("running scan 2.0", "running LM 3.0", "running LP 4.0",
                                           "waiting-for-trigger scan 11.0", "running scan 2.0", "running LM 3.0",
                                           "kernel LM 1.0", "running LM 2.0", "kernel LP 5.0", "running LP 4.0"));
}

// Rounds every 20 ms, and in place of every 50th, from `t` on, what is put in.
void expect_all_named(Story& story, const std::function<void(double t)>& odd, const std::string& cause) {
  constexpr int kInjected = 20;
  constexpr int kEach = 50;
  for (int i = 1; i <= kInjected * kEach + 1; ++i) {
    if (i % kEach == 0) {
      odd(20.0 * i);
    } else {
      story.round(20.0 * i);
    }
  }
  const Analysis analysis = story.finish(kInjected + 1);
  EXPECT_EQ(analysis.late, static_cast<std::uint64_t>(kInjected));
  ASSERT_EQ(analysis.worst.size(), static_cast<std::size_t>(kInjected) + 1);
  for (std::size_t i = 0; i < kInjected; ++i) {
    ASSERT_TRUE(analysis.worst[i].cause.has_value());
    EXPECT_EQ(std::string(to_string(analysis.worst[i].cause->kind)) + " " +
                  story.app().graph.node(analysis.worst[i].cause->node).name,
              cause);
  }
  EXPECT_FALSE(analysis.worst.back().late);
}

TEST(WhyPlayed, TriggersThatAreSentLate) {
  Story story;
  expect_all_named(
      story, [&](double t) { story.round(t, t + 8); }, "late-trigger scan");
}

TEST(WhyPlayed, TriggersThatAreDueLater) {
  Story story;
  expect_all_named(
      story, [&](double t) { story.round(t + 8); }, "waited-for-trigger scan");
}

// A camera that leaves out a frame: the run of that time takes the one that was there already.
TEST(WhyPlayed, SamplesThatDoNotCome) {
  Story story(4);
  story.clock("sky", 0, 20);
  const auto left_out = [&](double t) {
    story.clock("sky", t - 1, t - 20, 40);
    story.round(t);
    story.clock("sky", t + 19, t + 20, 20);
  };
  expect_all_named(story, left_out, "waited-for-sample scan");
}

// A display whose tick comes 8 ms later.
TEST(WhyPlayed, TicksThatComeLater) {
  Story story(3);
  story.clock("lamp", 10, 20);
  const auto later = [&](double t) {
    story.clock("lamp", t, t + 18, 20);
    story.round(t);
    story.clock("lamp", t + 19, t + 30, 20);
  };
  expect_all_named(story, later, "waited-for-tick LP");
}

TEST(Why, APlanWithCoresThatItHasNotIsNoPlan) {
  Story story;
  plan::Plan plan;
  plan.planner = "by hand";
  for (std::size_t id = 0; id < story.app().graph.subchains().size(); ++id) {
    plan.subchains.push_back({{static_cast<int>(id)}, Millis{20}, Millis{9}, 1, 1.0, Millis{9}, 1});
    plan.cores.push_back({});
  }
  for (const graph::Term& term : story.app().objective) {
    if (term.metric == graph::Metric::kPeriod) {
      plan.nodes.push_back({term.path.front(), Millis{20}, term.weight});
    } else {
      plan.chains.push_back({term.path, Millis{29}, Millis{9}, Millis{20}, term.weight});
    }
  }
  const auto added = [&] {
    return story.add(record::PlanChange{at(Nanos{0}), "static", plan::to_json(plan, story.app())});
  };
  EXPECT_TRUE(added().ok());
  plan.subchains.front().cores = {7};
  const Status refused = added();
  ASSERT_FALSE(refused.ok());
  EXPECT_THAT(refused.error().message(), HasSubstr("core 7"));
}

TEST(Why, NothingIsMeasured) {
  Story story;
  story.round(0);
  const Analysis analysis = story.finish();
  EXPECT_EQ(analysis.responses, 0U);
  EXPECT_THAT(analysis.worst, IsEmpty());
  EXPECT_THAT(to_json(analysis, story.app(), at(Nanos{0})), HasSubstr("\"response_ms\": null"));
}

TEST(WhyJson, IsOneDocumentWithUnits) {
  Story story;
  story.rounds(0, 5);
  story.round(100, 104);
  const auto document = nlohmann::json::parse(to_json(story.finish(1), story.app(), at(ms(1))));
  EXPECT_EQ(document["chain"], "scan -> LM -> LP");
  EXPECT_EQ(document["late_over"], "bound");
  EXPECT_EQ(document["late_over_ms"], 32.0);
  EXPECT_EQ(document["causes"], nlohmann::json({{"late-trigger", 1}}));
  EXPECT_EQ(document["worst"][0]["response_ms"], 33.0);
  EXPECT_EQ(document["worst"][0]["begin_ms"], 79.0);
  EXPECT_EQ(document["worst"][0]["cause"]["beyond_usual_ms"], 4.0);
  EXPECT_EQ(document["worst"][0]["parts"][0]["by"], nullptr);
}

TEST(FindChain, ByNumberPathOrLastNode) {
  const graph::App app = robot();
  EXPECT_EQ(find_chain(app, "0").value(), 0U);
  EXPECT_EQ(find_chain(app, "scan>LM>LP").value(), 0U);
  EXPECT_EQ(find_chain(app, " scan -> map ").value(), 2U);
  EXPECT_EQ(find_chain(app, "map").value(), 2U);
  EXPECT_EQ(find_chain(app, "lamp").value(), 3U);
  for (const char* unknown : {"1", "9", "", ">", "scan", "nowhere", "scan>LP", "99999999999999999999"}) {
    const auto none = find_chain(app, unknown);
    ASSERT_FALSE(none.ok()) << unknown;
    EXPECT_THAT(none.error().message(), HasSubstr("2 (scan -> map)")) << unknown;
    EXPECT_THAT(none.error().message(), Not(HasSubstr("1 ("))) << unknown;
  }
}

void expect_sums(const Response& response) {
  TimePoint now = response.begin;
  for (const Part& part : response.parts) {
    RC_ASSERT(part.begin == now);
    RC_ASSERT(part.end > part.begin);
    now = part.end;
  }
  RC_ASSERT(now == response.end);
}

// Whatever is recorded, even what cannot have happened.
RC_GTEST_PROP(WhyProperty, PartsFollowEachOtherAndAddUp, ()) {
  std::mt19937 random(*rc::gen::arbitrary<std::uint32_t>());
  const auto below = [&](int limit) { return static_cast<int>(random() % static_cast<unsigned>(limit)); };
  const std::size_t term = std::vector<std::size_t>{0, 2, 3, 4}[random() % 4];
  Story story(term, random() % 2 + 1);
  if (below(2) == 0) story.clock("lamp", below(10), 1 + below(20));
  if (below(2) == 0) story.clock("sky", below(10), 1 + below(20));
  const char* const names[] = {"scan", "LM", "LP", "map", "hog"};
  double now = 0.0;
  for (int event = 0; event < 200; ++event) {
    now += 0.25 * below(12);
    if (below(4) == 0) story.trigger(now + below(5) - 2, now);
    const int length = below(12);
    const SubchainId owner{random() % story.app().graph.subchains().size()};
    const TimePoint begin = at(ms(now));
    if (below(6) == 0) story.add(record::SlotUse{0, owner, begin, begin, begin + ms(below(9))});
    if (below(9) == 0) story.add(record::Steal{0, owner, SubchainId{0}, begin, begin + ms(below(9))});
    story.run(names[below(5)], {now - length, now, 0.5 * below(20), 0.5 * below(4), below(5) > 0});
  }
  const Analysis analysis = story.finish();
  for (const Response& response : analysis.worst) expect_sums(response);
  RC_ASSERT(analysis.worst.size() == analysis.responses);
}

}  // namespace
}  // namespace ctn::why
