#include "run/findings.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "run/testing/small_dataset.h"

namespace ctn::vr::run {
namespace {

using namespace std::chrono_literals;
using std::chrono::nanoseconds;

// Samples at 0, 5, 10, ... ms, ticks at 3, 13, 23, ... ms, 1 ms of computing: each tick has a sample that is 3 ms old,
// and the one before that reached the display is 10 ms older.
TEST(Floor, IsThePeriodTheWaitAndTheCost) {
  EXPECT_NEAR(floor_ms({0ms, 5ms}, {3ms, 10ms}, 1ms), 13.0, 1e-9);
  EXPECT_NEAR(floor_ms({0ms, 5ms}, {3ms, 10ms}, 4ms), 18.0, 1e-9) << "too late for that sample";
}

// A display that ticks more often than there are samples: every other tick has something new.
TEST(Floor, DoesNotCountTicksWithNothingNew) { EXPECT_NEAR(floor_ms({0ms, 5ms}, {1ms, 2500us}, 500us), 6.0, 1e-9); }

// A camera at 20 Hz and a display at 100 Hz: a picture that is 25 ms old and the next one, 50 ms later.
TEST(Floor, IsThatOfASlowCameraToo) { EXPECT_NEAR(floor_ms({5ms, 50ms}, {0ms, 10ms}, 22ms), 75.0, 1e-9); }

// The same: exposures at 5, 55, ... ms, and the one before is 75 ms old when a picture is shown. Int has to wait for a
// sample, and a picture for the one before.
TEST(Floor, OfACameraIsThatOfTheCostsOfItsPictures) {
  const Clock exposures{5ms, 50ms};
  const Clock display{0ms, 10ms};
  const Clock each_ms{0ms, 1ms};
  EXPECT_NEAR(camera_floor_ms(exposures, {20ms}, {each_ms, 1ms, 1ms}, display), 75.0, 1e-9);
  EXPECT_NEAR(camera_floor_ms(exposures, {20ms}, {{4ms, 10ms}, 0ms, 1ms}, display), 85.0, 1e-9)
      << "25 is after the sample at 24";
  EXPECT_NEAR(camera_floor_ms(exposures, {20ms}, {{4ms, 10ms}, 1ms, 1ms}, display), 75.0, 1e-9)
      << "before Int begins with it";
  EXPECT_NEAR(camera_floor_ms(exposures, {20ms, 30ms}, {each_ms, 1ms, 1ms}, display), 80.0, 0.01)
      << "75 and 85 in turn";
  EXPECT_NEAR(camera_floor_ms(exposures, {70ms, 20ms}, {each_ms, 1ms, 1ms}, display), 110.0, 0.01)
      << "shown at 80 and 100, and so on: the second waits for the first";
}

class Findings : public ::testing::Test {
 protected:
  void SetUp() override {
    options_.seconds = 8.0;
    auto made = Surroundings::make(options_, 5ms);
    ASSERT_TRUE(made.ok());
    surroundings_ = std::move(made).value();
  }
  // Shown at a tick: what was true so long before.
  Photon photon(nanoseconds tick, nanoseconds old) const {
    Photon photon;
    photon.tick = tick;
    photon.fresh = true;
    photon.picture.drawn = *surroundings_->true_eye(tick - old);
    photon.picture.warped = photon.picture.drawn;
    photon.picture.known = *surroundings_->true_eye(tick - 4ms);
    photon.picture.warped_stamp = tick - 4ms;
    photon.picture.drawn_stamp = tick - 9ms;
    return photon;
  }
  std::optional<double> figure(const Happened& happened, const std::string& name) const {
    return program::figure_of(figures_of(happened, *surroundings_, false), name);
  }

  Options options_;
  std::unique_ptr<const Surroundings> surroundings_;
};

TEST_F(Findings, TheTruthHasNoError) {
  const Happened happened{{photon(5s, 0ns), photon(6s, 0ns)}, {}, 8s};
  EXPECT_NEAR(*figure(happened, "error_deg_p95"), 0.0, 1e-6);
  EXPECT_NEAR(*figure(happened, "error_px_p95"), 0.0, 1e-6);
  EXPECT_EQ(figure(happened, "ticks"), 2.0);
  EXPECT_EQ(figure(happened, "ticks_missed"), 0.0);
  EXPECT_EQ(figure(happened, "photon_age_ms rotation_mean"), 4.0);
  EXPECT_EQ(figure(happened, "photon_age_ms translation_mean"), 9.0);
  EXPECT_EQ(figure(happened, "photon_age_ms camera_mean"), std::nullopt);
  EXPECT_EQ(figure(happened, "vio_ate_m"), std::nullopt);
}

TEST_F(Findings, WhatIsShownIsTheOrientationThatWasWarpedTo) {
  Photon turned = photon(5s, 0ns);
  const double angle = 2.0 * std::numbers::pi / 180.0;
  turned.picture.warped.orientation =
      turned.picture.warped.orientation * Eigen::Quaterniond(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitX()));
  EXPECT_NEAR(*figure({{turned}, {}, 8s}, "error_deg_mean"), 2.0, 1e-6);
  EXPECT_GT(*figure({{turned}, {}, 8s}, "error_px_mean"), 160.0 * angle) << "320 pixels are 90 degrees";
}

// A headset that has lost its way, but knows how it moves.
TEST_F(Findings, TheErrorOfAgeKnowsNothingOfDrift) {
  Photon drifted = photon(5s, 0ns);
  Pose drift;
  drift.orientation = Eigen::Quaterniond(Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitZ()));
  drift.position = {0.2, 0.0, 0.0};
  for (Pose* pose : {&drifted.picture.drawn, &drifted.picture.warped, &drifted.picture.known}) {
    *pose = transformed(drift, *pose);
  }
  EXPECT_NEAR(*figure({{drifted}, {}, 8s}, "age_error_deg_mean"), 0.0, 1e-6);
  EXPECT_NEAR(*figure({{drifted}, {}, 8s}, "age_error_px_mean"), 0.0, 1e-6);
  EXPECT_NEAR(*figure({{drifted}, {}, 8s}, "error_deg_mean"), 0.1 * 180.0 / std::numbers::pi, 1e-6);
  EXPECT_NEAR(*figure({{photon(5s, 20ms)}, {}, 8s}, "age_error_deg_mean"),
              *figure({{photon(5s, 20ms)}, {}, 8s}, "error_deg_mean"), 1e-6)
      << "without drift there is nothing else";
}

TEST_F(Findings, OfTheFirstSecondsDoNotCount) {
  Photon early = photon(1s, 30ms);
  early.fresh = false;
  const Happened happened{{early, photon(5s, 0ns)}, {}, 20s};
  EXPECT_EQ(figure(happened, "ticks"), 1.0);
  EXPECT_EQ(figure(happened, "ticks_missed"), 0.0);
}

TEST_F(Findings, TrackingIsComparedWithTheTruth) {
  Happened happened{{}, {}, 8s};
  for (int i = 0; i < 40; ++i) {
    const nanoseconds exposed = 4s + i * 50ms;
    happened.tracked.push_back({exposed + 30ms, exposed, *surroundings_->truth(exposed), 20ms});
  }
  happened.tracked.front().at = 3s;
  EXPECT_EQ(costs_of_tracking(happened), std::vector<nanoseconds>(39, 20ms)) << "but the first, which does not count";
  happened.tracked.front().at = 4030ms;
  EXPECT_NEAR(*figure(happened, "vio_ate_m"), 0.0, 1e-9);
  EXPECT_EQ(figure(happened, "vio_age_ms_mean"), 30.0);
  EXPECT_NEAR(*figure(happened, "vio_hz"), 20.0, 1e-9);
  happened.tracked[7].pose.position.x() += 0.1;
  EXPECT_NEAR(*figure(happened, "vio_ate_m"), 0.1 / std::sqrt(40.0), 2e-3);
}

// A data set whose truth ends before it does. The wearer is a metre from where the truth ends.
TEST(FindingsOfADataSet, WhatIsBeyondItsTruthDoesNotCount) {
  const testing::SmallDataset dataset({0ms}, {0s, 2s});
  Options options;
  options.dataset = dataset.folder();
  const auto surroundings = Surroundings::make(options, 5ms);
  ASSERT_TRUE(surroundings.ok()) << surroundings.error().message();
  Happened happened{{}, {}, 3s};
  for (const nanoseconds at : {1900ms, 2500ms}) {
    Pose body = *(*surroundings)->truth(1s);
    Photon photon;
    photon.tick = at;
    photon.picture.drawn = photon.picture.warped = photon.picture.known = *(*surroundings)->true_eye(1s);
    photon.picture.warped_stamp = photon.picture.drawn_stamp = at;
    if (at > 2s) {
      body.position.x() += 1.0;
      photon.picture.warped.orientation =
          photon.picture.warped.orientation * Eigen::Quaterniond(Eigen::AngleAxisd(1.0, Eigen::Vector3d::UnitX()));
    }
    happened.photons.push_back(photon);
    happened.tracked.push_back({at, at, body, 20ms});
  }
  const auto figures = figures_of(happened, **surroundings, false);
  EXPECT_NEAR(*program::figure_of(figures, "vio_error_m_mean"), 0.0, 1e-6);
  EXPECT_NEAR(*program::figure_of(figures, "vio_ate_m"), 0.0, 1e-6);
  EXPECT_NEAR(*program::figure_of(figures, "error_deg_mean"), 0.0, 1e-6);
  EXPECT_EQ(program::figure_of(figures, "ticks"), 2.0) << "ticks and ages are known without the truth";
}

}  // namespace
}  // namespace ctn::vr::run
