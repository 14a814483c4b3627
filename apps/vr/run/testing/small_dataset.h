// For tests: a data set in EuRoC's format of a headset that lies still, three seconds long. Its pictures are none that
// could be opened.
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "program/temporary_folder.h"

namespace ctn::vr::run::testing {

class SmallDataset {
 public:
  // Times since the first inertial sample. `truth`: when poses are known.
  SmallDataset(const std::vector<std::chrono::nanoseconds>& pictures,
               const std::vector<std::chrono::nanoseconds>& truth) {
    auto folder = program::TemporaryFolder::make("small_dataset");
    EXPECT_TRUE(folder.ok());
    folder_ = *folder;
    std::string samples;
    for (int i = 0; i <= 600; ++i) samples += row(i * std::chrono::milliseconds(5), ",0,0,0,9.81,0,0");
    write("imu0/data.csv", samples);
    std::string names;
    for (const auto at : pictures) {
      const std::string name = std::to_string(at.count()) + ".png";
      names += row(at, "," + name);
      write("cam0/data/" + name, "picture " + name);
    }
    write("cam0/data.csv", names);
    write("cam0/sensor.yaml",
          "T_BS:\n  data: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]\nresolution: [64, 48]\n"
          "camera_model: pinhole\nintrinsics: [50, 50, 32, 24]\n"
          "distortion_model: radial-tangential\ndistortion_coefficients: [0, 0, 0, 0]\n");
    std::string poses;
    for (const auto at : truth) poses += row(at, ",0,0,0,1,0,0,0,0,0,0,0,0,0,0,0,0");
    if (!truth.empty()) write("state_groundtruth_estimate0/data.csv", poses);
  }

  std::string folder() const { return folder_->file("mav0"); }
  // Replaces a file: "imu0/data.csv".
  void write(const std::string& name, const std::string& text) const {
    const std::filesystem::path path = std::filesystem::path(folder()) / name;
    std::filesystem::create_directories(path.parent_path());
    std::ofstream(path) << text;
  }

 private:
  static std::string row(std::chrono::nanoseconds at, const std::string& rest) {
    constexpr std::chrono::nanoseconds kFirst{1'403'715'273'262'142'976};
    return std::to_string((kFirst + at).count()) + rest + "\n";
  }

  std::shared_ptr<program::TemporaryFolder> folder_;
};

}  // namespace ctn::vr::run::testing
