#include "drawing/context.h"

#include <gtest/gtest.h>

namespace ctn::vr::drawing {
namespace {

TEST(Context, SaysWhatToInstallWhereThereIsNoEgl) {
  const auto context = Context::open(Screen::kFirst, "libEGL-that-is-not-there.so.1");
  ASSERT_FALSE(context);
  EXPECT_EQ(context.error().kind(), ErrorKind::kEnvironment);
  EXPECT_NE(context.error().message().find("libEGL-that-is-not-there.so.1 is not there"), std::string::npos);
  EXPECT_NE(context.error().message().find("apt-get install libegl1"), std::string::npos);
}

TEST(Context, OfAnotherScreenWaitsForNoOther) {
  const auto one = Context::open(Screen::kFirst);
  if (!one) GTEST_SKIP() << one.error().message();
  const auto same = Context::open(Screen::kFirst);
  const auto other = Context::open(Screen::kSecond);
  ASSERT_TRUE(same && other);
  EXPECT_TRUE((*one)->shares_screen_with(**same));
  if ((*one)->renderer().find("llvmpipe") == std::string::npos) GTEST_SKIP() << "this is " << (*one)->renderer();
  EXPECT_FALSE((*one)->shares_screen_with(**other));
}

}  // namespace
}  // namespace ctn::vr::drawing
