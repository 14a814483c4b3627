// The whole app in virtual time. Where nothing can be drawn, these are skipped: the camera's pictures are.
#include "run/virtual_run.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <memory>
#include <string>

#include "program/temporary_folder.h"
#include "run/headset_app.h"

namespace ctn::vr::run {
namespace {

using namespace std::chrono_literals;

class VirtualRun : public ::testing::Test {
 protected:
  void SetUp() override {
    auto folder = program::TemporaryFolder::make("virtual_run_test");
    ASSERT_TRUE(folder.ok());
    folder_ = *folder;
    Options options = short_run("default", 1);
    const auto surroundings = Surroundings::make(options, kImuPeriod);
    ASSERT_TRUE(surroundings.ok());
    const auto exposures = drawn_exposures(**surroundings, std::nullopt);
    if (exposures) return;
    ASSERT_EQ(exposures.error().kind(), ErrorKind::kEnvironment);
    GTEST_SKIP() << exposures.error().message();
  }

  // A little more than it takes until response times are measured.
  static constexpr double kSeconds = 3.2;

  Options short_run(const std::string& scheduler, std::uint64_t seed) const {
    Options options;
    options.virtual_time = true;
    options.scheduler = scheduler;
    options.policy = scheduler == "pacer" ? "fifo" : scheduler;
    options.seconds = kSeconds;
    options.seed = seed;
    options.app_file = folder_->write(scheduler + ".yaml", app_text(options)).value();
    return options;
  }

  static Outcome outcome_of(const Options& options, std::chrono::nanoseconds step = 500ms) {
    Watch watch;
    watch.step = step;
    auto outcome = run_virtually(options, watch);
    EXPECT_TRUE(outcome.ok()) << (outcome.ok() ? "" : outcome.error().message());
    return outcome.ok() ? *outcome : Outcome{};
  }
  static double figure(const Outcome& outcome, const std::string& name) {
    const auto value = program::figure_of(outcome.figures, name);
    EXPECT_TRUE(value) << name;
    return value.value_or(-1.0);
  }

  std::shared_ptr<program::TemporaryFolder> folder_;
};

TEST_F(VirtualRun, IsTheSameEachTimeAndWithAnyStep) {
  const auto document = [this](std::uint64_t seed, std::chrono::nanoseconds step) {
    Options options = short_run("fifo", seed);
    options.seconds = 1.5;
    return to_json(outcome_of(options, step));
  };
  const std::string once = document(1, 500ms);
  EXPECT_EQ(document(1, 70ms), once);
  EXPECT_NE(document(2, 500ms), once);
}

TEST_F(VirtualRun, ShowsWhatIsNearlyTrueUnderEachScheduler) {
  for (const char* scheduler : {"catan", "pacer"}) {
    const Outcome outcome = outcome_of(short_run(scheduler, 1));
    EXPECT_NEAR(figure(outcome, "ticks"), kSeconds / 2.0 * 120.0, 2.0) << scheduler;
    EXPECT_LT(figure(outcome, "error_deg_p95"), 5.0) << scheduler;
    EXPECT_LT(figure(outcome, "vio_ate_m"), 0.1) << scheduler;
    EXPECT_GT(figure(outcome, "vio_hz"), 10.0) << scheduler;
    EXPECT_GE(figure(outcome, "over_floor_percent A"), -1.0) << scheduler << ": as costs vary a little";
    EXPECT_GT(figure(outcome, "response_ms C_mean"), figure(outcome, "response_ms B_mean")) << scheduler;
    EXPECT_FALSE(program::figure_of(outcome.figures, "floor_ms C")) << "a triggered camera has no clock";
  }
}

TEST_F(VirtualRun, ACameraWithItsOwnRateGivesNoPictureTwice) {
  Options options = short_run("default", 3);
  options.seconds = 2.0;
  options.camera_hz = 10.0;
  options.app_file = folder_->write("clocked.yaml", app_text(options)).value();
  const Outcome outcome = outcome_of(options);
  EXPECT_NEAR(figure(outcome, "vio_hz"), 10.0, 0.2);
  EXPECT_GT(figure(outcome, "floor_ms C"), 100.0) << "the camera's period";
  EXPECT_LT(figure(outcome, "floor_ms C"), 160.0);
}

TEST_F(VirtualRun, OneThatIsInterruptedHasNoAlbum) {
  Options options = short_run("default", 1);
  options.pictures = folder_->file("album");
  Watch watch;
  watch.signal = [] { return 2; };
  const auto outcome = run_virtually(options, watch);
  ASSERT_TRUE(outcome.ok()) << outcome.error().message();
  EXPECT_EQ(outcome->signal, 2);
  EXPECT_FALSE(std::filesystem::exists(options.pictures));
}

TEST(DrawnClocks, AreInLifeThoseThatFollowFromTheSessionsStart) {
  Options options;
  options.seed = 5;
  const DrawnClocks drawn = clocks_of(options);
  const DrawnClocks life = clocks_as_in_life(options);
  EXPECT_EQ(life.samples.first, kImuPeriod);
  EXPECT_EQ(life.display.first, kImuPeriod - kSampleLead + drawn.display.first) << "as LiveHeadset counts";
  EXPECT_EQ(life.exposures.first, kImuPeriod - kSampleLead + drawn.exposures.first);
}

TEST(DrawnClocks, FollowFromTheSeedAndDriftAsMuchAsIsAsked) {
  Options options;
  options.seed = 5;
  const DrawnClocks still = clocks_of(options);
  EXPECT_EQ(still.samples.period, kImuPeriod);
  EXPECT_EQ(still.display.period, options.display_period());
  EXPECT_EQ(clocks_of(options).display.first, still.display.first);
  options.drift_ppm = 100.0;
  const DrawnClocks drifting = clocks_of(options);
  EXPECT_NE(drifting.display.period, still.display.period);
  EXPECT_LE(std::chrono::abs(drifting.display.period - still.display.period), 834ns);
  options.seed = 6;
  EXPECT_NE(clocks_of(options).display.first, drifting.display.first);
}

}  // namespace
}  // namespace ctn::vr::run
