#include "base/result.h"

#include <gtest/gtest.h>

namespace ctn {
namespace {

TEST(Problem, NamesPlaceKeyFaultAndHint) {
  EXPECT_EQ(to_string(Problem{{"app.yaml", 12, 5}, "nodes.GL.max_rate", "'50' has no unit", "write 50Hz"}),
            "app.yaml:12:5: nodes.GL.max_rate: '50' has no unit; write 50Hz");
}

TEST(Problem, LeavesOutWhatIsNotKnown) {
  EXPECT_EQ(to_string(Problem{{}, "", "no such file", ""}), "no such file");
  EXPECT_EQ(to_string(Problem{{"a.yaml", 0, 0}, "", "is empty", "write an app"}), "a.yaml: is empty; write an app");
}

TEST(Result, HoldsAValueOrAllProblems) {
  const Result<int> good = 3;
  ASSERT_TRUE(good.ok());
  EXPECT_EQ(*good, 3);

  const Result<int> bad = Error(ErrorKind::kCaller, {Problem{{}, "a", "x", ""}, Problem{{}, "b", "y", ""}});
  ASSERT_FALSE(bad.ok());
  EXPECT_EQ(bad.error().message(), "a: x\nb: y");
}

}  // namespace
}  // namespace ctn
