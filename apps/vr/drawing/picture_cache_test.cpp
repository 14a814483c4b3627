#include "drawing/picture_cache.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <thread>

#include <opencv2/imgcodecs.hpp>

namespace ctn::vr::drawing {
namespace {

using std::chrono::nanoseconds;

class PictureCacheTest : public testing::Test {
 protected:
  void SetUp() override {
    camera_.width = 64;
    camera_.height = 48;
    for (std::size_t i = 0; i < std::size_t{64} * 48; ++i) picture_.push_back(static_cast<std::uint8_t>(i * i / 7));
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  PictureCache open(std::uint64_t key = 5) const { return PictureCache::open(folder_, key, camera_).value(); }
  std::ptrdiff_t files(const PictureCache& cache) const {
    const auto folder = std::filesystem::path(cache.file_of(nanoseconds(0))).parent_path();
    return std::distance(std::filesystem::directory_iterator(folder), std::filesystem::directory_iterator());
  }

  std::string folder_ =
      (std::filesystem::temp_directory_path() / ("picture_cache_test." + std::to_string(getpid()) + "." +
                                                 testing::UnitTest::GetInstance()->current_test_info()->name()))
          .string();
  CameraModel camera_;
  std::vector<std::uint8_t> picture_;
};

TEST_F(PictureCacheTest, KeepsPictures) {
  const PictureCache cache = open();
  std::vector<std::uint8_t> read;
  EXPECT_FALSE(cache.read(nanoseconds(50), read));
  ASSERT_TRUE(cache.write(nanoseconds(50), picture_));
  ASSERT_TRUE(open().read(nanoseconds(50), read));  // in a later run
  EXPECT_EQ(read, picture_);
  EXPECT_FALSE(cache.read(nanoseconds(51), read));
  EXPECT_FALSE(open(6).read(nanoseconds(50), read));
  EXPECT_EQ(files(cache), 1);
  EXPECT_FALSE(cv::imread(cache.file_of(nanoseconds(50)), cv::IMREAD_UNCHANGED).empty());  // any program can show it
}

TEST_F(PictureCacheTest, TakesDamagedPicturesForMissing) {
  const PictureCache cache = open();
  ASSERT_TRUE(cache.write(nanoseconds(1), picture_));
  const std::string file = cache.file_of(nanoseconds(1));
  std::ifstream in(file, std::ios::binary);
  const std::string whole((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  std::vector<std::uint8_t> read;
  for (std::size_t i = 0; i < whole.size(); i += 37) {
    std::string damaged = whole;
    damaged[i] = static_cast<char>(damaged[i] ^ 0x10);
    std::ofstream(file, std::ios::binary) << damaged;
    ASSERT_FALSE(cache.read(nanoseconds(1), read)) << i;
    std::ofstream(file, std::ios::binary) << whole.substr(0, i);
    ASSERT_FALSE(cache.read(nanoseconds(1), read)) << i;
  }
  ASSERT_TRUE(cache.write(nanoseconds(1), picture_));  // and writes them again
  EXPECT_TRUE(cache.read(nanoseconds(1), read));
  camera_.width = 32;
  EXPECT_FALSE(open().read(nanoseconds(1), read));
}

TEST_F(PictureCacheTest, TakesManyWritersAtOnce) {
  const PictureCache cache = open();
  std::vector<std::thread> writers;
  std::atomic<int> wrong{0};
  for (int writer = 0; writer < 4; ++writer) {
    writers.emplace_back([&] {
      std::vector<std::uint8_t> read;
      for (int i = 0; i < 40; ++i) {
        if (!cache.write(nanoseconds(i % 3), picture_)) ++wrong;
        if (!cache.read(nanoseconds(i % 3), read) || read != picture_) ++wrong;
      }
    });
  }
  for (std::thread& writer : writers) writer.join();
  EXPECT_EQ(wrong, 0);
  EXPECT_EQ(files(cache), 3);
}

TEST_F(PictureCacheTest, SaysWhereItCannotWrite) {
  std::ofstream(folder_) << "a file";
  const auto cache = PictureCache::open(folder_, 1, camera_);
  ASSERT_FALSE(cache);
  EXPECT_EQ(cache.error().kind(), ErrorKind::kCaller);
  std::filesystem::remove(folder_);
  const PictureCache gone = open();
  std::filesystem::remove_all(folder_);
  const Status written = gone.write(nanoseconds(1), picture_);
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().kind(), ErrorKind::kEnvironment);
}

TEST(PictureKeys, DifferWithAllThatPicturesShow) {
  CameraModel camera;
  const std::uint64_t key = key_of_pictures(1, 2, camera);
  EXPECT_EQ(key, key_of_pictures(1, 2, camera));
  EXPECT_NE(key, key_of_pictures(2, 1, camera));
  camera.k1 = 0.1;
  EXPECT_NE(key, key_of_pictures(1, 2, camera));
  camera.k1 = 0.0;
  camera.body_from_camera.position.x() = 0.1;
  EXPECT_NE(key, key_of_pictures(1, 2, camera));
}

}  // namespace
}  // namespace ctn::vr::drawing
