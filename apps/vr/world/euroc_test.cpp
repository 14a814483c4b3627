#include "world/euroc.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

namespace ctn::vr::world {
namespace {

const char* const kImu =
    "#timestamp [ns],w_x,w_y,w_z,a_x,a_y,a_z\n"
    "1403715273262142976,-0.002,0.017,0.077,9.087,0.13,-3.69\r\n"
    "1403715273267142912,1e-3,2,+3,4,5,6\n";
const char* const kPictures = "#timestamp [ns],filename\n1403715273262142976,a.png\n\n1403715273312143104, b.png\n";
const char* const kCamera =
    "%YAML:1.0\n"
    "sensor_type: camera\n"
    "T_BS:\n"
    "  cols: 4\n"
    "  rows: 4\n"
    "  data: [0.0, -1.0, 0.0, -0.02,\n"
    "         1.0, 0.0, 0.0, -0.06,\n"
    "         0.0, 0.0, 1.0, 0.01,\n"
    "         0.0, 0.0, 0.0, 1.0]\n"
    "rate_hz: 20\n"
    "resolution: [752, 480]\n"
    "camera_model: pinhole\n"
    "intrinsics: [458.654, 457.296, 367.215, 248.375] #fu, fv, cu, cv\n"
    "distortion_model: radial-tangential\n"
    "distortion_coefficients: [-0.28, 0.07, 0.0002, 1.8e-05]\n";
const char* const kTruth =
    "#time,...\n"
    "1403715273262142976,1,2,3,0.5,-0.5,0.5,-0.5,4,5,6,0.1,0.2,0.3,0.4,0.5,0.6\n"
    "1403715273362142976,1.5,2,3,0.5,-0.5,0.5,-0.5,4,5,6,0.1,0.2,0.3,0.4,0.5,0.6\n";

class EurocFolder : public testing::Test {
 protected:
  void SetUp() override {
    write("mav0/imu0/data.csv", kImu);
    write("mav0/cam0/data.csv", kPictures);
    write("mav0/cam0/sensor.yaml", kCamera);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  void write(const std::string& name, const std::string& text) const {
    const std::filesystem::path path = folder_ / name;
    std::filesystem::create_directories(path.parent_path());
    std::ofstream(path) << text;
  }
  std::string folder() const { return folder_.string(); }

 private:
  std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() /
      ("euroc_test." + std::to_string(getpid()) + "." + testing::UnitTest::GetInstance()->current_test_info()->name());
};

TEST_F(EurocFolder, IsRead) {
  write("mav0/state_groundtruth_estimate0/data.csv", kTruth);
  const auto data = read_euroc(folder());
  ASSERT_TRUE(data) << data.error().message();
  EXPECT_EQ(data->origin, 1403715273262142976);
  ASSERT_EQ(data->imu.size(), 2U);
  EXPECT_EQ(data->imu[0].time, 0.0);
  EXPECT_EQ(data->imu[1].time, 4999936e-9);
  EXPECT_EQ(data->imu[1].angular_rate, Eigen::Vector3d(1e-3, 2.0, 3.0));
  EXPECT_EQ(data->imu[1].acceleration, Eigen::Vector3d(4.0, 5.0, 6.0));
  ASSERT_EQ(data->pictures.size(), 2U);
  EXPECT_EQ(data->pictures[1].time, 50000128e-9);
  EXPECT_EQ(data->pictures[1].path, folder() + "/mav0/cam0/data/b.png");
  EXPECT_EQ(data->camera.width, 752);
  EXPECT_EQ(data->camera.fy, 457.296);
  EXPECT_EQ(data->camera.p2, 1.8e-5);
  EXPECT_EQ(data->camera.body_from_camera.position, Eigen::Vector3d(-0.02, -0.06, 0.01));
  EXPECT_LT((data->camera.body_from_camera.orientation * Eigen::Vector3d(1, 0, 0) - Eigen::Vector3d(0, 1, 0)).norm(),
            1e-12);
  ASSERT_EQ(data->truth.size(), 2U);
  EXPECT_EQ(data->truth[1].time, 0.1);
  EXPECT_EQ(data->truth[1].pose.position.x(), 1.5);
  EXPECT_EQ(data->truth[0].pose.orientation.x(), -0.5);
  EXPECT_EQ(data->truth[0].velocity, Eigen::Vector3d(4.0, 5.0, 6.0));
  EXPECT_EQ(data->truth[0].gyro_bias, Eigen::Vector3d(0.1, 0.2, 0.3));
  EXPECT_EQ(data->truth[0].accelerometer_bias, Eigen::Vector3d(0.4, 0.5, 0.6));
  EXPECT_TRUE(read_euroc(folder() + "/mav0"));
  EXPECT_EQ(poses_of(data->truth)[1].time, 0.1);
}

TEST_F(EurocFolder, MayHaveNoTruth) {
  const auto data = read_euroc(folder());
  ASSERT_TRUE(data) << data.error().message();
  EXPECT_TRUE(data->truth.empty());
}

TEST_F(EurocFolder, TellsWhatIsWrongInAllFiles) {
  write("mav0/imu0/data.csv", "1,0,0,0,0,0\n");
  std::filesystem::remove(folder() + "/mav0/cam0/data.csv");
  const auto data = read_euroc(folder());
  ASSERT_FALSE(data);
  EXPECT_EQ(data.error().kind(), ErrorKind::kCaller);
  EXPECT_NE(data.error().message().find("imu0/data.csv:1: 6 fields in place of 7"), std::string::npos)
      << data.error().message();
  EXPECT_NE(data.error().message().find("no file " + folder() + "/mav0/cam0/data.csv"), std::string::npos);
}

TEST(Euroc, OfAFolderThatIsNone) {
  const auto data = read_euroc("/proc");
  ASSERT_FALSE(data);
  EXPECT_NE(data.error().message().find("mav0/imu0"), std::string::npos);
}

template <class Parsed>
std::string error_of(const Parsed& parsed) {
  return parsed ? "no error" : parsed.error().message();
}

TEST(Euroc, MistakesHaveTheirLines) {
  const auto imu = [](const char* text) { return error_of(parse_euroc_imu(text, "f")); };
  EXPECT_THAT(imu(""), testing::StartsWith("f:1: there is no data in the file"));
  EXPECT_THAT(imu("#a\n\n5,0,0,x,0,0,0\n"), testing::StartsWith("f:3: 'x' is not a number (field 4)"));
  EXPECT_THAT(imu("5,0,0,nan,0,0,0"), testing::StartsWith("f:1: 'nan' is not a number"));
  EXPECT_THAT(imu("5,0,0,,0,0,0"), testing::StartsWith("f:1: '' is not a number"));
  EXPECT_THAT(imu("5.5,0,0,0,0,0,0"), testing::StartsWith("f:1: '5.5' is not a time"));
  EXPECT_THAT(imu("-5,0,0,0,0,0,0"), testing::StartsWith("f:1: '-5' is not a time"));
  EXPECT_THAT(imu("5,0,0,0,0,0,0\n5,0,0,0,0,0,0"), testing::StartsWith("f:2: 5 is not after the time"));
  EXPECT_THAT(imu("99999999999999999999,0,0,0,0,0,0"), testing::HasSubstr("is not a time"));
  EXPECT_THAT(error_of(parse_euroc_pictures("5,../x.png", "f")), testing::StartsWith("f:1: '../x.png' is no name"));
  EXPECT_THAT(error_of(parse_euroc_truth("5,1,2,3,1,1,0,0,0,0,0,0,0,0,0,0,0", "f")),
              testing::StartsWith("f:1: the orientation's length is 1.414"));
}

TEST(Euroc, TellsTheFirstTenMistakes) {
  std::string text;
  for (int i = 0; i < 50; ++i) text += "wrong\n";
  const auto parsed = parse_euroc_imu(text, "f");
  ASSERT_FALSE(parsed);
  EXPECT_EQ(parsed.error().problems().size(), 10U);
}

TEST(Euroc, MistakesInCamerasHaveTheirLines) {
  const auto with = [](const std::string& from, const std::string& to) {
    std::string text = kCamera;
    text.replace(text.find(from), from.size(), to);
    return error_of(parse_euroc_camera(text, "f"));
  };
  EXPECT_THAT(with("752, 480", "752"), testing::StartsWith("f:11:13: resolution: there should be 2 numbers"));
  EXPECT_THAT(with("752, 480", "752, 0.5"), testing::StartsWith("f:11:13: resolution: a side of 0.5 pixels"));
  EXPECT_THAT(with("pinhole", "omni"), testing::StartsWith("f:12:15: camera_model"));
  EXPECT_THAT(with("radial-tangential", "equidistant"), testing::StartsWith("f:14:19: distortion_model"));
  EXPECT_THAT(with("458.654", "-1"), testing::StartsWith("f:13:13: intrinsics: focal lengths"));
  EXPECT_THAT(with("0.0, -1.0, 0.0, -0.02", "0.0, -2.0, 0.0, -0.02"), testing::StartsWith("f:6:9: T_BS.data"));
  EXPECT_THAT(with("T_BS", "T_SB"), testing::HasSubstr("T_BS: where the camera is"));
  EXPECT_THAT(with("[752", "[[752"), testing::HasSubstr("this is not YAML"));
  EXPECT_THAT(error_of(parse_euroc_camera("[1, 2]", "f")), testing::HasSubstr("no description of a camera"));
}

// CATAN_EUROC names a folder with a data set of EuRoC's.
TEST(Euroc, ReadsADataSet) {
  const char* folder = std::getenv("CATAN_EUROC");
  if (folder == nullptr) GTEST_SKIP() << "CATAN_EUROC names no data set of EuRoC's";
  const auto data = read_euroc(folder);
  ASSERT_TRUE(data) << data.error().message();
  EXPECT_GT(data->imu.size(), 100U);
  EXPECT_GT(data->pictures.size(), 10U);
  for (const PictureFile& picture : data->pictures) EXPECT_TRUE(std::filesystem::exists(picture.path)) << picture.path;
  // At rest or not, over seconds it feels gravity.
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  for (const ImuSample& sample : data->imu) force += sample.acceleration / static_cast<double>(data->imu.size());
  EXPECT_NEAR(force.norm(), kGravity, 1.0);
  if (data->truth.empty()) return;
  const RecordedTrajectory trajectory(poses_of(data->truth));
  for (double time = 0.5; time < trajectory.duration() - 0.5; time += 0.1) {
    EXPECT_LT(trajectory.at(time).acceleration.norm(), 30.0);
    EXPECT_LT(trajectory.at(time).angular_rate.norm(), 10.0);
  }
}

}  // namespace
}  // namespace ctn::vr::world
