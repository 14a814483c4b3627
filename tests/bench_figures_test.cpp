// What catan bench makes of what it measures: no clock, no thread.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

#include "bench/figure.h"
#include "bench/gaps.h"

namespace ctn::tool {
namespace {

using std::chrono::microseconds;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

TimePoint at(int micros) { return TimePoint{microseconds{micros}}; }

TEST(HandOvers, CountFromTheSliceEndToTheFirstInstruction) {
  const std::vector<TimePoint> ends{at(1000), at(3000)};
  const std::vector<Gap> gaps{{at(0), at(1025)}, {at(2000), at(3030)}, {at(4000), at(5000)}};
  EXPECT_THAT(hand_overs(ends, gaps), ElementsAre(microseconds{25}, microseconds{30}));
}

TEST(HandOvers, LeaveOutEndsAtWhichNobodyCame) {
  // The first end finds it running, the second is followed by the third before it comes.
  const std::vector<TimePoint> ends{at(1000), at(2000), at(3000)};
  const std::vector<Gap> gaps{{at(1500), at(3040)}};
  EXPECT_THAT(hand_overs(ends, gaps), ElementsAre(microseconds{40}));
  EXPECT_THAT(hand_overs(ends, {}), IsEmpty());
  EXPECT_THAT(hand_overs({}, gaps), IsEmpty());
}

Summary about(double p50, double p99) {
  return {.count = 10, .mean = p50, .p50 = p50, .p95 = p99, .p99 = p99, .max = p99};
}

TEST(Figure, MeetsItsGoalWhereAllLimitsHold) {
  Figure figure{"hand-over", "busy core", kMicros, about(26.0, 80.0), "a timer", about(20.0, 60.0), {}};
  EXPECT_EQ(figure.met(), std::nullopt);
  EXPECT_DOUBLE_EQ(*figure.ratio(), 1.3);
  figure.goal = {.ratio = 1.3, .p50 = {}, .p99 = 120.0};
  EXPECT_EQ(figure.met(), true);
  figure.goal.p99 = 79.0;
  EXPECT_EQ(figure.met(), false);
  figure.goal = {.ratio = 1.2, .p50 = {}, .p99 = {}};
  EXPECT_EQ(figure.met(), false);
  figure.goal = {.ratio = {}, .p50 = 26.0, .p99 = {}};
  EXPECT_EQ(figure.met(), true);
  figure.measured = {};
  EXPECT_EQ(figure.met(), std::nullopt) << "nothing was measured";
}

TEST(Figure, WithoutABaselineMeetsNoRatio) {
  const Figure figure{"hand-over", {}, kMicros, about(26.0, 80.0), {}, {}, {.ratio = 1.3, .p50 = {}, .p99 = {}}};
  EXPECT_EQ(figure.ratio(), std::nullopt);
  EXPECT_EQ(figure.met(), false);
}

TEST(Figures, AreShownWithTheirBaselines) {
  std::vector<Figure> figures;
  figures.push_back({"hand-over",
                     "busy core",
                     kMicros,
                     about(26.04, 80.0),
                     "a timer",
                     about(20.0, 60.0),
                     {.ratio = 1.3, .p50 = {}, .p99 = 70.0}});
  const std::string text = figures_text(figures);
  EXPECT_THAT(text, HasSubstr("26.0"));
  EXPECT_THAT(text, HasSubstr("1.30"));
  EXPECT_THAT(text, HasSubstr("<= 1.3x, p99 <= 70"));
  EXPECT_THAT(text, HasSubstr("missed"));
  EXPECT_THAT(text, HasSubstr("hand-over: a timer"));
  EXPECT_THAT(figures_text({}), Not(HasSubstr("Bare")));
}

}  // namespace
}  // namespace ctn::tool
