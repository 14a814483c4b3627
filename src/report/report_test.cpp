#include <gmock/gmock.h>

#include <cmath>

#include <nlohmann/json.hpp>

#include "plan/json.h"
#include "record/testing/record_fixture.h"
#include "report/json.h"
#include "report/metrics.h"
#include "report/text.h"

namespace ctn::report {
namespace {

using namespace record::test;
using testing::HasSubstr;

// A plan that says `period` for every subchain and multiples of it for the chains.
plan::Plan plan_of(const graph::App& app, double period) {
  plan::Plan plan;
  plan.planner = "auto";
  plan.objective = 10.0 * period;
  plan.relax_factor = 1.0 + period / 100.0;
  for (std::size_t i = 0; i < app.graph.subchains().size(); ++i) {
    plan::SubchainPlan subchain;
    subchain.cores = {static_cast<int>(i)};
    subchain.period = subchain.execution = subchain.slice = Millis{period};
    subchain.every = 1;
    plan.subchains.push_back(subchain);
    plan::CorePlan core;
    core.frame = Millis{period};
    core.slots.push_back({SubchainId{i}, Millis{0}, Millis{period}, 1, 0});
    plan.cores.push_back(core);
  }
  for (const graph::Term& term : app.objective) {
    if (term.metric == graph::Metric::kPeriod) {
      plan.nodes.push_back({term.path.front(), Millis{period}, term.weight});
    } else {
      plan.chains.push_back({term.path, Millis{3 * period}, Millis{2 * period}, Millis{period}, term.weight});
    }
  }
  return plan;
}

// 20 s from 100 s on, 2 s of them warm-up: scan, LM and LP every 20 ms in the warm-up and every 10 ms after.
void write_run(const std::string& path, const graph::App& app, bool with_plans,
               const std::vector<record::AppChange>& changes = {}) {
  const auto writer = make(path, app);
  const auto id = [&](const char* name) { return *app.graph.find_node(name); };
  Nanos t = seconds{100};
  for (std::uint64_t i = 1; t < seconds{120}; ++i) {
    const TimePoint begin = at(t);
    const Nanos scan = milliseconds{1};
    writer->add(record::Run{id("scan"), i, begin, begin + scan, scan, 0, true, {}});
    writer->add(
        record::Run{id("LM"), i, begin + scan, begin + 3 * scan, milliseconds{2}, 0, true, {{id("scan"), i, i}}});
    record::Run last{id("LP"),           i, begin + 3 * scan, begin + 6 * scan,
                     microseconds{1500}, 0, i % 2 == 0,       {{id("LM"), i, i}}};
    last.wait = microseconds{1250};
    writer->add(last);
    writer->add(record::Trigger{SubchainId{0}, i, begin - microseconds{i % 4}, begin});
    t += t < seconds{102} ? milliseconds{20} : milliseconds{10};
  }
  if (with_plans) {
    writer->add(record::PlanChange{at(seconds{100}), "bootstrap", plan::to_json(plan_of(app, 50.0), app)});
    writer->add(record::PlanChange{at(seconds{102}), "measured", plan::to_json(plan_of(app, 10.0), app)});
    writer->add(record::PlanChange{at(seconds{114}), "periodic", plan::to_json(plan_of(app, 16.0), app)});
  }
  for (const record::AppChange& change : changes) writer->add(change);
  writer->add(record::Notice{at(seconds{103}), "watchdog", "GL is late\x1b[2J<b>"});
  writer->add(record::Notice{at(seconds{104}), "watchdog", "again <script>"});
  ASSERT_TRUE(writer->close(at(seconds{120}), header().host).ok());
}

class ReportTest : public testing::Test {
 protected:
  RunFigures metrics(bool with_plans, bool whole = false) {
    write_run(folder_.file("r"), app_, with_plans);
    auto result = measure(open(folder_.file("r")), {.whole = whole, .worst = 0});
    EXPECT_TRUE(result.ok()) << (result ? "" : result.error().message());
    return std::move(*result);
  }

  RunFigures metrics_without_changes() {
    write_run(folder_.file("other"), app_, false);
    return *measure(open(folder_.file("other")));
  }

  Folder folder_;
  graph::App app_ = robot();
};

TEST_F(ReportTest, MeasuresWhatCameAfterTheWarmUp) {
  const RunFigures run = metrics(true);
  EXPECT_DOUBLE_EQ(run.measured_s, 18.0);
  ASSERT_EQ(run.chains.size(), 2U);
  const ChainMetrics& chain = run.chains.front();
  EXPECT_EQ(chain.path, "scan -> LM -> LP -> base");
  EXPECT_EQ(chain.bound_ms, 60.0);
  // Every second LP emits, so an input is used every 20 ms.
  EXPECT_NEAR(chain.latency_ms.mean, 6.0, 1e-9);
  EXPECT_NEAR(chain.period_ms.max, 20.0, 1e-9) << "the warm-up's 40 ms are left out";
  EXPECT_NEAR(chain.response_ms.p50, 26.0, 1e-9);
  EXPECT_NEAR(static_cast<double>(chain.latency_ms.count), 900.0, 1.0);
}

TEST_F(ReportTest, SaysWhatRunsWaitWhereTheyDo) {
  const RunFigures run = metrics(false);
  const auto document = nlohmann::json::parse(to_json(run));
  for (std::size_t i = 0; i < run.nodes.size(); ++i) {
    const NodeMetrics& node = run.nodes[i];
    EXPECT_EQ(node.wait_ms.has_value(), node.name == "LP") << node.name;
    EXPECT_EQ(document["nodes"][i].contains("wait_ms"), node.name == "LP") << node.name;
    if (!node.wait_ms) continue;
    EXPECT_DOUBLE_EQ(node.wait_ms->mean, 1.25);
    EXPECT_DOUBLE_EQ(node.compute_ms.mean, 1.5);
    EXPECT_DOUBLE_EQ(node.wall_ms.mean, 3.0);
  }
  EXPECT_THAT(to_text(run), HasSubstr("Runs that wait, without using a core"));
}

TEST_F(ReportTest, WeightsAndBoundsAreThoseInForceAtTheEndAndItSaysSo) {
  using What = record::AppChange::What;
  write_run(folder_.file("r"), app_, true,
            {{at(seconds{103}), What::kWeight, 0, 1.0, 2.0},
             {at(seconds{104}), What::kMax, 0, 60.0, 45.0},
             {at(seconds{105}), What::kWeight, 0, 2.0, 4.0}});
  const auto run = measure(open(folder_.file("r")));
  ASSERT_TRUE(run.ok()) << run.error().message();
  EXPECT_EQ(run->chains.front().weight, 4.0);
  EXPECT_EQ(run->chains.front().bound_ms, 45.0);
  EXPECT_THAT(to_text(*run), HasSubstr("weights or bounds were changed while it ran (3 in all, the last after 5.0 s: "
                                       "objective[0].weight (scan -> LM -> LP -> base): 2 -> 4)"));
  EXPECT_EQ(nlohmann::json::parse(to_json(*run))["changes"].size(), 3U);
  EXPECT_TRUE(nlohmann::json::parse(to_json(metrics_without_changes()))["changes"].empty());
}

TEST_F(ReportTest, CountsLateResponsesByCause) {
  const RunFigures within = metrics(true);
  ASSERT_TRUE(within.chains.front().late.has_value());
  EXPECT_EQ(within.chains.front().late->responses, within.chains.front().response_ms.count);
  EXPECT_EQ(within.chains.front().late->late, 0U) << "26 ms each, of a bound of 60";
  EXPECT_EQ(nlohmann::json::parse(to_json(within))["chains"][0]["late"]["causes"], nlohmann::json::object());

  write_run(folder_.file("late"), app_, true, {{at(seconds{103}), record::AppChange::What::kMax, 0, 60.0, 25.0}});
  const auto run = measure(open(folder_.file("late")), {.worst = 2});
  ASSERT_TRUE(run.ok()) << run.error().message();
  const why::Analysis& late = *run->chains.front().late;
  EXPECT_EQ(late.late, late.responses);
  EXPECT_EQ(late.worst.size(), 2U);
  const auto json = nlohmann::json::parse(to_json(*run))["chains"];
  EXPECT_EQ(json[0]["late"]["over_ms"], 25.0);
  EXPECT_EQ(json[0]["late"]["over"], "bound");
  EXPECT_EQ(json[0]["late"]["of"], late.responses);
  std::uint64_t counted = 0;
  for (const auto& count : json[0]["late"]["causes"]) counted += count.get<std::uint64_t>();
  EXPECT_EQ(counted, late.late);
  EXPECT_TRUE(json[1]["late"].is_null()) << "GL never ran";
  EXPECT_THAT(to_text(*run), HasSubstr("what made them late"));

  const auto unasked = measure(open(folder_.file("late")));
  ASSERT_TRUE(unasked.ok());
  EXPECT_FALSE(unasked->chains.front().late.has_value());
  EXPECT_THAT(to_text(*unasked), testing::Not(HasSubstr("what made them late")));
}

TEST_F(ReportTest, MeasuresNodesAndTriggers) {
  const RunFigures run = metrics(true);
  ASSERT_EQ(run.nodes.size(), 5U) << "base is external";
  const NodeMetrics& planner = run.nodes[3];
  EXPECT_EQ(planner.name, "LP");
  EXPECT_NEAR(planner.rate_hz, 100.0, 0.1);
  EXPECT_NEAR(static_cast<double>(planner.outputs) / static_cast<double>(planner.runs), 0.5, 0.01);
  EXPECT_NEAR(planner.cores, 0.15, 0.001);
  EXPECT_NEAR(planner.compute_ms.p95, 1.5, 1e-9);
  EXPECT_NEAR(planner.wall_ms.p95, 3.0, 1e-9);
  EXPECT_NEAR(planner.period_ms.mean, 10.0, 1e-9);
  EXPECT_NEAR(run.cores_used, 0.45, 0.001);
  EXPECT_EQ(run.nodes[4].runs, 0U) << "GL never ran";
  EXPECT_EQ(run.nodes[4].weight, 0.5);
  ASSERT_EQ(run.triggers.size(), 1U);
  EXPECT_EQ(run.triggers.front().subchain, "local");
  EXPECT_NEAR(run.triggers.front().late_ms.mean, 0.0015, 0.0001);
}

TEST_F(ReportTest, AveragesPredictionsOverTheTimeTheyHeld) {
  const RunFigures run = metrics(true);
  EXPECT_EQ(run.plans, 2U) << "the bootstrap's was not in force";
  const double period = (12.0 * 10.0 + 6.0 * 16.0) / 18.0;
  ASSERT_TRUE(run.chains.front().predicted.has_value());
  EXPECT_NEAR(run.chains.front().predicted->response_ms, 3.0 * period, 1e-9);
  EXPECT_NEAR(run.chains.front().predicted->latency_ms, 2.0 * period, 1e-9);
  EXPECT_NEAR(run.chains.front().predicted->period_ms, period, 1e-9);
  EXPECT_NEAR(run.chains.front().predicted->promised_response_ms, 3.0 * period, 1e-9) << "the plans expect the worst";
  EXPECT_NEAR(*run.nodes[1].predicted_rate_hz, (12.0 * 100.0 + 6.0 * 62.5) / 18.0, 1e-9);
  EXPECT_EQ(run.nodes[0].predicted_rate_hz, std::nullopt) << "imu is in no subchain";
  EXPECT_NEAR(*run.objective.predicted, 10.0 * period, 1e-9);
  EXPECT_EQ(run.objective.measured, std::nullopt) << "GL was never measured";
  EXPECT_NEAR(run.relax_factor, 1.16, 1e-9);
}

TEST_F(ReportTest, IncludesTheWarmUpOnDemand) {
  const RunFigures run = metrics(true, true);
  EXPECT_DOUBLE_EQ(run.measured_s, 20.0);
  EXPECT_EQ(run.plans, 3U);
  EXPECT_NEAR(run.chains.front().period_ms.max, 40.0, 1e-9);
}

TEST_F(ReportTest, DoesWithoutPlans) {
  const RunFigures run = metrics(false);
  EXPECT_EQ(run.chains.front().predicted, std::nullopt);
  EXPECT_EQ(run.objective.predicted, std::nullopt);
  EXPECT_THAT(to_text(run), HasSubstr("response time"));
}

TEST_F(ReportTest, SaysThatTheWarmUpWasAllThereIs) {
  {
    const auto writer = make(folder_.file("short"), app_);
    ASSERT_TRUE(writer->close(at(seconds{101}), header().host).ok());
  }
  const auto run = measure(open(folder_.file("short")));
  ASSERT_TRUE(run.ok());
  EXPECT_EQ(run->measured_s, 0.0);
  EXPECT_THAT(to_text(*run), HasSubstr("--all"));
  EXPECT_TRUE(nlohmann::json::accept(to_json(*run)));
}

TEST_F(ReportTest, AnUnreadablePlanIsAnError) {
  {
    const auto writer = make(folder_.file("r"), app_);
    writer->add(record::PlanChange{at(seconds{103}), "measured", "{"});
    ASSERT_TRUE(writer->close(at(seconds{120}), header().host).ok());
  }
  const auto run = measure(open(folder_.file("r")));
  ASSERT_FALSE(run.ok());
  EXPECT_THAT(run.error().message(), HasSubstr("plan 1 of the record"));
}

TEST_F(ReportTest, TextNamesWhatMattersAndNothingControlsTheTerminal) {
  const std::string text = to_text(metrics(true));
  EXPECT_THAT(text, HasSubstr("robot, scheduler catan, real-time levels, CPUs 0,2-3: 18.0 s measured after 2.0 s"));
  EXPECT_THAT(text, HasSubstr("watchdog (2 times"));
  EXPECT_THAT(text, HasSubstr("relaxed by a factor of up to 1.16"));
  EXPECT_EQ(text.find('\x1b'), std::string::npos);
}

TEST_F(ReportTest, SaysWhatPromisesAreFor) {
  auto run = metrics(true);
  EXPECT_EQ(to_text(run).find("typically take"), std::string::npos);
  EXPECT_EQ(nlohmann::json::parse(to_json(run))["promises_for"], "percentile");
  run.for_typical = true;
  EXPECT_THAT(to_text(run), HasSubstr("what is promised is for what runs typically take"));
  EXPECT_EQ(nlohmann::json::parse(to_json(run))["promises_for"], "typical");
}

TEST_F(ReportTest, JsonHoldsTheSameFigures) {
  const RunFigures run = metrics(true);
  const auto json = nlohmann::json::parse(to_json(run));
  EXPECT_EQ(json["chains"][0]["response_ms"]["mean"], run.chains[0].response_ms.mean);
  EXPECT_EQ(json["chains"][0]["predicted"]["response_ms"], run.chains[0].predicted->response_ms);
  EXPECT_TRUE(json["chains"][1]["response_ms"].is_null());
  EXPECT_EQ(json["nodes"][3]["cores"], run.nodes[3].cores);
  EXPECT_EQ(json["cpus"], nlohmann::json::parse("[0, 2, 3]"));
  EXPECT_EQ(json["notices"].size(), 2U);
}

}  // namespace
}  // namespace ctn::report
