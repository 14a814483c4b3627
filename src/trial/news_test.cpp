#include "trial/news.h"

#include <gtest/gtest.h>

#include <chrono>
#include <vector>

namespace ctn::trial {
namespace {

constexpr TimePoint moment(int ms) { return TimePoint{} + std::chrono::milliseconds{ms}; }

TEST(News, AnOutputIsNewsUntilARunBegins) {
  News news;
  EXPECT_FALSE(news.any(moment(1), {}));
  news.came();
  EXPECT_TRUE(news.any(moment(1), {}));
  EXPECT_TRUE(news.any(moment(2), {})) << "asking takes nothing away";
  news.begin_run(moment(2));
  EXPECT_FALSE(news.any(moment(3), {}));
  EXPECT_EQ(news.next_tick(moment(3), {}), kNever);
}

// The first ticks at 1, 21, 41, the second at 5, 35.
TEST(News, SoIsATickOfAnExternalNode) {
  const std::vector<Ticks> ticks{{moment(1), std::chrono::milliseconds{20}},
                                 {moment(5), std::chrono::milliseconds{30}}};
  News news;
  news.add_clock(NodeId(0));
  news.add_clock(NodeId(1));
  EXPECT_TRUE(news.any(moment(0), ticks)) << "of before the first run";
  news.begin_run(moment(5));
  EXPECT_FALSE(news.any(moment(20), ticks)) << "what comes as a run begins is that run's";
  EXPECT_EQ(news.next_tick(moment(20), ticks), moment(21));
  EXPECT_TRUE(news.any(moment(21), ticks));
  news.begin_run(moment(22));
  EXPECT_EQ(news.next_tick(moment(22), ticks), moment(35));
  EXPECT_EQ(news.next_tick(moment(35), ticks), moment(41)) << "after it";
}

}  // namespace
}  // namespace ctn::trial
