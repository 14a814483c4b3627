#include "detector/film.h"

#include <gtest/gtest.h>

#include <chrono>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>

#include "detector/testing/files.h"

namespace ctn::navigation {
namespace {

using namespace std::chrono_literals;

// A film of squares of one brightness: 10, 60, 110, 160.
std::string little_film() {
  std::string path = testing::own_file("film.avi");
  cv::VideoWriter writer(path, cv::CAP_OPENCV_MJPEG, cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), 25.0, {64, 48});
  for (const int level : {10, 60, 110, 160}) writer.write(cv::Mat(48, 64, CV_8UC3, cv::Scalar::all(level)));
  return path;
}

double brightness(const EncodedPicture& picture) { return cv::mean(cv::imdecode(picture, cv::IMREAD_COLOR))[0]; }

TEST(Film, ChoosesTheFrameByTimeAloneAndLoops) {
  const auto film = Film::open(little_film());
  ASSERT_TRUE(film.ok()) << film.error().message();
  EXPECT_EQ(film->frames(), 4U);
  EXPECT_EQ(film->size(), cv::Size(64, 48));
  EXPECT_EQ(film->frame_at(0ns), 0U);
  EXPECT_EQ(film->frame_at(99'999'999ns), 0U);
  EXPECT_EQ(film->frame_at(100ms), 1U);
  EXPECT_EQ(film->frame_at(300ms), 3U);
  EXPECT_EQ(film->frame_at(400ms), 0U);
  EXPECT_EQ(film->frame_at(1h + 250ms), 2U);  // 36000 frames: nine thousand times round
  EXPECT_NEAR(brightness(film->picture(0)), 10.0, 3.0);
  EXPECT_NEAR(brightness(film->picture(3)), 160.0, 3.0);
}

TEST(Film, IsTheSameWheneverItIsOpened) {
  const std::string path = little_film();
  const auto one = Film::open(path);
  const auto other = Film::open(path);
  ASSERT_TRUE(one.ok() && other.ok());
  EXPECT_EQ(one->fingerprint(), other->fingerprint());
  for (std::size_t frame = 0; frame < one->frames(); ++frame) EXPECT_EQ(one->picture(frame), other->picture(frame));
}

TEST(Film, OfDebianIsThereAndFitsInMemory) {
  const auto film = Film::open();
  ASSERT_TRUE(film.ok()) << film.error().message();
  EXPECT_EQ(film->frames(), 795U);
  EXPECT_EQ(film->size(), cv::Size(768, 576));
  EXPECT_LT(film->bytes(), 100'000'000U);
  EXPECT_GT(film->bytes(), 10'000'000U);
}

TEST(Film, SaysWhatIsWrongWithTheCallersFile) {
  const auto missing = Film::open("/nowhere/film.avi");
  ASSERT_FALSE(missing.ok());
  EXPECT_EQ(missing.error().kind(), ErrorKind::kCaller);
  EXPECT_NE(missing.error().message().find("/nowhere/film.avi"), std::string::npos);
  const auto text = Film::open(testing::written("film.avi", "this is text"));
  ASSERT_FALSE(text.ok());
  EXPECT_EQ(text.error().kind(), ErrorKind::kCaller);
  EXPECT_NE(text.error().message().find("cannot decode"), std::string::npos);
  EXPECT_FALSE(Film::open(::testing::TempDir()).ok());  // a folder
}

}  // namespace
}  // namespace ctn::navigation
