// VIO on a piece of the EuRoC data set, which is no part of the project: CATAN_EUROC names the folder that has mav0.
#include "world/euroc.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <vector>

#include <opencv2/imgcodecs.hpp>

#include "vio/trajectory_error.h"
#include "vio/vio.h"

namespace ctn::vr {
namespace {

TEST(Euroc, VioIsWithin30Centimetres) {
  const char* const folder = std::getenv("CATAN_EUROC");
  if (folder == nullptr) GTEST_SKIP() << "set CATAN_EUROC to the folder of a EuRoC sequence, which has mav0 in it";
  const Result<world::Euroc> euroc = world::read_euroc(folder);
  ASSERT_TRUE(euroc) << euroc.error().message();
  const CameraModel& model = euroc->camera;
  Camera camera(model);
  Vio vio(model);
  // Sequences begin at rest or not.
  vio.start(euroc->truth.front(), {.tilt = 0.02, .accelerometer_bias = 0.05});
  std::vector<StampedPose> estimated;
  std::vector<StampedPose> truth;
  for (const State& state : euroc->truth) truth.push_back({state.time, state.pose});
  std::size_t next = 0;
  for (const world::PictureFile& picture : euroc->pictures) {
    for (; next < euroc->imu.size() && euroc->imu[next].time <= picture.time; ++next) {
      vio.add(euroc->imu[next]);
    }
    const Result<CameraFrame> frame = camera.run(cv::imread(picture.path, cv::IMREAD_GRAYSCALE), picture.time);
    ASSERT_TRUE(frame) << picture.path << ": " << frame.error().message();
    const Vio::Result result = vio.run(*frame);
    if (result.state) estimated.push_back({picture.time, result.state->pose});
  }
  const TrajectoryError error = absolute_error(estimated, truth);
  EXPECT_GT(error.poses, 80U);
  EXPECT_LT(error.position_rmse, 0.3);
  RecordProperty("ate_mm", static_cast<int>(1000.0 * error.position_rmse));
}

}  // namespace
}  // namespace ctn::vr
