#include "plan/limits.h"

#include <gtest/gtest.h>

#include <chrono>

#include "graph/build.h"
#include "graph/testing/spec_text.h"

namespace ctn::plan {
namespace {

using std::chrono::milliseconds;

// A camera (33 ms) and a driver (10 ms, an output each 40 ms) that run by themselves; image, rect and show are called
// for messages, play by a timer.
class UsefulPeriods : public ::testing::Test {
 protected:
  UsefulPeriods() {
    graph::node(spec_, "camera").external = true;
    graph::node(spec_, "camera").period = graph::At<Nanos>{milliseconds{33}, {}};
    graph::node(spec_, "driver").unscheduled = true;
    graph::node(spec_, "driver").period = graph::At<Nanos>{milliseconds{10}, {}};
    graph::node(spec_, "driver").output_period = graph::At<Nanos>{milliseconds{40}, {}};
    for (const char* name : {"image", "rect", "show"}) graph::node(spec_, name).needs_input = true;
    spec_.objective = {graph::response("camera image rect show", 1.0), graph::response("play", 1.0)};
  }

  UsefulPeriod of(const std::string& subchain) const {
    const graph::App app = graph::build_app(spec_).value();
    return useful_periods(app.graph)[app.graph.find_subchain(subchain)->index()];
  }
  static NodeId number(std::size_t index) { return NodeId(index); }

  graph::AppSpec spec_ = graph::spec_of({"camera", "driver", "image", "rect", "show", "play"},
                                        {"camera image rect show", "camera play", "driver play"});
};

TEST_F(UsefulPeriods, AreThoseOfWhatFeedsTheHead) {
  EXPECT_EQ(of("image").min, Millis{33.0});
  EXPECT_EQ(of("image").from, number(0));
  EXPECT_EQ(of("rect").min, Millis{33.0}) << "by way of image";
  EXPECT_EQ(of("show").from, number(3));
  EXPECT_EQ(of("play").min, Millis{0.0});
  EXPECT_FALSE(of("play").from);
}

TEST_F(UsefulPeriods, AreThoseOfTheFastestOfSeveral) {
  graph::node(spec_, "play").needs_input = true;
  EXPECT_EQ(of("play").min, Millis{33.0});
  graph::node(spec_, "driver").output_period.reset();
  EXPECT_EQ(of("play").min, Millis{10.0});
  EXPECT_EQ(of("play").from, number(1));
}

TEST_F(UsefulPeriods, GoByCapsAndOutputPeriodsOnTheWay) {
  graph::node(spec_, "image").max_rate = graph::At<Rate>{Rate{20.0}, {}};
  EXPECT_EQ(of("image").min, Millis{33.0}) << "the cap is a limit of its own";
  EXPECT_EQ(of("rect").min, Millis{50.0});
  graph::node(spec_, "rect").output_period = graph::At<Nanos>{milliseconds{200}, {}};
  EXPECT_EQ(of("show").min, Millis{200.0});
}

TEST_F(UsefulPeriods, AreAnyWhereSomeInputIsNotKnown) {
  graph::node(spec_, "camera").period.reset();
  EXPECT_EQ(of("image").min, Millis{0.0});
  EXPECT_EQ(of("rect").min, Millis{0.0});
  EXPECT_EQ(of("rect").from, number(2)) << "which may come as often as it likes";
}

TEST_F(UsefulPeriods, OfASubchainAreThoseOfItsHead) {
  spec_.subchains = {graph::subchain("line", "image rect show")};
  EXPECT_EQ(of("line").min, Millis{33.0});
  graph::node(spec_, "image").needs_input = false;
  EXPECT_EQ(of("line").min, Millis{0.0});
}

}  // namespace
}  // namespace ctn::plan
