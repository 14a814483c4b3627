// Unmodified ROS programs under `catan ros run`: a real roscore, processes of their own, the real command. Times are
// generous: it is the real machine, and it may be busy.
#include "ros1/test/programs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <iterator>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include <nlohmann/json.hpp>

namespace catan_ros {
namespace {

using nlohmann::json;
using std::chrono::seconds;
using testing::AllOf;
using testing::HasSubstr;

// A camera, something that takes longer than the camera's period, and something light at the end.
constexpr const char* kPipeline = R"(catan: 1
app: pipeline
nodes: { source: { fallback_rate: 20Hz }, heavy: {}, light: {} }
edges: [ source -> heavy -> light ]
subchains: { all: [source, heavy, light] }
objective: [ { response_time: [source, heavy, light], weight: 1 } ]
scheduler: { bootstrap: 300ms }
)";

constexpr const char* kPipelineBindings = R"(catan: 1
ros:
  source: { node: /source, timer: 20ms }
  heavy: { node: /heavy, topic: /images }
  light: { node: /light, topic: /things }
)";

TEST_F(ProgramsTest, APipelineOfUnmodifiedProgramsIsScheduled) {
  write("app.yaml", kPipeline);
  write("bind.yaml", kPipelineBindings);
  write_launcher({"source --timer 20 --burn 1 --out /images --counts source.json",
                  "heavy --in /images --burn 30 --out /things --counts heavy.json",
                  "light --in /things --burn 2 --counts light.json"});
  const int run = start_under_catan("--json --record run.catan --seconds 6 -- ./launch.sh");
  ASSERT_EQ(wait(run, seconds{60}), 0) << text_of(path("run.err"));
  const json report = json::parse(text_of(path("run.out")));
  for (const char* const name : {"source", "heavy", "light"}) {
    EXPECT_GT(node(report, name)["runs"].get<long>(), 40) << name << ": " << report["nodes"];
  }
  EXPECT_GT(node(report, "heavy")["compute_ms"]["p50"].get<double>(), 29.5);
  EXPECT_LT(node(report, "heavy")["compute_ms"]["p50"].get<double>(), 40.0);
  EXPECT_GT(node(report, "light")["compute_ms"]["p50"].get<double>(), 1.9);
  EXPECT_LT(node(report, "light")["compute_ms"]["p50"].get<double>(), 6.0);
  // One period and one pass, roughly: what waited in queues would make it a multiple.
  const json chain = report["chains"][0];
  EXPECT_GT(chain["response_ms"]["count"].get<long>(), 40);
  EXPECT_GT(chain["latency_ms"]["p50"].get<double>(), 33.0);
  EXPECT_LT(chain["latency_ms"]["p50"].get<double>(), 60.0);
  EXPECT_LT(chain["response_ms"]["p50"].get<double>(), 120.0);
  EXPECT_EQ(counted("light", "backward"), 0);
}

// The message's value is the number of the run that sent it.
TEST_F(ProgramsTest, ARunHasConsumedTheRunsThatSentItsMessages) {
  write("app.yaml", R"(catan: 1
app: lineage
nodes: { source: { fallback_rate: 100Hz }, late: { fallback_rate: 30Hz }, all: { fallback_rate: 20Hz, input: queue } }
edges: [ source -> late, source -> all ]
objective: [ { response_time: [source, late], weight: 1 }, { period: all, weight: 1 } ]
)");
  write("bind.yaml", R"(catan: 1
ros:
  source: { node: /source, timer: 10ms }
  late: { node: /late, topic: /data }
  all: { node: /all, topic: /data }
)");
  write_launcher({"source --timer 10 --out /data", "late --in /data --log late.log", "all --in /data --log all.log"});
  const int run = start_under_catan("--scheduler default --seconds 5 --record run.catan -- ./launch.sh");
  ASSERT_EQ(wait(run, seconds{60}), 0) << text_of(path("run.err"));
  const auto numbers = [&](const std::string& name) {
    std::istringstream text(text_of(path(name)));
    return std::vector<long>(std::istream_iterator<long>(text), {});
  };
  const auto consumed = [&](const std::string& node, const std::string& what) {
    const std::string query = "SELECT " + what +
                              " FROM consumed JOIN nodes ON nodes.id = consumed.node WHERE nodes.name = '" + node +
                              "' ORDER BY consumed.run";
    wait(start("consumed", "sqlite3 run.catan \"" + query + "\""), seconds{10});
    return numbers("consumed.out");
  };
  const std::vector<long> runs = consumed("late", "consumed.last");
  const std::vector<long> messages = numbers("late.log");
  ASSERT_GT(messages.size(), 100U);
  const auto found = std::count_if(messages.begin(), messages.end(), [&](long message) {
    return std::find(runs.begin(), runs.end(), message) != runs.end();
  });
  // A message may be there before the run that sent it has ended.
  EXPECT_GE(found, static_cast<long>(messages.size()) * 95 / 100);
  EXPECT_EQ(std::adjacent_find(runs.begin(), runs.end(), std::greater<>{}), runs.end()) << "never an older one";

  const std::vector<long> firsts = consumed("all", "consumed.first");
  const std::vector<long> lasts = consumed("all", "consumed.last");
  ASSERT_EQ(firsts.size(), lasts.size());
  ASSERT_GT(lasts.size(), 50U);
  EXPECT_NEAR(static_cast<double>(lasts.back() - firsts.front() + 1), static_cast<double>(numbers("all.log").size()),
              20.0);
}

TEST_F(ProgramsTest, ACallbackThatIsNotBoundGoesOnWhileABoundOneWaits) {
  write_app_of_work("fallback_rate: 2Hz");
  write_binding_of_work("/worker");
  write_launcher({"feed --timer 10 --out /data --counts feed.json", "ticks --timer 10 --out /ticks",
                  "worker --in /data --beside /ticks --burn 5 --counts worker.json"});
  const int run = start_under_catan("--scheduler default -- ./launch.sh");
  ASSERT_TRUE(counts("worker", "calls", 3)) << text_of(path("run.err"));
  const long calls = counted("worker", "calls");
  const long beside = counted("worker", "beside");
  std::this_thread::sleep_for(seconds{3});
  EXPECT_LT(counted("worker", "calls") - calls, 12) << "at the rate that the app file says";
  EXPECT_GT(counted("worker", "beside") - beside, 150) << "as without Catan";
  EXPECT_EQ(counted("worker", "overlaps"), 0) << "of one spinner thread";
  EXPECT_EQ(counted("worker", "backward"), 0);
  EXPECT_EQ(end(run, SIGTERM), 128 + SIGTERM) << text_of(path("run.err"));
}

// Its threads may call two callbacks at a time, of which one is bound.
TEST_F(ProgramsTest, ASpinnerOfSeveralThreadsGoesOnBesideABoundCallback) {
  write_app_of_work("fallback_rate: 20Hz");
  write_binding_of_work("/worker");
  write_launcher({"feed --timer 10 --out /data", "ticks --timer 10 --out /ticks",
                  "worker --in /data --beside /ticks --burn 20 --threads 3 --counts worker.json"});
  const int run = start_under_catan("--scheduler default -- ./launch.sh");
  ASSERT_TRUE(counts("worker", "calls", 5)) << text_of(path("run.err"));
  const long calls = counted("worker", "calls");
  EXPECT_TRUE(counts("worker", "beside", 200)) << "as without Catan";
  EXPECT_LT(counted("worker", "calls") - calls, 100) << "at the rate that the app file says, not at that of messages";
  EXPECT_GT(counted("worker", "overlaps"), 0);
  EXPECT_EQ(counted("worker", "backward"), 0);
  EXPECT_EQ(end(run, SIGTERM), 128 + SIGTERM) << text_of(path("run.err"));
}

// They are as many as a queue's spinners may be at a time, and more.
TEST_F(ProgramsTest, SpinnersThatWereStoppedHoldUpNothing) {
  write_app_of_work("fallback_rate: 20Hz");
  write_binding_of_work("/worker");
  write_launcher({"feed --timer 10 --out /data", "ticks --timer 10 --out /ticks",
                  "worker --in /data --beside /ticks --restarts 20 --counts worker.json"});
  const int run = start_under_catan("--scheduler default -- ./launch.sh");
  EXPECT_TRUE(counts("worker", "calls", 20)) << text_of(path("run.err"));
  EXPECT_TRUE(counts("worker", "beside", 100));
  EXPECT_EQ(end(run, SIGTERM), 128 + SIGTERM) << text_of(path("run.err"));
}

// Who asks waits until it is the service's turn.
TEST_F(ProgramsTest, AServiceIsScheduled) {
  write_app_of_work("fallback_rate: 20Hz");
  write_binding_of_work("/server", "bind.yaml", "service: /question");
  write_launcher({"server --service /question --beside /ticks --burn 2 --counts server.json",
                  "client --timer 10 --ask /question --counts client.json", "ticks --timer 10 --out /ticks"});
  const int run = start_under_catan("--scheduler default -- ./launch.sh");
  ASSERT_TRUE(counts("client", "calls", 5)) << text_of(path("run.err"));
  const long answers = counted("client", "calls");
  EXPECT_TRUE(counts("server", "beside", 300)) << "what is not bound goes on while one who asks waits";
  const long more = counted("client", "calls") - answers;
  EXPECT_GT(more, 20);
  EXPECT_LT(more, 120) << "each 50 ms, and not each 10 ms";
  EXPECT_THAT(text_of(path("run.err")), HasSubstr("subchain work runs"));
  EXPECT_EQ(end(run, SIGTERM), 128 + SIGTERM);
}

TEST_F(ProgramsTest, NothingRunsBesideTheProgramsOwnLoop) {
  write_app_of_work("fallback_rate: 50Hz");
  write_binding_of_work("/looper");
  write_launcher(
      {"feed --timer 5 --out /data", "looper --in /data --beside /data --burn 1 --spin-once --counts looper.json"});
  const int run = start_under_catan("--scheduler default -- ./launch.sh");
  EXPECT_TRUE(counts("looper", "calls", 100)) << text_of(path("run.err"));
  EXPECT_EQ(counted("looper", "overlaps"), 0);
  end(run, SIGTERM);
}

// roscpp makes a message once for both; the bound one lets go of those that it is too slow for.
TEST_F(ProgramsTest, WhatABoundCallbackLetsGoOfReachesAnotherOfItsTopic) {
  write_app_of_work("fallback_rate: 5Hz");
  write_binding_of_work("/looper");
  write_launcher({"feed --timer 10 --out /data --counts feed.json",
                  "looper --in /data --beside /data --spin-once --loop-hz 20 --counts looper.json"});
  const int run = start_under_catan("--scheduler default -- ./launch.sh");
  ASSERT_TRUE(counts("looper", "beside", 50)) << text_of(path("run.err"));
  const long fed = counted("feed", "calls");
  const long beside = counted("looper", "beside");
  EXPECT_TRUE(counts("feed", "calls", 400));
  std::this_thread::sleep_for(seconds{1});
  EXPECT_GE(counted("looper", "beside") - beside, (counted("feed", "calls") - fed) * 9 / 10);
  EXPECT_THAT(text_of(path("run.err")), HasSubstr("there is another callback of a subscription of /data"));
  end(run, SIGTERM);
}

TEST_F(ProgramsTest, ASubscriptionThatWaitedForItsFirstMessageIsScheduled) {
  write_app_of_work("fallback_rate: 20Hz");
  write_binding_of_work("/worker");
  write_launcher({"feed --timer 10 --out /data", "worker --in /data --wait-first --counts worker.json"});
  const int run = start_under_catan("--scheduler default --json --record run.catan --seconds 6 -- ./launch.sh");
  EXPECT_TRUE(counts("worker", "calls", 20)) << text_of(path("run.err"));
  ASSERT_EQ(wait(run, seconds{60}), 0) << text_of(path("run.err"));
  EXPECT_GT(node(json::parse(text_of(path("run.out"))), "work")["runs"].get<long>(), 40);
  EXPECT_EQ(text_of(path("run.err")).find("another callback"), std::string::npos) << text_of(path("run.err"));
}

// The new subscription is there before the old one goes.
TEST_F(ProgramsTest, ASubscriptionThatIsAssignedAnotherIsScheduled) {
  write_app_of_work("fallback_rate: 5Hz");
  write_binding_of_work("/worker");
  write_launcher({"feed --timer 10 --out /data --counts feed.json",
                  "worker --in /data --subscribe-again --queue 1 --counts worker.json"});
  const int run = start_under_catan("--scheduler default -- ./launch.sh");
  ASSERT_TRUE(counts("worker", "calls", 5)) << text_of(path("run.err"));
  const long calls = counted("worker", "calls");
  EXPECT_TRUE(counts("feed", "calls", 400));
  EXPECT_GT(counted("worker", "calls") - calls, 5);
  EXPECT_LT(counted("worker", "calls") - calls, 100) << "at the rate that the app file says, not at that of messages";
  EXPECT_EQ(end(run, SIGTERM), 128 + SIGTERM) << text_of(path("run.err"));
}

// roscpp does not wait for a call that is under way, which may need what the caller has got.
TEST_F(ProgramsTest, WhoStopsATimerDoesNotWaitForItsCallback) {
  write_app_of_work("fallback_rate: 20Hz");
  write_binding_of_work("/worker", "bind.yaml", "timer: 20ms");
  write_launcher({"worker --timer 20 --stop-inside --counts worker.json"});
  const int run = start_under_catan("--scheduler default -- ./launch.sh");
  EXPECT_TRUE(counts("worker", "stopped", 1)) << text_of(path("run.err"));
  EXPECT_FALSE(counts("worker", "calls", 2, seconds{1})) << "it is stopped";
  EXPECT_EQ(end(run, SIGTERM), 128 + SIGTERM) << text_of(path("run.err"));
}

TEST_F(ProgramsTest, WhoShutsAServiceDownDoesNotWaitForItsCallback) {
  write_app_of_work("fallback_rate: 20Hz");
  write_binding_of_work("/server", "bind.yaml", "service: /question");
  write_launcher(
      {"server --service /question --stop-inside --counts server.json", "client --timer 10 --ask /question"});
  const int run = start_under_catan("--scheduler default -- ./launch.sh");
  EXPECT_TRUE(counts("server", "stopped", 1)) << text_of(path("run.err"));
  EXPECT_EQ(end(run, SIGTERM), 128 + SIGTERM) << text_of(path("run.err"));
}

// It waited half a second for a request whenever the timer had run.
TEST_F(ProgramsTest, AServiceThatNobodyAsksDoesNotHoldUpTheNodeBeforeIt) {
  write("app.yaml", R"(catan: 1
app: pair
nodes: { look: { fallback_rate: 20Hz }, answer: {} }
edges: [ look -> answer ]
subchains: { pair: [look, answer] }
objective: [ { response_time: [look, answer], weight: 1 } ]
)");
  write("bind.yaml", R"(catan: 1
ros:
  look: { node: /worker, timer: 20ms }
  answer: { node: /worker, service: /question }
)");
  write_launcher({"worker --timer 20 --service /question --counts worker.json"});
  const int run = start_under_catan("--scheduler catan -- ./launch.sh");
  EXPECT_TRUE(counts("worker", "calls", 120)) << "in 20 s; " << text_of(path("run.err"));
  EXPECT_EQ(end(run, SIGTERM), 128 + SIGTERM) << text_of(path("run.err"));
}

// It waits for a trigger, whatever queue was enough for a spinner.
TEST_F(ProgramsTest, AQueueNodeGetsAllThatHasCome) {
  write_app_of_work("fallback_rate: 10Hz, input: queue");
  write_binding_of_work("/worker");
  write_launcher({"feed --timer 10 --out /data", "worker --in /data --queue 1 --log worker.log --counts worker.json"});
  const int run = start_under_catan("--scheduler default -- ./launch.sh");
  EXPECT_TRUE(counts("worker", "calls", 200)) << text_of(path("run.err"));
  end(run, SIGTERM);
  std::istringstream log(text_of(path("worker.log")));
  const std::vector<long> got(std::istream_iterator<long>(log), {});
  ASSERT_GT(got.size(), 100U);
  EXPECT_GE(static_cast<long>(got.size()), (got.back() - got.front() + 1) * 95 / 100);
}

TEST_F(ProgramsTest, ATimerThatIsDueOnceIsNotTheNode) {
  write_app_of_work("fallback_rate: 10Hz");
  write_binding_of_work("/worker", "bind.yaml", "timer: 150ms");
  write_launcher({"worker --timer 150 --once-first --counts worker.json"});
  const int run = start_under_catan("--scheduler default -- ./launch.sh");
  EXPECT_TRUE(counts("worker", "calls", 30)) << text_of(path("run.err"));
  EXPECT_EQ(counted("worker", "once"), 1);
  EXPECT_EQ(text_of(path("run.err")).find("another callback"), std::string::npos) << text_of(path("run.err"));
  end(run, SIGTERM);
}

// Whether roscpp or a trigger made the call before.
TEST_F(ProgramsTest, ATimerIsToldHowLongAgoItWasCalled) {
  write_app_of_work("fallback_rate: 90Hz");
  write_binding_of_work("/worker", "bind.yaml", "timer: 20ms");
  write_launcher({"worker --timer 20 --counts worker.json"});
  const int run = start_under_catan("--scheduler default -- ./launch.sh");
  EXPECT_TRUE(counts("worker", "calls", 300)) << text_of(path("run.err"));
  const auto told = static_cast<double>(counted("worker", "told_ms"));
  const auto passed = static_cast<double>(counted("worker", "passed_ms"));
  EXPECT_GT(passed, 1000.0);
  EXPECT_NEAR(told, passed, 0.1 * passed);
  end(run, SIGTERM);
}

// There is none, so that it stands still.
TEST_F(ProgramsTest, UnderSimulatedTimeATimerIsCalledWhenItIsDue) {
  write_app_of_work("fallback_rate: 50Hz");
  write_binding_of_work("/worker", "bind.yaml", "timer: 20ms");
  write_launcher({"worker --timer 20 --simulated-time --counts worker.json"});
  const int run = start_under_catan("--scheduler default --seconds 5 -- ./launch.sh");
  ASSERT_EQ(wait(run, seconds{60}), 0) << text_of(path("run.err"));
  EXPECT_NE(text_of(path("worker.json")), "") << "it did not run";
  EXPECT_EQ(counted("worker", "calls"), 0);
}

TEST_F(ProgramsTest, AQueueOfAnotherClassKeepsItsCallbacksApart) {
  write_app_of_work("fallback_rate: 50Hz");
  write_binding_of_work("/wrapped");
  write_launcher({"feed --timer 5 --out /data",
                  "wrapped --in /data --beside /data --burn 2 --wrapped-queue --counts wrapped.json"});
  const int run = start_under_catan("--scheduler default --json --record run.catan --seconds 5 -- ./launch.sh");
  EXPECT_TRUE(counts("wrapped", "calls", 50)) << text_of(path("run.err"));
  EXPECT_TRUE(counts("wrapped", "beside", 50));
  ASSERT_EQ(wait(run, seconds{60}), 0) << text_of(path("run.err"));
  EXPECT_EQ(counted("wrapped", "overlaps"), 0);
  EXPECT_GT(node(json::parse(text_of(path("run.out"))), "work")["runs"].get<long>(), 100);
}

// What a callback costs that is not bound, beside bound ones in the same queue, and without Catan.
// What it costs more is printed, for docs/ros1.md; a busy machine is no reason to fail.
TEST_F(ProgramsTest, CallbacksThatAreNotBoundAreCalledAndWhatThatCostsIsPrinted) {
  write_app_of_work("fallback_rate: 1Hz");
  write_binding_of_work("/hook_cost", "bound.yaml");
  write_binding_of_work("/other", "other.yaml");
  const std::string run = std::string(CATAN_COMMAND) + " ros run app.yaml --scheduler default --bind ";
  EXPECT_EQ(wait(start("without", std::string(HOOK_COST) + " without.ns"), seconds{60}), 0);
  EXPECT_EQ(wait(start("other", run + "other.yaml -- " + HOOK_COST + " other.ns"), seconds{60}), 0);
  EXPECT_EQ(wait(start("bound", run + "bound.yaml -- " + HOOK_COST + " bound.ns"), seconds{60}), 0);
  const auto nanoseconds_of = [this](const std::string& name) { return std::stod(text_of(path(name + ".ns"))); };
  for (const std::string name : {"without", "other", "bound"}) EXPECT_GT(nanoseconds_of(name), 1.0) << name;
  std::printf(
      "a callback that is not bound: %.1f ns without Catan, %.1f ns in a program without bound callbacks, "
      "%.1f ns beside a bound one\n",
      nanoseconds_of("without"), nanoseconds_of("other"), nanoseconds_of("bound"));
}

// From a trigger to the first instruction of the node's function, with the message already there, beside a node in the
// process of the scheduler. It is printed, for docs/ros1.md; a busy machine is no reason to fail. Messages come at no
// divisor of the trigger's period: else it depends on the phase whether each trigger meets one that just arrives.
TEST_F(ProgramsTest, WhatItTakesFromATriggerToTheCallbackIsPrinted) {
  write_app_of_work("max_rate: 200Hz, fallback_rate: 200Hz", "scheduler: { bootstrap: 200ms }\n");
  write_binding_of_work("/work");
  EXPECT_EQ(wait(start("session", std::string(TRIGGER_LATENCY) + " session app.yaml session.ns"), seconds{30}), 0)
      << text_of(path("session.err"));
  start_node("feed", "--timer 1.3 --out /data");
  const int run =
      start_under_catan("--seconds 2 --record ros.ns.catan -- " + std::string(TRIGGER_LATENCY) + " ros ros.ns");
  EXPECT_EQ(wait(run, seconds{30}), 0) << text_of(path("run.err"));
  const auto times = [this](const std::string& name) {
    std::istringstream text(text_of(path(name)));
    return std::vector<long>(std::istream_iterator<long>(text), {});
  };
  const auto median_us = [&](const std::string& name) {
    wait(start("sent", "sqlite3 " + name + ".ns.catan \"SELECT sent_ns FROM triggers ORDER BY sent_ns\""), seconds{10});
    const std::vector<long> sent = times("sent.out");
    std::vector<long> latencies;
    // The last trigger before each begin.
    for (const long begin : times(name + ".ns")) {
      const auto next = std::upper_bound(sent.begin(), sent.end(), begin);
      if (next != sent.begin()) latencies.push_back(begin - *std::prev(next));
    }
    EXPECT_GT(latencies.size(), 100U) << name;
    if (latencies.empty()) return 0.0;
    std::nth_element(latencies.begin(), latencies.begin() + static_cast<std::ptrdiff_t>(latencies.size() / 2),
                     latencies.end());
    return static_cast<double>(latencies[latencies.size() / 2]) * 1e-3;
  };
  const double session = median_us("session");
  const double ros = median_us("ros");
  std::printf("from trigger to callback, median: %.1f us in process, %.1f us in a ROS program: %.2f times\n", session,
              ros, ros / session);
}

TEST_F(ProgramsTest, WhenTheServerIsKilledAllGoOn) {
  write("app.yaml", kPipeline);
  write("bind.yaml", kPipelineBindings);
  const std::string catan = CATAN_COMMAND;
  const int server = start("serve", catan + " serve app.yaml --socket server");
  const std::string join = catan + " ros run app.yaml --bind bind.yaml --socket server -- " + PLAIN_NODE + " ";
  start("source", join + "source --timer 20 --burn 1 --out /images --counts source.json");
  start("heavy", join + "heavy --in /images --burn 10 --out /things --counts heavy.json");
  start("light", join + "light --in /things --beside /images --burn 1 --counts light.json");
  ASSERT_TRUE(counts("light", "calls", 20)) << text_of(path("light.err"));
  ::kill(server, SIGKILL);
  wait(server, seconds{5});
  EXPECT_TRUE(counts("light", "calls", 20)) << "by themselves";
  EXPECT_TRUE(counts("light", "beside", 20));
  start("serve", catan + " serve app.yaml --socket server --record second");
  std::this_thread::sleep_for(seconds{2});
  EXPECT_TRUE(counts("light", "calls", 20)) << "with another server";
  EXPECT_EQ(counted("light", "backward"), 0);
}

TEST_F(ProgramsTest, ANodeOrMessageThatNeverComesIsToldAndHoldsUpNoOther) {
  write("app.yaml", R"(catan: 1
app: half
nodes:
  there: { fallback_rate: 20Hz }
  gone: { fallback_rate: 20Hz }
  misspelt: { fallback_rate: 20Hz }
  mistyped: { fallback_rate: 20Hz }
  scripted: { fallback_rate: 20Hz }
objective: [ { period: there, weight: 1 }, { period: gone, weight: 1 }, { period: misspelt, weight: 1 },
             { period: mistyped, weight: 1 }, { period: scripted, weight: 1 } ]
)");
  write("bind.yaml", R"(catan: 1
ros:
  there: { node: /worker, topic: /data }
  gone: { node: /nobody, topic: /data }
  misspelt: { node: /worker, topic: /dada }
  mistyped: { node: /typed, topic: /speed }
  scripted: { node: /talker, topic: /data }
)");
  write_talker("/speed", "Float64");
  start("talker", "/usr/bin/python3 talker.py");
  write_launcher({"feed --timer 10 --out /data", "worker --in /data --counts worker.json", "typed --in /speed"});
  const int run = start_under_catan("--scheduler default --seconds 14 -- ./launch.sh");
  EXPECT_TRUE(counts("worker", "calls", 40)) << text_of(path("run.err"));
  wait(run, seconds{60});
  EXPECT_THAT(text_of(path("run.err")), HasSubstr("node gone has not run in 10 s: its ROS node /nobody has not come"));
  EXPECT_THAT(text_of(path("run.err")),
              HasSubstr("node misspelt has not run in 10 s: its ROS node /worker has no such callback"));
  EXPECT_THAT(text_of(path("run.err")),
              HasSubstr("node scripted has not run in 10 s: its ROS node /talker is written in Python, whose callbacks "
                        "cannot be triggered (write external: true in place of its binding), or a node"));
  EXPECT_THAT(
      text_of(path("run.err")) + text_of(path("run.out")),
      AllOf(HasSubstr("/worker has not asked for a subscription of /dada in 10 s, which is to be node misspelt"),
            HasSubstr("node mistyped is triggered, and no message has come on /speed in 10 s: see rostopic info "
                      "/speed")));
}

// ROS ends the first of two nodes of one name; the second may ask for the node of the app before the first has left it.
TEST_F(ProgramsTest, AProgramThatTakesThePlaceOfAnotherIsScheduled) {
  write_app_of_work("fallback_rate: 5Hz");
  write_binding_of_work("/worker");
  const std::string catan = CATAN_COMMAND;
  start("serve", catan + " serve app.yaml --scheduler default --socket server");
  start_node("feed", "--timer 10 --out /data");
  const std::string join = catan + " ros run app.yaml --bind bind.yaml --socket server -- " + PLAIN_NODE + " worker ";
  const int first = start("first", join + "--in /data --counts first.json");
  ASSERT_TRUE(counts("first", "calls", 5)) << text_of(path("first.err"));
  const int second = start("second", join + "--in /data --counts second.json");
  EXPECT_EQ(wait(first, seconds{15}), 0) << "ROS ends it";
  ASSERT_TRUE(counts("second", "calls", 5)) << text_of(path("second.err"));
  // At the rate that the app file says, which is a twentieth of that of the messages.
  long in_a_second = 100;
  for (int tries = 0; tries < 15 && in_a_second > 15; ++tries) {
    const long before = counted("second", "calls");
    std::this_thread::sleep_for(seconds{1});
    in_a_second = counted("second", "calls") - before;
  }
  EXPECT_LE(in_a_second, 15);
  EXPECT_EQ(end(second, SIGINT), 0);
  EXPECT_THAT(text_of(path("second.out")), HasSubstr("catan: node work is scheduled")) << text_of(path("second.err"));
}

TEST_F(ProgramsTest, ASecondProgramThatClaimsANodeIsToldAndRunsAsWithoutCatan) {
  write_app_of_work("fallback_rate: 5Hz");
  write_binding_of_work("/first");
  write_binding_of_work("/second", "other.yaml");
  const std::string catan = CATAN_COMMAND;
  start("serve", catan + " serve app.yaml --scheduler default --socket server");
  start_node("feed", "--timer 10 --out /data");
  const auto join = [&](const std::string& bind, const std::string& node) {
    return start(node, catan + " ros run app.yaml --bind " + bind + " --socket server -- " + PLAIN_NODE + " " + node +
                           " --in /data --spin-once --loop-hz 20 --counts " + node + ".json");
  };
  join("bind.yaml", "first");
  ASSERT_TRUE(counts("first", "calls", 5)) << text_of(path("first.err"));
  const int second = join("other.yaml", "second");
  ASSERT_TRUE(counts("second", "calls", 10)) << text_of(path("second.err"));
  const long fed = counted("feed", "calls");
  const long before = counted("second", "calls");
  EXPECT_TRUE(counts("second", "calls", 200));
  EXPECT_GE(counted("second", "calls") - before, (counted("feed", "calls") - fed) * 9 / 10) << "with each message";
  EXPECT_EQ(end(second, SIGINT), 0);
  EXPECT_THAT(text_of(path("second.out")) + text_of(path("second.err")),
              HasSubstr("node work is there already; stop the program that runs it, or this one"));
}

TEST_F(ProgramsTest, ANodeThatIsKilledInACallbackComesBackAndAMasterThatEndsHoldsUpNothing) {
  write("app.yaml", kPipeline);
  write("bind.yaml", kPipelineBindings);
  const std::string catan = CATAN_COMMAND;
  start("serve", catan + " serve app.yaml --socket server");
  const std::string join = catan + " ros run app.yaml --bind bind.yaml --socket server -- " + PLAIN_NODE + " ";
  start("source", join + "source --timer 20 --burn 1 --out /images --counts source.json");
  const std::string heavy = join + "heavy --in /images --burn 30 --out /things --counts heavy.json";
  const int killed = start("heavy", heavy);
  start("light", join + "light --in /things --beside /ticks --burn 1 --counts light.json");
  start_node("ticks", "--timer 10 --out /ticks");
  ASSERT_TRUE(counts("light", "calls", 20)) << text_of(path("light.err"));

  // Of its time it is in a callback nine parts in ten.
  ::kill(killed, SIGKILL);
  wait(killed, seconds{5});
  EXPECT_TRUE(counts("light", "beside", 50)) << "what is not bound";
  start("heavy", heavy);
  EXPECT_TRUE(counts("light", "calls", 20));
  EXPECT_EQ(counted("light", "backward"), 0);
  EXPECT_THAT(text_of(path("serve.err")), HasSubstr("heavy"));

  roscore().stop();
  EXPECT_TRUE(counts("light", "calls", 20)) << "without a master";
  roscore().start();
  EXPECT_TRUE(counts("light", "calls", 20)) << "with another, which knows of none";
}

TEST_F(ProgramsTest, WithoutABindingAProgramIsAsWithoutCatan) {
  write("app.yaml", kPipeline);
  write("bind.yaml", kPipelineBindings);
  write_launcher({"feed --timer 10 --out /data", "other --in /data --counts other.json"});
  const int run = start_under_catan("-- ./launch.sh");
  EXPECT_TRUE(counts("other", "calls", 200));
  end(run, SIGTERM);
}

TEST_F(ProgramsTest, TheCommandsExitCodeIsPassedOn) {
  write("app.yaml", kPipeline);
  write("bind.yaml", kPipelineBindings);
  const int run = start_under_catan("-- sh -c 'exit 7'");
  EXPECT_EQ(wait(run, seconds{20}), 7) << text_of(path("run.err"));
}

TEST_F(ProgramsTest, WhatIsWrongWithBindingsIsToldBeforeAnythingStarts) {
  write("app.yaml", kPipeline);
  write("bind.yaml", "catan: 1\nros:\n  haevy: { node: /heavy, topic: /images }\n");
  const int run = start_under_catan("-- touch started");
  EXPECT_EQ(wait(run, seconds{20}), 2);
  EXPECT_THAT(text_of(path("run.err")), HasSubstr("bind.yaml:3:3: ros.haevy: app pipeline has no node 'haevy'"));
  EXPECT_FALSE(std::filesystem::exists(path("started")));
  const int without = start("run", std::string(CATAN_COMMAND) + " ros run app.yaml -- touch started");
  EXPECT_EQ(wait(without, seconds{20}), 2);
  EXPECT_THAT(text_of(path("run.err")), HasSubstr("no node of app pipeline is a callback of a ROS program"));
}

}  // namespace
}  // namespace catan_ros
