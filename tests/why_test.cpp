// Causes put into simulated runs on purpose, and whether they are the ones named; and how much of what responses took
// is explained, of the case studies under several policies.
#include "why/why.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <functional>
#include <memory>
#include <optional>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include "config/testing/apps.h"
#include "policy/policy.h"
#include "record/reader.h"
#include "sim/simulation.h"
#include "sim/testing/outcomes.h"

namespace ctn {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using why::CauseKind;

constexpr int kInjected = 20;

// scan -> LM -> LP every 20 ms at a hand-set rate; see, an unscheduled node.
constexpr const char* kRobot = R"(
catan: 1
app: robot
nodes: { scan: { fallback_rate: 50Hz }, LM: {}, LP: {}, see: { unscheduled: true, period: 100ms } }
edges: [ scan -> LM -> LP ]
subchains: { local: [scan, LM, LP] }
objective: [ { response_time: [scan, LM, LP], weight: 1, max: 31ms } ]
scheduler: { slack: 0%, bootstrap: 1s }
)";

// scan 2, LM 3, LP 4, see 0.1 ms, but for what is put in on purpose: into every 50th run of a node.
class OnPurpose : public sim::RunCosts {
 public:
  struct Odd {
    std::string node;
    Nanos cpu{0};
    Nanos wait{0};
    std::uint64_t each = 50;
  };
  OnPurpose(const graph::App& app, Odd odd) : app_(app), odd_(std::move(odd)) {}
  int threads_used(NodeId /*node*/, int /*max*/) const override { return 1; }
  model::RunDraw draw(NodeId node, std::uint64_t number, Nanos /*since_start*/, int /*threads*/,
                      std::size_t /*kind*/) override {
    const std::string& name = app_.graph.node(node).name;
    model::RunDraw draw;
    draw.cpu = name == "scan" ? milliseconds{2} : name == "LM" ? milliseconds{3} : milliseconds{4};
    if (name == "see") draw.cpu = std::chrono::microseconds{100};
    if (name == odd_.node && number % odd_.each == 0) {
      draw.cpu += odd_.cpu;
      draw.wait = odd_.wait;
    }
    return draw;
  }

 private:
  const graph::App& app_;
  Odd odd_;
};

// The record of a run, which goes with it.
class Recorded {
 public:
  Recorded() : path_(testing::TempDir() + fmt::format("why_{}_{}.catan", getpid(), ++count())) {
    std::remove(path_.c_str());
  }
  ~Recorded() { std::remove(path_.c_str()); }
  Recorded(const Recorded&) = delete;
  Recorded& operator=(const Recorded&) = delete;
  const std::string& path() const { return path_; }
  record::Reader open() const {
    auto record = record::Reader::open(path_);
    if (!record) ADD_FAILURE() << record.error().message();
    return std::move(*record);
  }

 private:
  static int& count() {
    static int count = 0;
    return count;
  }
  std::string path_;
};

using Prepare = std::function<void(sim::Simulation&)>;

// Of each term; empty where it failed.
std::vector<why::Analysis> analyses_of(const graph::App& app, std::unique_ptr<sim::RunCosts> costs,
                                       sim::Options options, Nanos measured, const std::vector<std::size_t>& terms,
                                       const Prepare& prepare = {}) {
  const Recorded recorded;
  options.recording = {.path = recorded.path(), .note = {}};
  auto simulation = sim::Simulation::create(app, std::move(costs), std::move(options));
  if (!simulation) {
    ADD_FAILURE() << simulation.error().message();
    return {};
  }
  if (prepare) prepare(**simulation);
  (*simulation)->run_for((*simulation)->warm_from() - TimePoint{} + measured);
  const Status finished = (*simulation)->finish();
  EXPECT_TRUE(finished.ok());
  auto analyses = why::analyse(recorded.open(), terms, {.worst = 1'000'000});
  if (!analyses) {
    ADD_FAILURE() << analyses.error().message();
    return {};
  }
  return std::move(*analyses);
}

why::Analysis analysis_of(const graph::App& app, std::unique_ptr<sim::RunCosts> costs, sim::Options options,
                          Nanos measured, std::size_t term = 0, const Prepare& prepare = {}) {
  const auto analyses = analyses_of(app, std::move(costs), std::move(options), measured, {term}, prepare);
  return analyses.empty() ? why::Analysis() : analyses.front();
}

std::uint64_t count(const why::Analysis& analysis, CauseKind kind) {
  return analysis.causes[static_cast<std::size_t>(kind)];
}

std::string counted(const why::Analysis& analysis) {
  std::string text = fmt::format("{} late;", analysis.late);
  for (std::size_t kind = 0; kind < why::kCauseKinds; ++kind) {
    if (analysis.causes[kind] > 0) {
      text += fmt::format(" {} {}", why::to_string(static_cast<CauseKind>(kind)), analysis.causes[kind]);
    }
  }
  return text;
}

// All late responses are due to that, of that node, and there is one for each that was put in.
void expect_all(const why::Analysis& analysis, CauseKind kind, NodeId node, std::optional<NodeId> by = {}) {
  EXPECT_GE(analysis.late, static_cast<std::uint64_t>(kInjected)) << counted(analysis);
  EXPECT_EQ(count(analysis, kind), analysis.late) << counted(analysis);
  for (const why::Response& response : analysis.worst) {
    if (!response.late) continue;
    if (!by) {
      EXPECT_EQ(response.cause->node, node);
    }
    EXPECT_EQ(response.cause->by, by);
  }
}

constexpr Nanos kForAll = seconds{kInjected + 1};  // every 50th run at 50 Hz is one a second

sim::Options under(const std::string& policy, int cores = 1) {
  return sim::on_ideal_machine(*policy::make_policy(policy), cores);
}

TEST(WhyInjected, LongRuns) {
  const graph::App app = parse(kRobot);
  for (const char* policy : {"default", "fifo"}) {
    for (const char* node : {"scan", "LM", "LP"}) {
      const auto analysis = analysis_of(app, std::make_unique<OnPurpose>(app, OnPurpose::Odd{node, milliseconds{8}}),
                                        under(policy), kForAll);
      expect_all(analysis, CauseKind::kLongRun, *app.graph.find_node(node));
    }
  }
}

// Runs so long that they hold up the ones after them.
TEST(WhyInjected, LongRunsThatDelayTheNextToo) {
  const graph::App app = parse(kRobot);
  const auto analysis = analysis_of(app, std::make_unique<OnPurpose>(app, OnPurpose::Odd{"LM", milliseconds{30}}),
                                    under("fifo"), kForAll);
  EXPECT_GE(count(analysis, CauseKind::kLongRun), static_cast<std::uint64_t>(kInjected)) << counted(analysis);
}

TEST(WhyInjected, WaitsForADevice) {
  const graph::App app = parse(kRobot);
  for (const char* policy : {"default", "fifo"}) {
    const auto analysis = analysis_of(
        app, std::make_unique<OnPurpose>(app, OnPurpose::Odd{"LM", Nanos{0}, milliseconds{8}}), under(policy), kForAll);
    expect_all(analysis, CauseKind::kDevice, *app.graph.find_node("LM"));
  }
}

TEST(WhyInjected, PreEmptions) {
  const graph::App app = parse(kRobot);
  const NodeId see = *app.graph.find_node("see");
  const auto analysis =
      analysis_of(app, std::make_unique<OnPurpose>(app, OnPurpose::Odd{"see", milliseconds{8}, Nanos{0}, 10}),
                  under("fifo"), kForAll);
  expect_all(analysis, CauseKind::kPreEmpted, *app.graph.find_node("scan"), see);
}

TEST(WhyInjected, OutputsThatAreLeftOut) {
  const graph::App app = parse(kRobot);
  for (const char* node : {"scan", "LM", "LP"}) {
    const NodeId left_out = *app.graph.find_node(node);
    const auto analysis = analysis_of(app, std::make_unique<OnPurpose>(app, OnPurpose::Odd{}), under("fifo"), kForAll,
                                      0, [&](sim::Simulation& simulation) {
                                        simulation.set_effect(left_out, [](ctn::Run& run) {
                                          if (run.number() % 50 == 0) run.skip_output();
                                        });
                                      });
    expect_all(analysis, CauseKind::kNoOutput, left_out);
  }
}

// An ordinary thread of another program gets half of the core for some time.
TEST(WhyInjected, AHog) {
  const graph::App app = parse(kRobot);
  sim::Options options = under("default");
  options.machine.background.push_back({0, milliseconds{20}, milliseconds{1010}});
  const auto analysis =
      analysis_of(app, std::make_unique<OnPurpose>(app, OnPurpose::Odd{}), std::move(options), kForAll);
  EXPECT_GE(analysis.late, static_cast<std::uint64_t>(kInjected)) << counted(analysis);
  EXPECT_EQ(count(analysis, CauseKind::kStarved), analysis.late) << counted(analysis);
}

// By hand: one subchain with a fixed priority, every 20 ms.
plan::Plan plan_with_phase(const graph::App& app, Millis phase) {
  plan::Plan plan;
  plan.planner = "by hand";
  plan::SubchainPlan local;
  local.cores = {0};
  local.period = Millis{20};
  local.execution = local.slice = Millis{9};
  local.every = 1;
  plan.subchains = {local};
  plan::CorePlan core;
  core.form = plan::Form::kPriorities;
  core.members = {{SubchainId{0}, 1, Millis{20}, phase, {}, {}, {}, Millis{20}}};
  plan.cores = {core};
  plan.chains = {{app.objective.front().path, Millis{29}, Millis{9}, Millis{20}, 1.0}};
  return plan;
}

// Plans that differ in nothing but their phases: each swap makes the next trigger come up to half a period later.
TEST(WhyInjected, PlanSwaps) {
  const graph::App app = parse(kRobot);
  sim::Options options = under("catan");
  constexpr int kSwaps = 2 * kInjected + 4;  // every second one brings the next trigger later
  for (int swap = 0; swap <= kSwaps; ++swap) {
    options.plans.push_back({seconds{swap}, plan_with_phase(app, Millis{swap % 2 == 0 ? 0.0 : 8.0})});
  }
  const auto analysis =
      analysis_of(app, std::make_unique<OnPurpose>(app, OnPurpose::Odd{}), std::move(options), seconds{kSwaps});
  EXPECT_GE(analysis.late, static_cast<std::uint64_t>(kInjected)) << counted(analysis);
  EXPECT_EQ(count(analysis, CauseKind::kPlanChange), analysis.late) << counted(analysis);
}

// Its timer is due, but an ordinary thread of another program has the core.
constexpr const char* kSensor = R"(
catan: 1
app: sensor
nodes: { see: { unscheduled: true, period: 20ms }, scan: { fallback_rate: 50Hz } }
edges: [ see -> scan ]
objective: [ { response_time: [see], weight: 1, max: 21ms }, { period: scan, weight: 1 } ]
scheduler: { slack: 0%, bootstrap: 1s }
)";

TEST(WhyInjected, LateTimers) {
  const graph::App app = parse(kSensor);
  const NodeId see = *app.graph.find_node("see");
  sim::Options options = under("default");
  options.phases.nodes.resize(app.graph.nodes().size());
  options.phases.nodes[see.index()] = milliseconds{1};
  options.phases.subchains = {milliseconds{10}};
  options.machine.background.push_back({0, std::chrono::microseconds{2900}, seconds{1}});  // within one slice
  const auto analysis =
      analysis_of(app, std::make_unique<OnPurpose>(app, OnPurpose::Odd{}), std::move(options), kForAll);
  expect_all(analysis, CauseKind::kLateTimer, see);
}

// What it logs goes to a disk that is slow now and then; so the subchain is not done when its next trigger is due.
constexpr const char* kLogs = R"(
catan: 1
app: logs
nodes: { scan: { fallback_rate: 50Hz }, LM: {}, LP: {} }
edges: [ scan -> LM -> LP ]
subchains: { local: [scan, LM, LP] }
objective: [ { response_time: [scan, LM], weight: 1, max: 27ms } ]
scheduler: { slack: 0%, bootstrap: 1s }
)";

TEST(WhyInjected, ASlowWriterThatKeepsItsSubchainBusy) {
  const graph::App app = parse(kLogs);
  sim::Options options = under("catan");
  options.plans = {{Nanos{0}, plan_with_phase(app, Millis{0})}};
  const auto analysis =
      analysis_of(app, std::make_unique<OnPurpose>(app, OnPurpose::Odd{"LP", Nanos{0}, milliseconds{25}}),
                  std::move(options), kForAll);
  expect_all(analysis, CauseKind::kOwnPreviousRun, *app.graph.find_node("scan"));
}

// Two subchains that take turns on a core; long runs of the first go on in the slots of the other. Of chains without
// bounds one response in a hundred is late: those that are put in on purpose are fewer.
constexpr const char* kTurns = R"(
catan: 1
app: turns
nodes: { scan: {}, LM: {}, LP: {} }
edges: [ scan -> LM, scan -> LP ]
subchains: { fast: [scan, LM], slow: [LP] }
objective:
  - { response_time: [scan, LM], weight: 1 }
  - { response_time: [LP], weight: 0.5 }
order: [fast, slow]
steal: { priority: [fast, slow], off: [] }
scheduler: { slack: 0%, bootstrap: 1s }
)";

TEST(WhyInjected, StolenSlots) {
  const graph::App app = in_frames(parse(kTurns));
  const auto analysis =
      analysis_of(app, std::make_unique<OnPurpose>(app, OnPurpose::Odd{"LM", milliseconds{3}, Nanos{0}, 300}),
                  under("catan"), seconds{60}, 1);
  ASSERT_GE(analysis.late, static_cast<std::uint64_t>(kInjected)) << counted(analysis);
  for (std::size_t worst = 0; worst < kInjected; ++worst) {
    EXPECT_EQ(analysis.worst[worst].cause->kind, CauseKind::kStolen) << worst << ": " << counted(analysis);
  }
}

TEST(WhyInjected, LongRunsOfOneThatTakesTurns) {
  const graph::App app = in_frames(parse(kTurns));
  const auto analysis =
      analysis_of(app, std::make_unique<OnPurpose>(app, OnPurpose::Odd{"LP", milliseconds{3}, Nanos{0}, 250}),
                  under("catan"), seconds{60}, 1);
  EXPECT_GE(analysis.late, static_cast<std::uint64_t>(kInjected)) << counted(analysis);
  EXPECT_EQ(count(analysis, CauseKind::kLongRun), analysis.late) << counted(analysis);
}

// A plan that gives the other subchain a slot in every 50th frame: then the first one waits for its own.
TEST(WhyInjected, WaitsForASlot) {
  const graph::App app = parse(R"(
catan: 1
app: turns
nodes: { scan: {}, LM: {}, LP: {} }
edges: [ scan -> LM, scan -> LP ]
subchains: { fast: [scan, LM], slow: [LP] }
objective:
  - { response_time: [scan, LM], weight: 1, max: 12ms }
  - { period: LP, weight: 0.5 }
order: [fast, slow]
steal: { priority: [fast, slow], off: [] }
scheduler: { slack: 0%, bootstrap: 1s }
)");
  plan::Plan plan;
  plan.planner = "by hand";
  plan.subchains.resize(2);
  plan.subchains[0] = {{0}, Millis{5}, Millis{5}, 1, 1.0, Millis{5}, 1};
  plan.subchains[1] = {{0}, Millis{254}, Millis{4}, 50, 1.0, Millis{4}, 1};
  plan::CorePlan core;
  core.frame = Millis{9};
  core.slots = {{SubchainId{0}, Millis{0}, Millis{5}, 1, 0}, {SubchainId{1}, Millis{5}, Millis{4}, 50, 0}};
  plan.cores = {core};
  plan.chains = {{app.objective.front().path, Millis{14}, Millis{5}, Millis{5}, 1.0}};
  plan.nodes = {{*app.graph.find_node("LP"), Millis{254}, 0.5}};
  sim::Options options = under("catan");
  options.plans = {{Nanos{0}, plan}};
  const auto analysis =
      analysis_of(app, std::make_unique<OnPurpose>(app, OnPurpose::Odd{}), std::move(options), seconds{6});
  expect_all(analysis, CauseKind::kWaitedForSlot, *app.graph.find_node("scan"));
}

struct Study {
  const char* app;
  const char* policy;
  int cores;

  friend void PrintTo(const Study& study, std::ostream* out) {
    *out << fmt::format("{} under {} on {}", study.app, study.policy, study.cores);
  }
};

class WhyExplains : public ::testing::TestWithParam<Study> {};

// At most 2 % is unexplained in 99 % of the responses.
TEST_P(WhyExplains, NearlyAll) {
  const std::string files = std::string(CATAN_CASES) + "/" + GetParam().app;
  const graph::App app = config::load_app(files + ".yaml").value();
  const model::Workload work = config::load_workload(files + ".load.yaml", app).value();
  sim::Options options{.policy = *policy::make_policy(GetParam().policy)};
  options.machine.cores = GetParam().cores;
  const std::vector<std::size_t> chains = why::chains_of(app);
  const auto analyses =
      analyses_of(app, std::make_unique<sim::DrawnCosts>(app, work, 1), std::move(options), seconds{20}, chains);
  ASSERT_EQ(analyses.size(), chains.size());
  for (const why::Analysis& analysis : analyses) {
    ASSERT_GT(analysis.responses, 0U);
    for (const why::Response& response : analysis.worst) {
      TimePoint now = response.begin;
      for (const why::Part& part : response.parts) {
        ASSERT_EQ(part.begin, now);
        now = part.end;
      }
      ASSERT_EQ(now, response.end);
    }
    const double explained = static_cast<double>(analysis.explained) / static_cast<double>(analysis.responses);
    RecordProperty("explained_" + std::to_string(analysis.term), std::to_string(explained));
    EXPECT_GE(explained, 0.99) << "objective[" << analysis.term << "], " << analysis.responses << " responses, "
                               << counted(analysis);
  }
}

INSTANTIATE_TEST_SUITE_P(Why, WhyExplains,
                         ::testing::Values(Study{"navigation", "catan", 1}, Study{"navigation", "catan", 2},
                                           Study{"navigation", "paper", 2}, Study{"navigation", "default", 1},
                                           Study{"navigation", "default", 2}, Study{"vr", "catan", 1},
                                           Study{"vr", "catan", 2}, Study{"vr", "paper", 1}, Study{"vr", "paper", 2},
                                           Study{"vr", "default", 1}),
                         [](const auto& study) {
                           return std::string(study.param.app) + "_" + study.param.policy + "_" +
                                  std::to_string(study.param.cores);
                         });

}  // namespace
}  // namespace ctn
