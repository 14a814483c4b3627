#include "experiment.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>
#include <tuple>

#include "runner.h"

namespace ctn::demo {
namespace {

constexpr Compute kUsual{25.0, 57.5, 1.0};

Setting two_cores() {
  Setting setting;
  setting.cpu_sets = {{1}, {0, 1}};
  return setting;
}

TEST(SweepRates, LieAroundTheRateThatTheCoresKeepUpWith) {
  for (const std::size_t cores : {1U, 2U}) {
    const double keeps_up = cores == 1 ? 1000.0 / 83.5 : 1000.0 / 57.5;
    const auto rates = sweep_rates(kUsual, cores, false);
    ASSERT_GE(rates.size(), 4U);
    EXPECT_TRUE(std::ranges::is_sorted(rates));
    EXPECT_LT(rates.front(), 0.6 * keeps_up);
    EXPECT_GT(rates.back(), keeps_up);
    EXPECT_LT(rates.back(), kDefaultRate);
  }
}

TEST(SweepRates, StayBelowTheDefaultOnAFastMachine) {
  EXPECT_THAT(sweep_rates({5.0, 10.0, 0.2}, 2, false), testing::Each(testing::Lt(kDefaultRate)));
}

// But for the last, which has no rates that are set by hand.
TEST(MakeTrials, EveryRoundHasEveryConfigurationOnce) {
  const auto trials = make_trials(two_cores(), kUsual);
  using Configuration = std::tuple<std::size_t, std::string, double>;
  std::multiset<std::pair<int, Configuration>> seen;
  std::set<Configuration> configurations;
  for (const Trial& trial : trials) {
    const Configuration configuration{trial.cpus.size(), trial.scheduler, trial.speed};
    configurations.insert(configuration);
    seen.insert({trial.round, configuration});
  }
  const auto by_hand = [](const Configuration& one) { return std::get<std::string>(one).starts_with("rate:"); };
  EXPECT_EQ(trials.size(),
            3 * configurations.size() - static_cast<std::size_t>(std::ranges::count_if(configurations, by_hand)));
  for (int round = 1; round <= 3; ++round) {
    for (const auto& configuration : configurations) {
      EXPECT_EQ(seen.count({round, configuration}), round == 3 && by_hand(configuration) ? 0U : 1U);
    }
  }
  EXPECT_TRUE(configurations.contains({1, "default", 1.5}));
  EXPECT_TRUE(configurations.contains({2, "catan", 1.0}));
}

TEST(MakeTrials, ARoundIsOneWalk) {
  for (const Trial& trial : make_trials(two_cores(), kUsual)) {
    EXPECT_EQ(trial.seed, static_cast<std::uint64_t>(trial.round));
  }
}

TEST(MakeTrials, KeepTheBudget) {
  for (const std::size_t sets : {1U, 2U}) {
    Setting setting = two_cores();
    setting.cpu_sets.resize(sets);
    double total = 0.0;
    for (const Trial& trial : make_trials(setting, kUsual)) total += trial.seconds + setting.overhead;
    EXPECT_LE(total, setting.budget);
    EXPECT_GT(total, 0.75 * setting.budget);
  }
}

TEST(MakeTrials, ASlowMachineGetsFewerRounds) {
  Setting setting = two_cores();
  setting.overhead = 6.0;
  double total = 0.0;
  for (const Trial& trial : make_trials(setting, kUsual)) total += trial.seconds + setting.overhead;
  EXPECT_LE(total, setting.budget);
}

TEST(MakeTrials, QuickIsQuick) {
  Setting setting = two_cores();
  setting.cpu_sets.resize(1);
  setting.quick = true;
  EXPECT_LE(make_trials(setting, kUsual).size(), 3U);
}

TEST(CommandLine, IsQuotedForTheShell) {
  const Trial trial{1, {0, 2}, "rate:11.4Hz", 1.5, 7, 2.5};
  EXPECT_EQ(
      command_line({"/a b/it's", 2.0, "out/faces.png", "log"}, trial),
      "'/a b/it'\\''s' --json --scheduler 'rate:11.4Hz' --cpus 0,2 --seconds 2.5 --speed 1.5 --seed 7 --slowdown 2 "
      "--faces 'out/faces.png'");
}

TEST(RunTrial, TellsWhenTheProgramFails) {
  const auto run = run_trial({"/nowhere/face_tracking", 1.0, "", "/dev/null"}, {1, {0}, "catan", 1.0, 1, 1.0});
  ASSERT_FALSE(run.ok());
  EXPECT_NE(run.error().message().find("127"), std::string::npos);
}

}  // namespace
}  // namespace ctn::demo
