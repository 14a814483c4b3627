#include "policy/stale_inputs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "config/testing/apps.h"

namespace ctn::policy {
namespace {

using std::chrono::milliseconds;
using testing::ElementsAre;

class StaleInputsTest : public ::testing::Test {
 protected:
  // A run of `act` that began then (ms), whose inputs from `scan` and `map` were so old (ms).
  std::vector<std::string> run(int begin, int scan, int map = 0) {
    record::Run run;
    run.node = *app.graph.find_node("act");
    run.begin = TimePoint{milliseconds{begin}};
    run.end = run.begin + milliseconds{2};
    run.ages = {scan < 0 ? record::kNoAge : milliseconds{scan}, milliseconds{map}};
    std::vector<std::string> told;
    for (const record::Notice& notice : stale.ran(run)) {
      EXPECT_EQ(notice.at, run.end);
      EXPECT_EQ(notice.kind, "stale-input");
      told.push_back(notice.detail);
    }
    return told;
  }

  const graph::App app = parse(R"(
catan: 1
app: old
nodes: { scan: {}, map: {}, act: {} }
edges:
  - { path: scan -> act, max_age: 100ms, on_stale: skip }
  - { path: map -> act, max_age: 1s }
objective: [ { period: act, weight: 1 } ]
)");
  StaleInputs stale{app.graph};
};

TEST_F(StaleInputsTest, ToldWhenItBeginsAndWhenItIsOver) {
  EXPECT_THAT(run(0, -1), ElementsAre()) << "nothing has come yet";
  EXPECT_THAT(run(10, 100), ElementsAre()) << "as old as it may be";
  EXPECT_THAT(run(20, 132), ElementsAre("what act takes from scan is 132 ms old, its max_age is 100 ms: such runs give "
                                        "no output"));
  EXPECT_THAT(run(30, 340), ElementsAre());
  EXPECT_THAT(run(40, 20), ElementsAre());
  EXPECT_THAT(run(1029, 20), ElementsAre()) << "not yet a second";
  EXPECT_THAT(run(1030, 20),
              ElementsAre("what act takes from scan is no older than its max_age of 100 ms again; 2 runs had older "
                          "data, the oldest of 340 ms"));
  EXPECT_THAT(run(1040, 20), ElementsAre());
  EXPECT_THAT(run(1050, 101), testing::SizeIs(1)) << "it begins again";
}

// An age that crosses its limit at every other run, for ten seconds.
TEST_F(StaleInputsTest, AnAgeNearItsLimitDoesNotFlood) {
  std::size_t told = 0;
  for (int ms = 0; ms < 10'000; ms += 10) told += run(ms, ms % 20 == 0 ? 99 : 101).size();
  EXPECT_EQ(told, 1U);
  EXPECT_THAT(run(20'000, 99), ElementsAre(testing::HasSubstr("; 500 runs had older data, the oldest of 101 ms")));
}

TEST_F(StaleInputsTest, EachEdgeIsToldForItself) {
  EXPECT_THAT(run(0, 150, 1001), ElementsAre(testing::HasSubstr("from scan is 150 ms old"),
                                             "what act takes from map is 1001 ms old, its max_age is 1000 ms"));
  EXPECT_THAT(run(1500, 10, 2000), ElementsAre(testing::HasSubstr("again; 1 run had older data")));
}

TEST_F(StaleInputsTest, RunsWhoseAgesAreNotKnownSayNothing) {
  record::Run run;
  run.node = *app.graph.find_node("act");
  EXPECT_TRUE(stale.ran(run).empty());
}

}  // namespace
}  // namespace ctn::policy
