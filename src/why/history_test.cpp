#include "why/history.h"

#include <gtest/gtest.h>

#include "why/testing/story.h"

namespace ctn::why {
namespace {

TEST(History, ForgetsRunsButThoseThatQuestionsLeadTo) {
  const graph::App app = robot();
  const NodeId scan = *app.graph.find_node("scan");
  History history(app, 1);
  for (std::uint64_t number = 1; number <= 10; ++number) {
    record::Run run;
    run.node = scan;
    run.number = number;
    run.begin = at(10 * number * ms(1));
    run.end = run.begin + ms(1);
    run.emitted = number != 8 && number != 9;
    history.add(run);
  }
  history.sort();
  EXPECT_EQ(history.forget_before(at(ms(85)))[scan.index()], 5U) << "2 to 6";
  history.sort();
  EXPECT_EQ(history.size(), 5U);
  EXPECT_TRUE(history.find(scan, 1).has_value());
  EXPECT_FALSE(history.find(scan, 6).has_value());
  EXPECT_EQ(history.run(*history.last_ended(scan, at(ms(85)), false)).number, 8U);
  EXPECT_EQ(history.run(*history.last_ended(scan, at(ms(95)), true)).number, 7U);
}

}  // namespace
}  // namespace ctn::why
