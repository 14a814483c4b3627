#include "planner/moves.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <array>

#include "plan/limits.h"
#include "planner/testing/random_apps.h"

namespace ctn::planner {
namespace {

TEST(Random, IsTheSameEverywhere) {
  Random random(7);
  EXPECT_EQ(random.below(1000), 221U);
  EXPECT_EQ(random.below(1000), 174U);
  EXPECT_DOUBLE_EQ(random.fraction(), 0.54937432491932392);
}

RC_GTEST_PROP(MovesProperty, KeepASchedulePossibleWhateverTheyDo, (std::uint64_t seed)) {
  const int cores = 1 + static_cast<int>(seed % 3);
  const RandomCase random = random_case(seed, {.subchains = 5, .caps = true, .exact = true, .pairs = true}, cores);
  graph::App app = random.app;
  if (seed % 2 == 0) need_input(app);
  const std::vector<plan::UsefulPeriod> useful = plan::useful_periods(app.graph);
  const std::size_t count = app.graph.subchains().size();
  const Pipelines pipelines(app, trial::Samples(app, trial::MeasuredRuns(app.graph.nodes().size()), random.costs),
                            random.costs, 0.06);
  const Moves moves(app, std::vector<double>(count, 3.0), pipelines, cores);
  trial::Schedule schedule{
      .cores = cores, .subchains = std::vector<trial::Place>(count), .frames = {}, .pipelines = {}};
  for (std::size_t i = 0; i < count; ++i) {
    schedule.subchains[i].priority = static_cast<int>(i) + 1;
    schedule.subchains[i].period = std::max(moves.shortest_period(i), Nanos{std::chrono::milliseconds{20}});
    if (moves.exact(i)) schedule.subchains[i].period = moves.shortest_period(i);
  }
  Random chance(seed);
  bool any_pipeline = false;
  for (int step = 0; step < 2000; ++step) {
    moves.change(schedule, chance);
    any_pipeline = any_pipeline || !schedule.pipelines.empty();
  }
  RC_CLASSIFY(any_pipeline, "with pipelines");
  std::vector<int> owners(static_cast<std::size_t>(cores), 0);
  for (const trial::Pipeline& pipeline : schedule.pipelines) {
    RC_ASSERT(pipeline.cores.size() > 1U);
    RC_ASSERT(schedule.subchains[pipeline.subchain.index()].form == trial::Form::kPipeline);
    for (const int core : pipeline.cores) RC_ASSERT(++owners.at(static_cast<std::size_t>(core)) == 1);
  }
  std::size_t in_pipelines = 0;
  std::vector<int> priorities;
  for (std::size_t i = 0; i < count; ++i) {
    const trial::Place& place = schedule.subchains[i];
    const plan::PeriodLimits limits = plan::period_limits(app.graph, SubchainId(i));
    if (place.form == trial::Form::kPipeline) {
      ++in_pipelines;
      continue;
    }
    RC_ASSERT(owners.at(static_cast<std::size_t>(place.core)) == 0);
    priorities.push_back(place.priority);
    RC_ASSERT(place.core >= 0 && place.core < cores);
    RC_ASSERT(!(place.pause && place.after));
    RC_ASSERT(place.period >= to_nanos(limits.min));
    RC_ASSERT(limits.exact || place.after || place.period >= to_nanos(useful[i].min));
    if (limits.exact) RC_ASSERT(place.period == to_nanos(*limits.exact) && !place.pause && !place.after);
    RC_ASSERT(place.phase == Nanos{0} || place.phase < place.period);
    std::size_t at = i;
    for (std::size_t steps = 0; schedule.subchains[at].after; ++steps) {
      RC_ASSERT(steps <= count);
      at = schedule.subchains[at].after->subchain()->index();
    }
  }
  RC_ASSERT(in_pipelines == schedule.pipelines.size());
  std::sort(priorities.begin(), priorities.end());
  RC_ASSERT(std::adjacent_find(priorities.begin(), priorities.end()) == priorities.end());
}

Pipelines no_costs_known(const graph::App& app) {
  const model::CostTable costs(app.graph, Millis{1.0});
  return Pipelines(app, trial::Samples(app, trial::MeasuredRuns(app.graph.nodes().size()), costs), costs, 0.0);
}

// s, every 5 ms, feeds a; what may trigger a is for the app to say. b is free.
graph::App fed_by_a_sensor(graph::TriggerBy trigger) {
  graph::AppSpec spec = graph::spec_of({"s", "a", "b"}, {"s a b"});
  graph::node(spec, "s").unscheduled = true;
  graph::node(spec, "s").period = graph::At<Nanos>{std::chrono::milliseconds{5}, {}};
  graph::node(spec, "a").trigger = graph::At<graph::TriggerBy>{trigger, {}};
  spec.objective = {graph::response("s a b", 1.0)};
  return graph::build_app(spec).value();
}

struct Seen {
  bool by_time = false;  // or after a pause
  bool by_phase = false;
  bool by_subchain = false;
  bool by_arrival = false;
  bool every_other = false;  // arrival, or less often
};
Seen triggers_of_a(graph::TriggerBy trigger, Freedom freedom = {}) {
  const graph::App app = fed_by_a_sensor(trigger);
  const Pipelines pipelines = no_costs_known(app);
  Moves moves(app, {1.0, 1.0}, pipelines, 1, freedom);
  moves.know_clocks({NodeId(std::size_t{0})});
  trial::Schedule schedule{.cores = 1, .subchains = std::vector<trial::Place>(2), .frames = {}, .pipelines = {}};
  for (std::size_t i = 0; i < 2; ++i) {
    schedule.subchains[i].priority = static_cast<int>(i) + 1;
    schedule.subchains[i].period = std::chrono::milliseconds{10};
    moves.set_asked_trigger(schedule.subchains[i], i);
  }
  Random random(1);
  Seen seen;
  for (int step = 0; step < 3000; ++step) {
    const std::optional<plan::After>& after = schedule.subchains[0].after;
    seen.by_time = seen.by_time || !after;
    for (const trial::Place& place : schedule.subchains) {
      seen.by_phase = seen.by_phase || place.phase > Nanos{0} || place.clock;
    }
    seen.by_subchain = seen.by_subchain || (after && after->subchain() != nullptr);
    seen.by_arrival = seen.by_arrival || (after && after->leader == plan::Leader(NodeId(std::size_t{0})));
    seen.every_other = seen.every_other || (after && after->node() != nullptr && after->every > 1);
    EXPECT_FALSE(schedule.subchains[1].after && schedule.subchains[1].after->node() != nullptr) << "s does not feed b";
    moves.change(schedule, random);
  }
  return seen;
}

TEST(Moves, AreTriggeredByWhatTheAppAllows) {
  const Seen time = triggers_of_a(graph::TriggerBy::kTime);
  EXPECT_TRUE(time.by_time && !time.by_subchain && !time.by_arrival);
  const Seen arrival = triggers_of_a(graph::TriggerBy::kArrival);
  EXPECT_TRUE(!arrival.by_time && !arrival.by_subchain && arrival.by_arrival && arrival.every_other);
  const Seen any = triggers_of_a(graph::TriggerBy::kAny);
  EXPECT_TRUE(any.by_time && any.by_subchain && any.by_arrival && any.every_other);
}

TEST(Moves, LeaveOutWhatTheyAreNotFreeToChoose) {
  const Seen any = triggers_of_a(graph::TriggerBy::kAny);
  EXPECT_TRUE(any.by_phase);
  const Seen no_outputs = triggers_of_a(graph::TriggerBy::kAny, {.outputs = false});
  EXPECT_TRUE(no_outputs.by_time && no_outputs.by_phase && !no_outputs.by_subchain && !no_outputs.by_arrival);
  EXPECT_TRUE(triggers_of_a(graph::TriggerBy::kArrival, {.outputs = false}).by_arrival) << "the app asks for it";
  const Seen no_phases = triggers_of_a(graph::TriggerBy::kAny, {.phases = false});
  EXPECT_TRUE(no_phases.by_time && !no_phases.by_phase && no_phases.by_subchain && no_phases.by_arrival);
}

class FallInLine : public ::testing::Test {
 protected:
  // A chain of a, b and c; d may only be triggered by time, e costs ten times as much as others and weighs nothing.
  FallInLine() {
    graph::AppSpec spec = graph::spec_of({"a", "b", "c", "d", "e"}, {"a b c", "d c", "e c"});
    graph::node(spec, "d").trigger = graph::At<graph::TriggerBy>{graph::TriggerBy::kTime, {}};
    spec.objective = {graph::response("a b c", 1.0), graph::response("e c", 0.01)};
    app = graph::build_app(spec).value();
    for (int i = 0; i < 5; ++i) {
      schedule.subchains.push_back({.priority = i + 1, .period = std::chrono::milliseconds{i == 4 ? 60 : 20}});
    }
  }
  const trial::Place& place(const char* node) const {
    return schedule.subchains[app.graph.node(*app.graph.find_node(node)).subchain->index()];
  }
  SubchainId leader_of(const char* node) const { return *place(node).after->subchain(); }
  SubchainId subchain(const char* node) const { return *app.graph.node(*app.graph.find_node(node)).subchain; }

  graph::App app;
  trial::Schedule schedule{.cores = 1, .subchains = {}, .frames = {}, .pipelines = {}};
};

TEST_F(FallInLine, EachRunsAfterTheOneBeforeItAndTheFirstAfterAll) {
  const Pipelines pipelines = no_costs_known(app);
  const Moves moves(app, {1.0, 1.0, 1.0, 1.0, 10.0}, pipelines, 1);
  Random random(1);
  moves.fall_in_line(schedule, false, random);
  EXPECT_TRUE(place("a").pause && !place("a").after);
  EXPECT_EQ(leader_of("b"), subchain("a"));
  EXPECT_EQ(place("b").after->every, 1);
  EXPECT_EQ(leader_of("c"), subchain("b"));
  EXPECT_EQ(place("c").after->every, 1);
  EXPECT_EQ(leader_of("e"), subchain("a"));
  EXPECT_EQ(place("e").after->every, 5) << "a round of all takes 13 ms";
  EXPECT_GT(place("b").priority, place("c").priority);
  for (const char* node : {"b", "c", "e"}) EXPECT_LT(place("a").priority, place(node).priority);
  EXPECT_FALSE(place("d").after || place("d").pause);
  EXPECT_EQ(place("d").priority, 4) << "as before";
}

TEST(Moves, ComeLessOften) {
  using std::chrono::milliseconds;
  const graph::App app = fed_by_a_sensor(graph::TriggerBy::kAny);
  const Pipelines pipelines = no_costs_known(app);
  const Moves moves(app, {1.0, 1.0}, pipelines, 1);
  trial::Place by_time{.period = milliseconds{20}, .phase = milliseconds{4}};
  moves.come_less_often(by_time, 1, 1.5, Millis{20.0});
  EXPECT_EQ(by_time, (trial::Place{.period = milliseconds{30}, .phase = milliseconds{6}}));
  trial::Place missing{.period = milliseconds{2}};
  moves.come_less_often(missing, 1, 1.5, Millis{20.0});
  EXPECT_EQ(missing.period, milliseconds{30}) << "it cannot keep its period now";
  trial::Place by_pause{.period = milliseconds{1}, .pause = milliseconds{2}};
  moves.come_less_often(by_pause, 1, 1.5, Millis{20.0});
  EXPECT_EQ(by_pause.pause, milliseconds{12}) << "of 20 ms the pause is 2";
  trial::Place follower{.period = milliseconds{20}, .after = plan::After{SubchainId(0), 1}};
  moves.come_less_often(follower, 1, 1.5, Millis{100.0});
  EXPECT_EQ(follower, (trial::Place{.period = milliseconds{30}, .after = plan::After{SubchainId(0), 1}}))
      << "held apart as much more as its leader";
}

// d keeps to the display's clock, at its rate e.
class AtTheDisplay : public testing::Test {
 protected:
  AtTheDisplay() {
    graph::AppSpec spec = graph::spec_of({"d", "e", "display"}, {"d display", "e display"});
    graph::node(spec, "display").external = true;
    graph::node(spec, "display").period = graph::At<Nanos>{kTick, {}};
    for (auto rate : {&graph::NodeSpec::min_rate, &graph::NodeSpec::max_rate}) {
      graph::node(spec, "e").*rate = graph::At<Rate>{Rate{100.0}, {}};
    }
    spec.objective = {graph::response("d display", 1.0), graph::response("e display", 1.0)};
    app = graph::build_app(spec).value();
  }
  trial::Place every(double ticks) const {
    return {.period = to_nanos(ticks * to_millis(kTick)),
            .phase = std::chrono::milliseconds{3},
            .clock = app.graph.find_node("display")};
  }

  static constexpr Nanos kTick = std::chrono::milliseconds{10};
  graph::App app;
};

TEST_F(AtTheDisplay, WhoKeepsToAClockComesLessOftenByQuartersOfItsTicksAndAtTheSamePhase) {
  const Pipelines pipelines = no_costs_known(app);
  const Moves moves(app, {1.0, 1.0}, pipelines, 1);
  for (const auto& [ticks, factor, slower] :
       {std::tuple{4.0, 1.06, 4.25}, std::tuple{3.0, 1.25, 3.75}, std::tuple{8.0, 1.06, 8.5}}) {
    trial::Place place = every(ticks);
    moves.come_less_often(place, 0, factor, Millis{15.0});
    EXPECT_EQ(place, every(slower)) << ticks << " times " << factor;
  }
  trial::Place at_each = every(1.0);
  moves.come_less_often(at_each, 0, 1.06, Millis{15.0});
  EXPECT_EQ(at_each, every(1.0)) << "each fifth tick would be left out, for 6 %";
  trial::Place as_before = every(5.0 / 3.0);
  moves.come_less_often(as_before, 0, 1.0, Millis{15.0});
  EXPECT_EQ(as_before, every(5.0 / 3.0));
  trial::Place exact = every(1.0);
  moves.come_less_often(exact, 1, 1.25, Millis{15.0});
  EXPECT_EQ(exact, every(1.0)) << "its rate is asked for";
}

// Beginnings at random phases alone would take a search at run time a minute to find these.
TEST(Moves, OftenBeginSoonAfterATickThatBeginsAChainOrAreDoneBeforeOneThatEndsIt) {
  using std::chrono::milliseconds;
  graph::AppSpec spec = graph::spec_of({"camera", "a", "display"}, {"camera a display"});
  for (const char* name : {"camera", "display"}) {
    graph::node(spec, name).external = true;
    graph::node(spec, name).period = graph::At<Nanos>{milliseconds{50}, {}};
  }
  spec.objective = {graph::response("camera a display", 1.0)};
  const graph::App app = graph::build_app(spec).value();
  const Pipelines pipelines = no_costs_known(app);
  Moves moves(app, {2.0}, pipelines, 1);
  const NodeId camera = *app.graph.find_node("camera");
  moves.know_clocks({camera, *app.graph.find_node("display")});
  Random random(1);
  int placed = 0;
  int soon = 0;
  int just_in_time = 0;
  for (int each = 0; each < 4000; ++each) {
    trial::Schedule schedule{.cores = 1, .subchains = {{.period = milliseconds{50}}}, .frames = {}, .pipelines = {}};
    moves.change(schedule, random);
    const trial::Place& place = schedule.subchains.front();
    if (!place.clock) continue;
    ++placed;
    const double phase = to_millis(place.phase).count();
    const double left = to_millis(place.period).count() - phase;
    if (place.clock == camera && phase <= 0.2) ++soon;
    if (place.clock != camera && left >= 2.0 && left <= 3.0) ++just_in_time;
  }
  EXPECT_GT(placed, 500);
  EXPECT_GT(soon, placed / 6);
  EXPECT_GT(just_in_time, placed / 6);
}

// a and b end at the display, c does not; b's rate is that of every second tick.
RC_GTEST_PROP(MovesProperty, KeepPhasesToKnownClocksAlone, (std::uint64_t seed, bool known)) {
  graph::AppSpec spec = graph::spec_of({"a", "b", "c", "display"}, {"a b display", "c b"});
  graph::node(spec, "display").external = true;
  graph::node(spec, "display").period = graph::At<Nanos>{Nanos{8'333'333}, {}};
  for (auto rate : {&graph::NodeSpec::min_rate, &graph::NodeSpec::max_rate}) {
    graph::node(spec, "b").*rate = graph::At<Rate>{Rate{60.0}, {}};
  }
  spec.objective = {graph::response("a b display", 1.0), graph::response("c b", 1.0)};
  const graph::App app = graph::build_app(spec).value();
  const Pipelines pipelines = no_costs_known(app);
  Moves moves(app, {1.0, 1.0, 1.0}, pipelines, 2);
  const NodeId display = *app.graph.find_node("display");
  if (known) moves.know_clocks({display});
  trial::Schedule schedule{.cores = 2, .subchains = std::vector<trial::Place>(3), .frames = {}, .pipelines = {}};
  for (std::size_t i = 0; i < 3; ++i) {
    schedule.subchains[i].priority = static_cast<int>(i) + 1;
    schedule.subchains[i].period = moves.exact(i) ? moves.shortest_period(i) : Nanos{std::chrono::milliseconds{10}};
  }
  Random random(seed);
  std::array<bool, 3> kept{};
  for (int step = 0; step < 600; ++step) {
    moves.change(schedule, random);
    for (std::size_t i = 0; i < 3; ++i) {
      const trial::Place& place = schedule.subchains[i];
      if (!place.clock) continue;
      kept.at(i) = true;
      RC_ASSERT(!place.pause && !place.after);
      RC_ASSERT(place.phase >= Nanos{0} && place.phase < place.period);
      const std::optional<TickCount> ticks = plan::ticks_of(to_millis(place.period), Millis{8.333333});
      RC_ASSERT(ticks.has_value());
      RC_ASSERT((i == 1 ? *ticks == TickCount{2, 1} : ticks->ticks >= ticks->parts));
    }
  }
  RC_ASSERT(kept == (std::array{known, known, false}));
}

}  // namespace
}  // namespace ctn::planner
