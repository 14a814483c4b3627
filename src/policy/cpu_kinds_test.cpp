#include "policy/cpu_kinds.h"

#include <gtest/gtest.h>

#include "config/testing/apps.h"

namespace ctn::policy {
namespace {

graph::App with_kinds(std::vector<graph::CoreKind> kinds) {
  graph::App app = tracker_app();
  app.core_kinds = std::move(kinds);
  return app;
}

TEST(CpuKinds, WithoutKindsAllAreAlikeHoweverMany) {
  const graph::App app = tracker_app();
  EXPECT_TRUE(CpuKinds::fits(app, os::CpuSet{0, 7}).ok());
  EXPECT_EQ(CpuKinds(app, os::CpuSet{0, 7}).of(7), 0U);
}

TEST(CpuKinds, CoreKIsTheKthCpu) {
  const graph::App app = with_kinds({{"big", 1, 1.0}, {"little", 2, 0.5}});
  const os::CpuSet cpus{1, 4, 6};
  ASSERT_TRUE(CpuKinds::fits(app, cpus).ok());
  const CpuKinds kinds(app, cpus);
  EXPECT_EQ(kinds.of(1), 0U);
  EXPECT_EQ(kinds.of(4), 1U);
  EXPECT_EQ(kinds.of(6), 1U);
  EXPECT_EQ(kinds.of(-1), 0U);
  EXPECT_EQ(kinds.of_kind(1, cpus), (os::CpuSet{4, 6}));
}

TEST(CpuKinds, OtherCountsAreRefusedWithBothNumbers) {
  const Status fits = CpuKinds::fits(with_kinds({{"big", 1, 1.0}, {"little", 2, 0.5}}), os::CpuSet{0, 1});
  ASSERT_FALSE(fits.ok());
  EXPECT_EQ(fits.error().kind(), ErrorKind::kCaller);
  EXPECT_NE(fits.error().message().find("3 cores (1 big, 2 little), but the session has 2 CPUs: 0-1"),
            std::string::npos)
      << fits.error().message();
}

TEST(CpuKinds, ACpuThatIsGoneIsTakenFromItsKind) {
  const graph::App app = with_kinds({{"big", 1, 1.0}, {"little", 2, 0.5}});
  const CpuKinds kinds(app, os::CpuSet{0, 1, 2});
  const graph::App without_big = kinds.only_with(app, os::CpuSet{1, 2});
  EXPECT_EQ(without_big.core_kinds[0].count, 0);
  EXPECT_EQ(without_big.kind_of(0), 1U);
  EXPECT_EQ(kinds.only_with(app, os::CpuSet{0, 2}).core_kinds[1].count, 1);
}

}  // namespace
}  // namespace ctn::policy
