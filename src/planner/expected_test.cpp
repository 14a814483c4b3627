// The planner of the least expected objective.
#include "planner/expected.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "plan/json.h"
#include "plan/limits.h"
#include "plan/validate.h"
#include "planner/formulas.h"
#include "planner/frames.h"
#include "planner/planner.h"
#include "planner/scoring.h"
#include "planner/testing/random_apps.h"
#include "planner/testing/small_apps.h"

namespace ctn::planner {
namespace {

constexpr double kSlack = 0.06;

TEST(ExpectedPlan, TriggersAReaderByItsWriterAndAsOftenAsItCan) {
  Two two;
  const plan::Plan plan =
      make_expected_plan(two.app, two.samples, two.costs, {.cores = 2, .slack = kSlack, .effort = 0.03}).value();
  // b alone on its core: 4 ms and what the machine takes, as often as the slack allows.
  const double p = two.b / (1.0 - kSlack);
  EXPECT_LT(plan.expected->objective, 1.05 * (two.a + two.b + p + p / 4.0));
}

// Guards: 35 ms were promised of a chain that begins behind a node which gives output every 700 ms, and a bound of 60
// ms was told to be kept.
TEST(ExpectedPlan, PromisesNothingSoonerThanTheNodeBeforeGivesOutput) {
  graph::AppSpec spec = graph::spec_of({"a", "b", "base"}, {"a b base"});
  node(spec, "base").external = true;
  node(spec, "a").output_period = graph::At<Nanos>{std::chrono::milliseconds{700}, {}};
  spec.subchains = {graph::subchain("s", "a b")};
  spec.objective = {graph::response("b", 1.0), graph::period("b", 1.0)};
  spec.objective[0].max = graph::At<Nanos>{std::chrono::milliseconds{60}, {}};
  const graph::App app = graph::build_app(spec).value();
  const model::CostTable costs(app.graph, Millis{8});
  const trial::Samples samples(app, constant_work(app, costs), Nanos{0}, 1);
  const plan::Plan plan =
      make_expected_plan(app, samples, costs, {.cores = 1, .slack = kSlack, .effort = 0.03}).value();
  EXPECT_GE(plan.chains[0].response, Millis{700});
  EXPECT_GE(plan.nodes[0].period, Millis{700});
  EXPECT_FALSE(plan.relaxed.empty());
  EXPECT_LE(plan.expected->objective, plan.objective * (1.0 + 1e-3));
}

// One node of 40 h: the remedy is not to scale weights.
TEST(ExpectedPlan, SaysWhatTakesTooLongToBePromised) {
  graph::AppSpec spec = graph::spec_of({"a", "base"}, {"a base"});
  node(spec, "base").external = true;
  spec.objective = {graph::response("a base", 1.0)};
  const graph::App app = graph::build_app(spec).value();
  const model::CostTable costs(app.graph, Millis{std::chrono::hours{40}});
  const trial::Samples samples(app, constant_work(app, costs), Nanos{0}, 1);
  const auto plan = make_expected_plan(app, samples, costs, {.cores = 1, .slack = 0.0, .effort = 0.03});
  ASSERT_FALSE(plan.ok());
  EXPECT_EQ(plan.error().message(),
            "nodes: with 0 % slack, a run of each subchain takes 40 h in all, most of it in 'a'; what takes more than "
            "24 h is not promised; make its nodes cheaper, or leave less slack");
}

// Behind a camera of 30 Hz neither image nor show, a millisecond each, is of use more often than that, whatever they
// could do on two cores.
TEST(ExpectedPlan, RunsCallbacksOfMessagesAsOftenAsMessagesCome) {
  graph::AppSpec spec = graph::spec_of({"camera", "image", "show", "base"}, {"camera image show base"});
  for (const char* name : {"camera", "base"}) node(spec, name).external = true;
  node(spec, "camera").period = graph::At<Nanos>{Nanos{33'333'333}, {}};
  spec.objective = {graph::response("image show base", 1.0)};
  const auto planned = [&](int cores) {
    const graph::App app = graph::build_app(spec).value();
    const model::CostTable costs(app.graph, Millis{1});
    const trial::Samples samples(app, constant_work(app, costs), Nanos{0}, 1);
    const ExpectedRequest request{.cores = cores, .slack = kSlack, .effort = 0.03};
    plan::Plan plan = make_expected_plan(app, samples, costs, request).value();
    EXPECT_TRUE(plan::validate(plan, app, costs, cores).ok());
    return plan;
  };
  EXPECT_LT(planned(2).expected->subchains[0].period, Millis{5});
  for (const char* name : {"image", "show"}) node(spec, name).needs_input = true;
  for (const int cores : {1, 2}) {
    const plan::Plan plan = planned(cores);
    for (const std::size_t subchain : {0U, 1U}) {
      SCOPED_TRACE(testing::Message() << subchain << " on " << cores);
      EXPECT_NEAR(plan.expected->subchains[subchain].period.count(), 33.3, 0.5);
      EXPECT_GE(plan.subchains[subchain].period, Millis{33.3});
    }
  }
}

TEST(ExpectedPlan, IsDoneJustBeforeTheTick) {
  const graph::App app = drawing();
  const model::CostTable costs(app.graph, Millis{1});
  const trial::Samples samples(app, constant_work(app, costs), Nanos{0}, 1);
  const plan::Plan plan =
      make_expected_plan(app, samples, costs, {.cores = 1, .slack = kSlack, .effort = 0.05}).value();
  ASSERT_EQ(plan.cores[0].members.size(), 1U);
  EXPECT_EQ(plan.cores[0].members[0].clock, app.graph.find_node("display"));
  // A period, the run, and what timers are late; half a period more if it had any phase.
  EXPECT_LT(plan.expected->objective, 8.333 + 1.0 + 0.5);
  EXPECT_GE(plan.objective, 8.333 + 8.333 + 1.0) << "promised is any phase";
}

// b has fewer items a run than it was promised for, so that its runs come sooner one after the other than the longest
// would take.
TEST(ExpectedPlan, WhoeverHasACoreIsPacedAsItWasTried) {
  graph::AppSpec spec = graph::spec_of({"a", "b", "base"}, {"a b base"});
  node(spec, "base").external = true;
  node(spec, "b").input = graph::InputKind::kQueue;
  spec.objective = {graph::response("a b base", 1.0)};
  graph::App app = graph::build_app(spec).value();
  app.scheduler.schedule = graph::ScheduleKind::kFrames;
  model::CostTable costs(app.graph, Millis{1});
  costs.set(NodeId(1), model::CostProfile::constant(Millis{2}).with_per_item(Millis{0.5}));
  const trial::Samples samples(app, constant_work(app, costs), Nanos{0}, 1);
  const plan::Plan plan = make_expected_plan(app, samples, costs, {.cores = 2, .slack = kSlack}).value();
  ASSERT_LT(plan.expected->subchains[1].period, plan.subchains[1].execution);
  const trial::Schedule schedule = trial::schedule_of(app, plan);
  const double found = trial::Trial(app, samples).run(schedule, {}).objective;
  EXPECT_NEAR(found, plan.expected->objective, 0.02 * found);
}

TEST(ExpectedPlan, IsTheSameEachTime) {
  const RandomCase random = random_case(3, {.subchains = 4}, 2);
  const trial::Samples samples(random.app, constant_work(random.app, random.costs), Nanos{0}, 1);
  const ExpectedRequest request{.cores = 2, .slack = kSlack, .effort = 0.02};
  const plan::Plan first = make_expected_plan(random.app, samples, random.costs, request).value();
  EXPECT_EQ(make_expected_plan(random.app, samples, random.costs, request).value(), first);
}

TEST(ExpectedPlan, TellsHowFarItIsAndFindsTheSame) {
  const RandomCase random = random_case(3, {.subchains = 4}, 2);
  const trial::Samples samples(random.app, constant_work(random.app, random.costs), Nanos{0}, 1);
  ExpectedRequest request{.cores = 2, .slack = kSlack, .effort = 0.03};
  const plan::Plan plan = make_expected_plan(random.app, samples, random.costs, request).value();
  std::vector<double> told;
  request.on_progress = [&](double part) { told.push_back(part); };
  EXPECT_EQ(make_expected_plan(random.app, samples, random.costs, request).value(), plan);
  EXPECT_GE(told.size(), 4U);
  EXPECT_TRUE(std::is_sorted(told.begin(), told.end()));
  EXPECT_EQ(told.back(), 1.0);
}

TEST(ExpectedPlan, BeginsWithWhatIsKnown) {
  const RandomCase random = random_case(9, {.subchains = 6}, 2);
  const trial::Samples samples(random.app, constant_work(random.app, random.costs), Nanos{0}, 1);
  const ExpectedRequest request{.cores = 2, .slack = kSlack, .effort = 0.05};
  const plan::Plan known = make_expected_plan(random.app, samples, random.costs, request).value();
  // With a few guesses, and with more than are kept.
  for (const double effort : {0.002, 0.03}) {
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      ExpectedRequest from_known = request;
      from_known.effort = effort;
      from_known.seed = seed;
      from_known.known = &known;
      const plan::Plan again = make_expected_plan(random.app, samples, random.costs, from_known).value();
      EXPECT_LT(again.expected->objective, 1.01 * known.expected->objective) << "effort " << effort << " seed " << seed;
    }
  }
}

TEST(ExpectedPlan, SharesCoresAsTheAppSays) {
  RandomCase random = random_case(3, {.subchains = 5, .caps = true}, 2);
  const trial::Samples samples(random.app, constant_work(random.app, random.costs), Nanos{0}, 1);
  const ExpectedRequest request{.cores = 2, .slack = kSlack, .effort = 0.02};
  for (const auto schedule : {graph::ScheduleKind::kFrames, graph::ScheduleKind::kPriorities}) {
    for (const auto frames : {graph::FrameMode::kElastic, graph::FrameMode::kFixed}) {
      random.app.scheduler.schedule = schedule;
      random.app.scheduler.frames = frames;
      const plan::Plan plan = make_expected_plan(random.app, samples, random.costs, request).value();
      EXPECT_TRUE(plan::validate(plan, random.app, random.costs, 2).ok());
      EXPECT_TRUE(plan.expected);
      EXPECT_EQ(plan.planner, "auto");
      for (const plan::CorePlan& core : plan.cores) {
        EXPECT_TRUE(schedule == graph::ScheduleKind::kFrames ? core.members.empty() : core.slots.empty());
        EXPECT_EQ(core.frames, frames);
      }
    }
  }
}

// Two at 100 Hz, 6 ms each.
graph::App two_exact() {
  graph::AppSpec spec = graph::spec_of({"a", "b"}, {});
  for (const char* name : {"a", "b"}) {
    for (auto rate : {&graph::NodeSpec::min_rate, &graph::NodeSpec::max_rate}) {
      node(spec, name).*rate = graph::At<Rate>{Rate{100.0}, {}};
    }
    spec.objective.push_back(graph::period(name, 1.0));
  }
  return graph::build_app(spec).value();
}

TEST(ExpectedPlan, RatesOutOfReachAreRefusedWithWhatIsMissing) {
  graph::App app = two_exact();
  const model::CostTable costs(app.graph, Millis{6});
  const trial::Samples samples(app, constant_work(app, costs), Nanos{0}, 1);
  for (const auto schedule : {graph::ScheduleKind::kAuto, graph::ScheduleKind::kPriorities}) {
    app.scheduler.schedule = schedule;
    const auto plan = make_expected_plan(app, samples, costs, {.cores = 1, .slack = kSlack, .effort = 0.01});
    ASSERT_FALSE(plan.ok());
    EXPECT_EQ(plan.error().kind(), ErrorKind::kCaller);
    for (const char* part : {"exact rates of a, b cannot be met on 1 core with 6 % slack", "need 120 % of a core",
                             "of 94 %", "26 % of a core is missing", "give it 2 cores"}) {
      EXPECT_THAT(plan.error().message(), testing::HasSubstr(part));
    }
  }
}

// Guards: there was no plan, since one core was left empty while the other was shared.
TEST(ExpectedPlan, AnExclusiveGroupStaysOnOneCoreHoweverManyThereAre) {
  graph::AppSpec spec = graph::spec_of({"a", "b"}, {});
  spec.objective = {graph::period("a", 1.0), graph::period("b", 1.0)};
  spec.exclusive = {{{"spinner", {}}, graph::split("a b")}};
  const graph::App app = graph::build_app(spec).value();
  const model::CostTable costs(app.graph, Millis{6});
  const trial::Samples samples(app, constant_work(app, costs), Nanos{0}, 1);
  for (const int cores : {1, 2, 3}) {
    const auto plan = make_expected_plan(app, samples, costs, {.cores = cores, .slack = kSlack, .effort = 0.01});
    ASSERT_TRUE(plan.ok()) << plan.error().message();
    EXPECT_EQ(plan->subchains[0].cores.size(), 1U);
    EXPECT_EQ(plan->subchains[0].cores, plan->subchains[1].cores);
  }
}

TEST(ExpectedPlan, RefusesWhatNobodyCanPlanFor) {
  Two two;
  const auto refusal = [&](int cores, double slack) {
    const auto plan = make_expected_plan(two.app, two.samples, two.costs, {.cores = cores, .slack = slack});
    return plan ? std::string() : plan.error().message();
  };
  EXPECT_THAT(refusal(0, 0.0), testing::HasSubstr("give at least 1"));
  EXPECT_THAT(refusal(kMaxCores + 1, 0.0), testing::HasSubstr("give at most 1024"));
  EXPECT_THAT(refusal(1, 1.0), testing::HasSubstr("less than 100 %"));
  EXPECT_THAT(refusal(0, -0.5), testing::AllOf(testing::HasSubstr("cores"), testing::HasSubstr("slack")));
  std::vector<std::string> names;
  for (std::size_t i = 0; i <= kMaxSubchains; ++i) names.push_back("n" + std::to_string(i));
  graph::AppSpec spec = graph::spec_of(names, {});
  spec.objective = {graph::period("n0", 1.0)};
  const graph::App app = graph::build_app(spec).value();
  const model::CostTable costs(app.graph, Millis{1});
  const auto many = make_plan_by_formulas(app, costs, {.cores = 1});
  ASSERT_FALSE(many.ok());
  EXPECT_THAT(many.error().message(), testing::HasSubstr("the app has 257 subchains"));
}

RC_GTEST_PROP(FormulasProperty, MakeAValidPlanOrSayWhyNot, (std::uint64_t seed)) {
  const int cores = 1 + static_cast<int>(seed % 4);
  RandomCase random = random_case(seed,
                                  {.subchains = 2 + static_cast<int>(seed % 7),
                                   .queue = true,
                                   .caps = true,
                                   .exact = seed % 5 == 0,
                                   .bounds = true,
                                   .pairs = true,
                                   .kinds = seed % 3 == 0,
                                   .waits = seed % 2 == 0,
                                   .exclusive = seed % 11 < 4,
                                   .batches = seed % 4 < 2},
                                  cores);
  if (seed % 3 < 2) need_input(random.app);
  const trial::Samples samples(random.app, trial::MeasuredRuns{}, random.costs);
  // Even where there was no time to look for one.
  const FormulaRequest request{.cores = cores, .slack = kSlack, .guesses = seed % 7 < 3 ? std::size_t{1} : 6000};
  const auto check = [&](const Result<plan::Plan>& plan) {
    if (!plan) RC_ASSERT(plan::has_exact_rates(random.app.graph));
    if (!plan) return;
    const Status valid = plan::validate(*plan, random.app, random.costs, cores);
    if (!valid) RC_FAIL(valid.error().message());
  };
  check(make_guessed_plan(random.app, samples, random.costs, request));
  for (const auto schedule :
       {graph::ScheduleKind::kAuto, graph::ScheduleKind::kFrames, graph::ScheduleKind::kPriorities}) {
    random.app.scheduler.schedule = schedule;
    check(make_plan_by_formulas(random.app, random.costs, request));
  }
}

// So much worse than frames a plan may be in a trial of other draws and another length than those of its search.
constexpr double kAsGood = 1.15;

// The score of the plan for a random app, as a part of that of its frames; none where there is nothing to compare. Of
// each plan it is checked that it is valid.
std::optional<double> score_beside_frames(std::uint64_t seed) {
  const int cores = 1 + static_cast<int>(seed % 3);
  RandomCase random = random_case_of_all_sorts(seed, cores);
  if (seed % 13 < 4) need_input(random.app);
  const trial::Samples samples(random.app, constant_work(random.app, random.costs), Nanos{0}, 1);
  const ExpectedRequest request{.cores = cores, .slack = kSlack, .effort = 0.005};
  const Result<plan::Plan> plan = make_expected_plan(random.app, samples, random.costs, request);
  const Result<plan::Plan> frames = make_plan_in_frames(random.app, random.costs, {.cores = cores, .slack = kSlack});
  RC_ASSERT(plan.ok() || (!frames && plan::has_exact_rates(random.app.graph)));
  if (!plan) return std::nullopt;
  const Status valid = plan::validate(*plan, random.app, random.costs, cores);
  if (!valid) RC_FAIL(valid.error().message());
  if (!frames) return std::nullopt;
  const trial::Trial trial(random.app, samples);
  // What the machine takes comes out of the slack, which the formulas do not know.
  const trial::Figures of_frames = trial.run(trial::schedule_of(random.app, *frames), {});
  const bool too_full = std::any_of(of_frames.busy.begin(), of_frames.busy.end(),
                                    [](double busy) { return busy > 1.0 - kSlack + kLoadTolerance; });
  if (too_full) return std::nullopt;
  const auto score = [&](const plan::Plan& tried) {
    const trial::Figures figures = trial.run(trial::schedule_of(random.app, tried), {.p95 = true});
    double sum = figures.objective;
    for (std::size_t term = 0; term < figures.terms.size(); ++term) {
      sum += tail_weights(random.app)[term] * random.app.objective[term].weight * figures.terms[term].p95_ms;
    }
    return relaxed_score(sum, tried.relax_factor);
  };
  return score(*plan) / score(*frames);
}

RC_GTEST_PROP(ExpectedPlanProperty, IsValidAndNeverExpectedToBeWorseThanFrames, (std::uint64_t seed)) {
  const std::optional<double> beside = score_beside_frames(seed);
  RC_ASSERT(!beside || *beside <= kAsGood);
}

// Guards: the plan for it was as good as its frames for some ten seconds, and then worse for more than a minute.
TEST(ExpectedPlan, WhatSlidesSlowlyIsTriedForLonger) {
  const std::optional<double> beside = score_beside_frames(2868);
  ASSERT_TRUE(beside);
  EXPECT_LE(*beside, kAsGood);
}

}  // namespace
}  // namespace ctn::planner
