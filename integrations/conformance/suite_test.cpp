// What every port must do, whatever the framework. Times are generous: it is the real machine, and it may be busy.
#include "conformance/suite.h"

#include <chrono>
#include <thread>

namespace ctn::conformance {

GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(PortSuite);

namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr std::size_t kSource = 0;
constexpr std::size_t kSink = 1;
constexpr std::size_t kOther = 2;

// A pair of nodes, and one by itself.
constexpr const char* kApp = R"(
nodes: { source: { fallback_rate: 50Hz }, sink: {}, other: { fallback_rate: 20Hz } }
edges: [ source -> sink ]
subchains: { pair: [source, sink] }
objective: [ { response_time: [source, sink], weight: 1 }, { period: other, weight: 1 } ]
)";

// Joined to other streams of one source: the newest message, or all.
constexpr const char* kRates = R"(
nodes:
  source: { fallback_rate: 100Hz }
  newest: { fallback_rate: 20Hz }
  all: { fallback_rate: 20Hz, input: queue }
edges: [ source -> newest, source -> all ]
objective: [ { period: source, weight: 1 } ]
)";

constexpr const char* kClock = R"(
nodes: { clock: { unscheduled: true, period: 10ms }, source: { fallback_rate: 20Hz } }
edges: [ clock -> source ]
objective: [ { response_time: [clock, source], weight: 1 } ]
)";

TEST_P(PortSuite, ATriggerIsOneCallAndOneReport) {
  serve(kApp, "default");
  const Program program =
      start({counting(kSource, "source", {}, [&](Call& call) { publish_next(call, kSource, kSink); }),
             counting(kSink, "sink", {{"source"}})});
  ASSERT_TRUE(called(kSink, 5));
  const std::int64_t before = of(kSource).ended;
  std::this_thread::sleep_for(seconds{1});
  EXPECT_NEAR(static_cast<double>(of(kSource).ended - before), 50.0, 20.0) << "at the rate that the app file says";
  EXPECT_EQ(stop(program), 0);
  EXPECT_LE(std::abs(of(kSource).ended - of(kSink).ended), 1 + of(kSource).overtaken);
  EXPECT_LE(of(kSink).gaps, of(kSource).overtaken) << "each message when its trigger comes";
  EXPECT_LE(of(kSource).overtaken, of(kSource).ended / 4) << "which is seldom late";
  const nlohmann::json measured = report();
  EXPECT_EQ(node(measured, "source")["runs"], of(kSource).ended.load());
  EXPECT_EQ(node(measured, "sink")["runs"], of(kSink).ended.load());
}

TEST_P(PortSuite, ScheduledByCatan) {
  serve(kApp, "catan");
  const Program program = start({counting(kSource, "source", {},
                                          [&](Call& call) {
                                            burn(milliseconds{2});
                                            call.publish(++of(kSource).published);
                                          }),
                                 counting(kSink, "sink", {{"source"}})});
  EXPECT_TRUE(called(kSink, 100));
  EXPECT_EQ(stop(program), 0);
  EXPECT_EQ(of(kSink).gaps, 0);
  const nlohmann::json measured = report();
  EXPECT_GT(measured["chains"][0]["response_ms"].value("count", 0), 50) << measured["chains"];
  EXPECT_FALSE(measured["chains"][0]["predicted"].is_null());
}

TEST_P(PortSuite, CpuTimeIsReported) {
  serve(kApp, "default");
  const Program program = start({counting(kOther, "other", {}, [](Call& call) {
    burn(milliseconds{4});
    call.publish(1);
  })});
  ASSERT_TRUE(called(kOther, 20));
  EXPECT_EQ(stop(program), 0);
  const nlohmann::json other = node(report(), "other");
  EXPECT_GE(other["compute_ms"]["p50"].get<double>(), 3.99);
  EXPECT_LT(other["compute_ms"]["p50"].get<double>(), 5.5);
}

TEST_P(PortSuite, ACallThatPublishesNothingTriggersNobody) {
  serve(kApp, "default");
  const Program program = start({counting(kSource, "source", {},
                                          [&](Call& call) {
                                            if (of(kSource).begun % 3 == 0) publish_next(call, kSource, kSink);
                                          }),
                                 counting(kSink, "sink", {{"source"}})});
  ASSERT_TRUE(called(kSink, 10));
  EXPECT_EQ(stop(program), 0);
  EXPECT_LE(std::abs(of(kSource).ended / 3 - of(kSink).ended), 1 + of(kSource).overtaken);
  EXPECT_LE(of(kSource).overtaken, of(kSource).published / 4);
  EXPECT_LE(of(kSink).gaps, of(kSource).overtaken);
  EXPECT_EQ(node(report(), "source")["outputs"], of(kSource).published.load());
}

TEST_P(PortSuite, TheNewestMessageOrAll) {
  serve(kRates, "default");
  // The source last: it is triggered as soon as it is there, and a framework does not keep messages for who comes
  // later.
  const Program program = start({counting(kSink, "newest", {{"source", false}}),
                                 counting(kOther, "all", {{"source", true}}), counting(kSource, "source")});
  ASSERT_TRUE(called(kSink, 20));
  ASSERT_TRUE(called(kOther, 20));
  EXPECT_EQ(stop(program), 0);
  EXPECT_EQ(of(kOther).gaps, 0) << "all, in order";
  EXPECT_GT(of(kOther).received, 2 * of(kOther).ended);
  EXPECT_LE(of(kSink).received, of(kSink).ended) << "one a call at most";
  EXPECT_EQ(of(kSink).backward, 0);
  EXPECT_GT(of(kSink).gaps, of(kSink).received / 2);
}

TEST_P(PortSuite, AnUnscheduledNodeRunsByItself) {
  serve(kClock, "default");
  Node clock = counting(kOther, "clock");
  clock.timer = milliseconds{10};
  const Program program = start({clock, counting(kSource, "source", {{"clock"}})});
  ASSERT_TRUE(called(kSource, 10));
  const std::int64_t before = of(kOther).ended;
  std::this_thread::sleep_for(seconds{1});
  EXPECT_NEAR(static_cast<double>(of(kOther).ended - before), 90.0, 40.0);
  const std::int64_t until_stopped = of(kOther).ended;
  EXPECT_EQ(stop(program), 0);
  const std::int64_t runs = node(report(), "clock")["runs"];
  EXPECT_GE(runs, until_stopped);
  EXPECT_LE(runs, of(kOther).ended) << "while its program shuts down it is called as without Catan";
}

TEST_P(PortSuite, NodesOfTwoProgramsTriggerEachOther) {
  serve(kApp, "default");
  const Program source = start({counting(kSource, "source")});
  std::this_thread::sleep_for(milliseconds{300});
  EXPECT_EQ(of(kSource).ended, 0) << "a subchain is triggered once all of its nodes have registered";
  const Program sink = start({counting(kSink, "sink")});
  ASSERT_TRUE(called(kSink, 1));
  // Counted while both are there: where the sink is a second late, or is gone before the source, a port may call the
  // source as without Catan.
  const std::int64_t source_before = of(kSource).ended;
  const std::int64_t sink_before = of(kSink).ended;
  ASSERT_TRUE(called(kSink, 20));
  const std::int64_t source_runs = of(kSource).ended - source_before;
  const std::int64_t sink_runs = of(kSink).ended - sink_before;
  EXPECT_EQ(stop(sink), 0);
  EXPECT_EQ(stop(source), 0);
  EXPECT_LE(std::abs(source_runs - sink_runs), 2 + source_runs / 4) << "but for where a late one was passed over";
}

TEST_P(PortSuite, AProgramThatWasKilledComesBack) {
  serve(kApp, "catan");
  const Program pair = start({counting(kSource, "source"), counting(kSink, "sink", {{"source"}})});
  const auto other = [&] {
    return counting(kOther, "other", {}, [](Call& call) {
      burn(milliseconds{3});
      call.publish(1);
    });
  };
  Program killed = start({other()});
  for (int round = 0; round < 3; ++round) {
    ASSERT_TRUE(called(kOther, 5)) << "in round " << round;
    kill_program(killed);
    EXPECT_TRUE(called(kSink, 5)) << "others go on";
    killed = start({other()});
  }
  EXPECT_TRUE(called(kOther, 5));
  EXPECT_EQ(stop(killed), 0);
  EXPECT_EQ(stop(pair), 0);
  EXPECT_EQ(of(kSink).gaps, 0);
}

TEST_P(PortSuite, AnotherServerTakesOver) {
  serve(kApp, "default");
  const Program program =
      start({counting(kSource, "source", {}, [&](Call& call) { publish_next(call, kSource, kSink); }),
             counting(kSink, "sink", {{"source"}})});
  ASSERT_TRUE(called(kSink, 10));
  kill_server();
  EXPECT_TRUE(called(kSink, 20, seconds{3})) << "it goes on by itself";
  serve(kApp, "default");
  std::this_thread::sleep_for(seconds{1});
  EXPECT_TRUE(called(kSink, 20));
  EXPECT_EQ(stop(program), 0);
  EXPECT_LE(of(kSink).gaps, of(kSource).overtaken);
  EXPECT_LE(of(kSource).overtaken, of(kSource).ended / 4);
  EXPECT_EQ(of(kSink).backward, 0);
  const nlohmann::json measured = report();
  EXPECT_GE(node(measured, "sink").value("runs", 0), 20) << "the new server hears of them";
}

TEST_P(PortSuite, AllThreadsOfANodeCount) {
  serve(kApp, "default");
  Node helped = counting(kOther, "other", {}, [](Call& call) {
    burn(milliseconds{1});
    call.on_another_thread([] { burn(milliseconds{3}); });
    call.publish(1);
  });
  helped.has_another_thread = true;
  // With another node in the program, so that its threads are not all of one.
  const Program program = start({helped, counting(kSource, "source"), counting(kSink, "sink", {{"source"}})});
  ASSERT_TRUE(called(kOther, 30));
  EXPECT_EQ(stop(program), 0);
  const nlohmann::json measured = report();
  EXPECT_GE(node(measured, "other")["compute_ms"]["p50"].get<double>(), 3.9);
  EXPECT_LT(node(measured, "source")["compute_ms"]["p50"].get<double>(), 1.0);
}

TEST_P(PortSuite, StoppingLosesNothing) {
  for (int round = 0; round < 3; ++round) {
    serve(kRates, "catan");
    of(kOther).newest = of(kSource).published.load();  // what was not taken has ended with the program
    const std::int64_t before = of(kOther).ended;
    const std::int64_t sent_before = of(kSource).ended;
    const Program program = start({counting(kSink, "newest", {{"source", false}}),
                                   counting(kOther, "all", {{"source", true}},
                                            [](Call& call) {
                                              burn(microseconds{500});
                                              call.publish(1);
                                            }),
                                   counting(kSource, "source")});
    ASSERT_TRUE(called(kOther, 10));
    EXPECT_EQ(stop(program), 0);
    EXPECT_EQ(of(kOther).begun, of(kOther).ended) << "a callback that began returns";
    const nlohmann::json measured = report();
    EXPECT_EQ(node(measured, "all")["runs"], of(kOther).ended - before);
    EXPECT_EQ(node(measured, "source")["runs"], of(kSource).ended - sent_before);
  }
  EXPECT_EQ(of(kOther).gaps, 0);
}

}  // namespace
}  // namespace ctn::conformance
