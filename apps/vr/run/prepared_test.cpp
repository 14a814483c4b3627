#include "run/prepared.h"

#include <gtest/gtest.h>

#include <string>

#include "program/text_file.h"
#include "run/testing/small_dataset.h"
#include "run/virtual_run.h"

namespace ctn::vr::run {
namespace {

using namespace std::chrono_literals;

class PreparedWithADataSet : public ::testing::Test {
 protected:
  Options prepared(double seconds = 1.0) const {
    Options options;
    options.dataset = dataset_.folder();
    options.seconds = seconds;
    const auto made = Prepared::make(options);
    EXPECT_TRUE(made.ok()) << (made.ok() ? "" : made.error().message());
    if (!made.ok()) return options;
    app_ = program::text_of_file(made->options().app_file).value_or("");
    return made->options();
  }
  // What runs of a batch must have in common.
  std::string fingerprint() const {
    const Options options = prepared();
    const auto found = options.inputs.find("dataset");
    return found == options.inputs.end() ? "none" : found->second;
  }

  // 25 pictures a second, the third of which was lost.
  testing::SmallDataset dataset_{{7ms, 47ms, 127ms, 167ms, 1207ms}, {0ms, 3s}};
  mutable std::string app_;
};

TEST_F(PreparedWithADataSet, ItsFilesAreAmongTheInputs) {
  const std::string before = fingerprint();
  EXPECT_NE(before, "none");
  EXPECT_EQ(fingerprint(), before);
  std::string last = before;
  for (const char* file : {"cam0/data/47000000.png", "state_groundtruth_estimate0/data.csv"}) {
    dataset_.write(file, "");
    if (std::string(file).starts_with("state")) {
      dataset_.write(file, "1403715273262142976,0,0,0,1,0,0,0,0,0,0,0,0,0,0,0,0\n");
    }
    EXPECT_NE(fingerprint(), last) << file;
    last = fingerprint();
  }
  dataset_.write("cam0/data/1207000000.png", "");
  EXPECT_EQ(fingerprint(), last) << "no run of a second sees it";
}

// Guards: the inertial unit was taken for one of 200 Hz, so that the floors of its chains were wrong.
TEST_F(PreparedWithADataSet, TheInertialUnitsRateIsThatOfItsSamples) {
  EXPECT_EQ(prepared().recorded_samples, 5ms);
  std::string samples;
  for (int i = 0; i <= 300; ++i) {
    if (i == 7) continue;  // one was lost
    samples += std::to_string(1403715273262142976 + i * 10'000'000LL) + ",0,0,0,9.81,0,0\n";
  }
  dataset_.write("imu0/data.csv", samples);
  const Options options = prepared();
  EXPECT_EQ(options.recorded_samples, 10ms);
  EXPECT_NE(app_.find("IMU: { unscheduled: true, period: 10000000ns }   # 100 Hz"), std::string::npos) << app_;
  EXPECT_EQ(clocks_of(options).samples.period, 10ms);
  EXPECT_EQ(clocks_as_in_life(options).samples.first, 10ms);
}

TEST_F(PreparedWithADataSet, TheCamerasClockIsThatOfItsPictures) {
  const Options options = prepared();
  EXPECT_NE(app_.find("exposure: { external: true, period: 40000000ns }"), std::string::npos) << app_;
  EXPECT_NE(app_.find("Camera: { max_rate: 60Hz, fallback_rate: 25Hz }"), std::string::npos) << app_;
  for (const DrawnClocks& clocks : {clocks_of(options), clocks_as_in_life(options)}) {
    EXPECT_EQ(clocks.exposures.period, 40ms);
    EXPECT_EQ(clocks.exposures.next(clocks.samples.first), clocks.samples.first + 7ms);
  }
}

}  // namespace
}  // namespace ctn::vr::run
