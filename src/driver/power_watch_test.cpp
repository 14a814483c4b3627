#include "driver/power_watch.h"

#include <gtest/gtest.h>

#include "config/testing/apps.h"

namespace ctn::driver {
namespace {

os::PowerState limits(std::vector<long> khz, std::optional<bool> on_mains = true) {
  os::PowerState state;
  state.on_mains = on_mains;
  for (std::size_t cpu = 0; cpu < khz.size(); ++cpu) {
    if (khz[cpu] > 0) state.cpus.push_back({static_cast<int>(cpu), khz[cpu], "performance"});
  }
  return state;
}

using Factors = std::vector<std::optional<double>>;

TEST(PowerWatch, TheFirstLookAndTheSameAgainAreNoChange) {
  PowerWatch watch({}, 1);
  EXPECT_FALSE(watch.update(limits({2000000, 2000000})));
  EXPECT_FALSE(watch.update(limits({2000000, 2000000})));
}

TEST(PowerWatch, AHalvedClockDoublesComputeTimes) {
  PowerWatch watch({}, 1);
  watch.update(limits({2000000, 2000000}));
  const auto change = watch.update(limits({1000000, 1000000}));
  ASSERT_TRUE(change);
  EXPECT_EQ(change->what, "CPU 0 2000 MHz -> 1000 MHz; CPU 1 2000 MHz -> 1000 MHz");
  EXPECT_EQ(change->factors, Factors{2.0});
  EXPECT_EQ(watch.update(limits({2000000, 2000000}))->factors, Factors{0.5});
}

TEST(PowerWatch, CpusThatChangeApartLeaveItOpen) {
  PowerWatch watch({}, 1);
  watch.update(limits({2000000, 2000000}));
  EXPECT_EQ(watch.update(limits({2000000, 1000000}))->factors, Factors{std::nullopt});
}

TEST(PowerWatch, KindsChangeApart) {
  graph::App app = tracker_app();
  app.core_kinds = {{"big", 1, 1.0}, {"little", 1, 0.5}};
  PowerWatch watch(policy::CpuKinds(app, os::CpuSet{0, 1}), 2);
  watch.update(limits({2000000, 1000000}));
  EXPECT_EQ(watch.update(limits({1500000, 1000000}))->factors, (Factors{2000.0 / 1500.0, 1.0}));
}

TEST(PowerWatch, BatteryAloneSaysNothingOfHowMuch) {
  PowerWatch watch({}, 1);
  watch.update(limits({2000000}, true));
  const auto change = watch.update(limits({2000000}, false));
  ASSERT_TRUE(change);
  EXPECT_EQ(change->what, "on battery");
  EXPECT_EQ(change->factors, Factors{std::nullopt});
  EXPECT_FALSE(watch.update(limits({2000000}, std::nullopt))) << "not told is not changed";
}

TEST(PowerWatch, ACpuThatIsOfflineForAWhileHasNotChanged) {
  PowerWatch watch({}, 1);
  watch.update(limits({2000000, 2000000}));
  EXPECT_FALSE(watch.update(limits({2000000, 0})));
  EXPECT_FALSE(watch.update(limits({2000000, 2000000})));
}

}  // namespace
}  // namespace ctn::driver
