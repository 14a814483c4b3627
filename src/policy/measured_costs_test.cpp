#include "policy/measured_costs.h"

#include <gtest/gtest.h>

#include <chrono>

#include "base/testing/times.h"
#include "config/testing/apps.h"

namespace ctn::policy {
namespace {

using std::chrono::microseconds;

constexpr Millis kUnmeasured{7.0};

class MeasuredCostsTest : public testing::Test {
 protected:
  // A run of `grab` that took so long, each 10 ms.
  void grab(Nanos cpu, bool emitted) {
    record::Run run;
    run.node = grab_;
    run.number = ++runs_;
    run.begin = at(ms(10) * static_cast<Nanos::rep>(runs_));
    run.end = run.begin + cpu;
    run.cpu = cpu;
    run.emitted = emitted;
    measured_.add(run, 0);
  }
  Millis cost() const { return measured_.costs(kUnmeasured)[grab_].single_thread(); }

  const graph::App app_ = parse(R"(
catan: 1
app: camera
nodes: { camera: { external: true, period: 40ms }, grab: {} }
edges: [ camera -> grab ]
objective: [ { response_time: [camera, grab], weight: 1 } ]
)");
  const NodeId camera_ = *app_.graph.find_node("camera");
  const NodeId grab_ = *app_.graph.find_node("grab");
  MeasuredCosts measured_{app_};
  std::uint64_t runs_ = 0;
};

TEST_F(MeasuredCostsTest, IdleRunsAreToldApart) {
  measured_.set_clock(camera_, {at_ms(5), ms(40)});
  for (int round = 0; round < 100; ++round) {
    for (int run = 0; run < 4; ++run) grab(run == 0 ? ms(6) : Nanos{microseconds{30}}, run == 0);
  }
  EXPECT_EQ(cost(), Millis{6.0});
  EXPECT_EQ(measured_.costs(kUnmeasured).runs_per_output(grab_), 1.0);
  EXPECT_EQ(measured_.costs(kUnmeasured).idle(grab_), (model::IdleRuns{1.0, Millis{0.03}}));
}

TEST_F(MeasuredCostsTest, WithoutTheClockAllRunsAreAlike) {
  for (int round = 0; round < 100; ++round) {
    for (int run = 0; run < 4; ++run) grab(run == 0 ? ms(6) : Nanos{microseconds{30}}, run == 0);
  }
  EXPECT_EQ(measured_.costs(kUnmeasured).runs_per_output(grab_), 4.0);
  EXPECT_EQ(measured_.costs(kUnmeasured).idle(grab_), model::IdleRuns{});
}

// The camera ticks once, and then not for a long time.
TEST_F(MeasuredCostsTest, IdleRunsCountUntilThereAreOthers) {
  measured_.set_clock(camera_, {at_ms(5), std::chrono::hours{1}});
  for (int run = 0; run < 20; ++run) grab(microseconds{30}, false);
  EXPECT_EQ(measured_.unknown(), std::vector<NodeId>{}) << "it runs";
  EXPECT_EQ(cost(), Millis{0.03});
  measured_.set_clock(camera_, {at_ms(5), ms(40)});
  for (int run = 0; run < 8; ++run) grab(run % 4 == 0 ? ms(6) : Nanos{microseconds{30}}, run % 4 == 0);
  EXPECT_EQ(cost(), Millis{6.0});
}

}  // namespace
}  // namespace ctn::policy
