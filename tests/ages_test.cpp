// How old the data is that runs work on: live, simulated and from a record, for one app. Sensors stop giving output now
// and then, so that what rests on them grows old.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "config/cost_file.h"
#include "config/testing/apps.h"
#include "os/fake/fake_os.h"
#include "report/json.h"
#include "report/metrics.h"
#include "report/text.h"
#include "runtime/engine.h"
#include "sim/json.h"
#include "sim/simulation.h"

namespace ctn {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using testing::ElementsAre;
using testing::HasSubstr;

std::string record_path(const char* name) {
  const std::string path = testing::TempDir() + fmt::format("ages_{}_{}.catan", name, getpid());
  std::remove(path.c_str());
  return path;
}

record::Reader read(const std::string& path) {
  auto record = record::Reader::open(path);
  EXPECT_TRUE(record.ok()) << record.error().message();
  return std::move(*record);
}

std::vector<std::string> stale_notices(const record::Reader& record) {
  std::vector<std::string> told;
  for (const record::Notice& notice : *record.notices()) {
    if (notice.kind == "stale-input") told.push_back(notice.detail);
  }
  return told;
}

// imu gives output at 4, 14, 24 ms and so on (its runs take a millisecond); look reads it at 7, 27, 47, when it is 4 ms
// old, and act goes on with it 2 ms later. Runs 201 to 210 of imu, from 2003 to 2093 ms, give none: so the runs of look
// at 2007 to 2087 have data of 14, 34, 54, 74 and 94 ms.
class StoppedSensor : public ::testing::TestWithParam<bool> {
 protected:
  static graph::App app(const char* limit) {
    return parse(fmt::format(R"(
catan: 1
app: sampled
nodes: {{ imu: {{ unscheduled: true, period: 10ms }}, look: {{ fallback_rate: 50Hz }}, act: {{}} }}
edges:
  - {{ path: imu -> look, {} }}
  - {{ path: look -> act, max_age: 50ms }}
subchains: {{ reflex: [look, act] }}
objective: [ {{ response_time: [imu, look, act], weight: 1 }} ]
scheduler: {{ bootstrap: 1s }}
)",
                             limit));
  }
  static bool gives(std::uint64_t number) { return number < 201 || number > 210; }

  sim::Outcome simulate(const graph::App& app) {
    path = record_path("stopped");
    sim::Options options{.policy = *policy::make_policy("default")};
    options.machine.costs = sim::MachineCosts::none();
    options.phases = {.nodes = {milliseconds{3}, Nanos{0}, Nanos{0}}, .subchains = {milliseconds{7}}};
    options.recording = {.path = path, .note = {}};
    const model::Workload work = *config::parse_workload("imu: 1ms\nlook: 2ms\nact: 1ms\n", "costs.yaml", app);
    auto simulation = *sim::Simulation::create(app, std::make_unique<sim::DrawnCosts>(app, work, 1), options);
    const auto id = [&](const char* name) { return *app.graph.find_node(name); };
    auto* const values = GetParam() ? &simulation->channel<int>(id("imu"), id("look")) : nullptr;
    simulation->set_body(id("imu"), [&, values](ctn::Run& run) {
      if (!gives(run.number())) run.skip_output();
      if (values != nullptr) values->write(run, 1);
    });
    simulation->set_body(id("look"), [&, values](ctn::Run& run) {
      const Nanos age = run.age("imu");
      if (simulation->now() >= simulation->warm_from() && age > milliseconds{4}) old.push_back(age);
      if (run.stale()) ++called_with_stale;
      if (values != nullptr) static_cast<void>(values->read(run));
    });
    simulation->run_for(seconds{5});
    EXPECT_TRUE(simulation->finish().ok());
    return simulation->outcome();
  }
  ~StoppedSensor() override { std::remove(path.c_str()); }

  std::string path;
  std::vector<Nanos> old;
  int called_with_stale = 0;
};

TEST_P(StoppedSensor, IsCountedAndToldToTheMillisecond) {
  const sim::Outcome outcome = simulate(app("max_age: 50ms"));
  EXPECT_THAT(old,
              ElementsAre(milliseconds{14}, milliseconds{34}, milliseconds{54}, milliseconds{74}, milliseconds{94}));
  EXPECT_EQ(called_with_stale, 3);
  ASSERT_EQ(outcome.ages.size(), 2U);
  const AgeSnapshot& of_look = outcome.ages[0];
  EXPECT_EQ(of_look.from + " -> " + of_look.to, "imu -> look");
  EXPECT_EQ(of_look.max_age_ms, 50.0);
  EXPECT_FALSE(of_look.skips);
  EXPECT_EQ(of_look.stale, 3U);
  EXPECT_EQ(of_look.runs, outcome.nodes[1].runs);
  EXPECT_DOUBLE_EQ(of_look.age_ms.max, 94.0);
  EXPECT_NEAR(of_look.age_ms.p50, 4.0, 0.01) << "a percentile is from a histogram";
  EXPECT_EQ(outcome.ages[1].stale, 3U) << "act begins 2 ms later: 16, 36, 56, 76, 96";
  EXPECT_DOUBLE_EQ(outcome.ages[1].age_ms.max, 96.0);
  EXPECT_EQ(outcome.nodes[2].runs, outcome.nodes[1].runs);
  const std::vector<std::string> told = stale_notices(read(path));
  EXPECT_THAT(told, ElementsAre("what look takes from imu is 54 ms old, its max_age is 50 ms",
                                "what act takes from look is 56 ms old, its max_age is 50 ms",
                                "what look takes from imu is no older than its max_age of 50 ms again; 3 runs had "
                                "older data, the oldest of 94 ms",
                                "what act takes from look is no older than its max_age of 50 ms again; 3 runs had "
                                "older data, the oldest of 96 ms"));
  for (const std::string& notice : told) EXPECT_THAT(outcome.notices, testing::Contains("stale-input: " + notice));
}

TEST_P(StoppedSensor, SkippedOutputReachesNobody) {
  const sim::Outcome outcome = simulate(app("max_age: 50ms, on_stale: skip"));
  EXPECT_EQ(called_with_stale, 3) << "the function is called all the same";
  EXPECT_TRUE(outcome.ages[0].skips);
  EXPECT_EQ(outcome.ages[0].stale, 3U);
  EXPECT_EQ(outcome.nodes[1].runs - outcome.nodes[1].outputs, 3U);
  EXPECT_EQ(outcome.nodes[2].runs, outcome.nodes[1].outputs) << "act does not act on it";
  EXPECT_EQ(outcome.ages[1].stale, 0U);
  EXPECT_EQ(stale_notices(read(path)).front(),
            "what look takes from imu is 54 ms old, its max_age is 50 ms: such runs give no output");
}

// What the report finds in runs and what they consumed is what the simulator carried along.
TEST_P(StoppedSensor, TheRecordSaysTheSame) {
  const sim::Outcome outcome = simulate(app("max_age: 50ms"));
  const auto metrics = report::measure(read(path));
  ASSERT_TRUE(metrics.ok()) << metrics.error().message();
  ASSERT_EQ(metrics->ages.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(metrics->ages[i].runs, outcome.ages[i].runs);
    EXPECT_EQ(metrics->ages[i].stale, outcome.ages[i].stale);
    EXPECT_NEAR(metrics->ages[i].age_ms.mean, outcome.ages[i].age_ms.mean, 1e-9);
    EXPECT_EQ(metrics->ages[i].age_ms.max, outcome.ages[i].age_ms.max);
  }
  EXPECT_THAT(report::to_text(*metrics), HasSubstr("imu -> look"));
  const auto reported = nlohmann::json::parse(report::to_json(*metrics))["ages"][0];
  const auto simulated = nlohmann::json::parse(sim::to_json({{1, outcome}}, 1))["runs"][0]["ages"][0];
  for (const auto& json : {reported, simulated}) {
    EXPECT_EQ(json["from"], "imu");
    EXPECT_EQ(json["to"], "look");
    EXPECT_EQ(json["max_age_ms"], 50.0);
    EXPECT_EQ(json["on_stale"], "run");
    EXPECT_EQ(json["stale"], 3);
    EXPECT_EQ(json["runs"], outcome.ages[0].runs);
    EXPECT_EQ(json["age_ms"]["max"], 94.0);
  }
}

INSTANTIATE_TEST_SUITE_P(Values, StoppedSensor, testing::Bool(), [](const auto& with_channel) {
  return std::string(with_channel.param ? "OverAChannel" : "WithoutAChannel");
});

// A robot whose scan stops for half a second every two seconds, and whose map is slow: on the runtime and in the
// simulator.
const char* const kRobot = R"(
catan: 1
app: robot
nodes:
  scan: { fallback_rate: 50Hz }
  steer: { fallback_rate: 50Hz }
  map: { fallback_rate: 5Hz }
  log: { input: queue, fallback_rate: 20Hz }
edges:
  - { path: scan -> steer, max_age: 60ms, on_stale: skip }
  - scan -> map
  - { path: map -> steer, max_age: 250ms }
  - { path: scan -> log, max_age: 55ms }
objective:
  - { response_time: [scan, steer], weight: 1 }
  - { response_time: [map, steer], weight: 0.05 }
  - { period: log, weight: 0.05 }
scheduler: { bootstrap: 1s }
)";
const char* const kCosts =
    "scan: 2ms\nsteer: { cost: 4ms, typical: 3ms }\nmap: { cost: 40ms, typical: 30ms }\nlog: 2ms\n";
constexpr std::uint64_t kSeed = 3;
constexpr Nanos kMeasured = seconds{30};

class AgesOnBoth : public ::testing::TestWithParam<std::tuple<const char*, bool>> {
 protected:
  struct Opened {
    Channel<int>* to_steer = nullptr;
    Channel<int>* to_map = nullptr;
    Channel<int>* map_to_steer = nullptr;
    QueueChannel<int>* to_log = nullptr;
  };

  // What each does, over channels or without.
  template <class Wire>
  void wire(Wire&& wire, const Opened& channels) const {
    wire("scan",
         [this, to_steer = channels.to_steer, to_map = channels.to_map, to_log = channels.to_log](ctn::Run& run) {
           const std::int64_t phase = (now() - TimePoint{}).count() % Nanos{seconds{2}}.count();
           if (phase > Nanos{milliseconds{1500}}.count()) run.skip_output();
           if (to_steer == nullptr) return;
           to_steer->write(run, 1);
           to_map->write(run, 1);
           to_log->write(run, 1);
         });
    wire("map", [to_map = channels.to_map, map_to_steer = channels.map_to_steer](ctn::Run& run) {
      if (to_map == nullptr) return;
      static_cast<void>(to_map->read(run));
      map_to_steer->write(run, 1);
    });
    wire("steer", [to_steer = channels.to_steer, map_to_steer = channels.map_to_steer](ctn::Run& run) {
      if (to_steer == nullptr) return;
      static_cast<void>(to_steer->read(run));
      static_cast<void>(map_to_steer->read(run));
    });
    wire("log", [to_log = channels.to_log](ctn::Run& run) {
      if (to_log == nullptr) return;
      while (to_log->take(run)) {
      }
    });
  }

  Snapshot run(const std::string& path) {
    os::FakeOs fake{os::fake_topology(2)};
    fake.share_cpus(true);
    now = [&fake] { return fake.now(); };
    auto engine = *runtime::Engine::create(
        app, fake, {.policy = policy, .cpus = os::CpuSet{0}, .record = path, .note = {}, .on_notice = {}});
    const auto open = [&]<class C>(C*& channel, const char* from, const char* to, bool queue) {
      channel = static_cast<C*>(&engine->wiring().open_channel(from, to, queue, typeid(C), make_channel<C>));
    };
    Opened opened;
    if (std::get<1>(GetParam())) {
      open(opened.to_steer, "scan", "steer", false);
      open(opened.to_map, "scan", "map", false);
      open(opened.map_to_steer, "map", "steer", false);
      open(opened.to_log, "scan", "log", true);
    }
    wire(
        [&](const char* name, std::function<void(ctn::Run&)> body) {
          const NodeId node = *app.graph.find_node(name);
          engine->wiring().set_body(name, [&fake, node, body, this](ctn::Run& run) {
            body(run);
            fake.burn(work.draw(kSeed, node, run.number(), Nanos{0}).cpu);
          });
        },
        opened);
    const Status started = engine->start();
    EXPECT_TRUE(started.ok()) << (started ? "" : started.error().message());
    fake.sleep_until(fake.now() + app.scheduler.bootstrap + policy::kSettle + kMeasured);
    EXPECT_TRUE(engine->stop().ok());
    return engine->snapshot();
  }

  sim::Outcome simulate() {
    sim::Options options{.policy = policy};
    options.machine.costs = sim::MachineCosts::none();
    options.machine.limit.reset();
    auto simulation =
        *sim::Simulation::create(app, std::make_unique<sim::DrawnCosts>(app, work, kSeed), std::move(options));
    now = [&simulation] { return simulation->now(); };
    const auto id = [&](const char* name) { return *app.graph.find_node(name); };
    Opened opened;
    if (std::get<1>(GetParam())) {
      opened = {&simulation->channel<int>(id("scan"), id("steer")), &simulation->channel<int>(id("scan"), id("map")),
                &simulation->channel<int>(id("map"), id("steer")), &simulation->queue<int>(id("scan"), id("log"))};
    }
    wire(
        [&](const char* name, std::function<void(ctn::Run&)> body) { simulation->set_body(id(name), std::move(body)); },
        opened);
    simulation->run_for(simulation->warm_from() - TimePoint{} + kMeasured);
    return simulation->outcome();
  }

  const graph::App app = in_frames(parse(kRobot));
  const model::Workload work = *config::parse_workload(kCosts, "costs.yaml", app);
  const std::shared_ptr<const policy::Policy> policy = *policy::make_policy(std::get<0>(GetParam()));
  std::function<TimePoint()> now;
};

TEST_P(AgesOnBoth, TheSimulatorCountsAboutWhatTheRuntimeDoes) {
  const std::string path = record_path("both");
  const Snapshot ran = run(path);
  const sim::Outcome simulated = simulate();
  std::remove(path.c_str());
  ASSERT_EQ(ran.ages.size(), 3U);
  ASSERT_EQ(simulated.ages.size(), 3U);
  for (std::size_t i = 0; i < ran.ages.size(); ++i) {
    const AgeSnapshot& real = ran.ages[i];
    const AgeSnapshot& virtual_one = simulated.ages[i];
    const std::string edge = real.from + " -> " + real.to;
    EXPECT_EQ(virtual_one.from + " -> " + virtual_one.to, edge);
    EXPECT_GT(real.stale, 20U) << edge;
    EXPECT_LT(real.stale, real.runs) << edge;
    EXPECT_NEAR(static_cast<double>(virtual_one.runs), static_cast<double>(real.runs),
                0.05 * static_cast<double>(real.runs))
        << edge;
    EXPECT_NEAR(static_cast<double>(virtual_one.stale) / static_cast<double>(virtual_one.runs),
                static_cast<double>(real.stale) / static_cast<double>(real.runs), 0.03)
        << edge;
    EXPECT_NEAR(virtual_one.age_ms.mean, real.age_ms.mean, 0.08 * real.age_ms.mean) << edge;
  }
}

// Live, each output carries what it goes back to; afterwards, the record's runs are followed back. Neither knows of the
// other.
TEST_P(AgesOnBoth, TheRecordOfALiveRunSaysWhatItsSnapshotDid) {
  const std::string path = record_path("live");
  const Snapshot ran = run(path);
  const auto metrics = report::measure(read(path));
  ASSERT_TRUE(metrics.ok()) << metrics.error().message();
  std::remove(path.c_str());
  ASSERT_EQ(ran.ages.size(), metrics->ages.size());
  for (std::size_t i = 0; i < ran.ages.size(); ++i) {
    const AgeSnapshot& live = ran.ages[i];
    const AgeSnapshot& reported = metrics->ages[i];
    EXPECT_EQ(live.from + live.to, reported.from + reported.to);
    EXPECT_EQ(live.max_age_ms, reported.max_age_ms);
    EXPECT_EQ(live.skips, reported.skips);
    EXPECT_GT(live.stale, 0U);
    EXPECT_EQ(live.runs, reported.runs) << live.from << live.to;
    EXPECT_EQ(live.stale, reported.stale) << live.from << live.to;
    EXPECT_EQ(live.age_ms.max, reported.age_ms.max) << live.from << live.to;
    EXPECT_NEAR(live.age_ms.mean, reported.age_ms.mean, 1e-6) << live.from << live.to;
  }
  const auto of = [&](const char* name) {
    return *std::find_if(metrics->nodes.begin(), metrics->nodes.end(),
                         [&](const auto& node) { return node.name == name; });
  };
  EXPECT_EQ(of("steer").runs - of("steer").outputs, ran.ages[0].stale)
      << "stale runs gave no output, and all others did";
  EXPECT_THAT(ran.notices, testing::Contains(HasSubstr("what steer takes from scan is")));
}

INSTANTIATE_TEST_SUITE_P(Policies, AgesOnBoth,
                         testing::Combine(testing::Values("default", "fifo", "catan"), testing::Bool()),
                         [](const auto& which) {
                           return std::string(std::get<0>(which.param)) +
                                  (std::get<1>(which.param) ? "OverChannels" : "WithoutChannels");
                         });

}  // namespace
}  // namespace ctn
