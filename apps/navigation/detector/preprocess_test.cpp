#include "detector/preprocess.h"

#include <gtest/gtest.h>

#include <array>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace ctn::navigation {
namespace {

constexpr PreprocessSettings kBare{0, std::nullopt};

EncodedPicture png(const cv::Mat& picture) {
  EncodedPicture bytes;
  cv::imencode(".png", picture, bytes);  // without loss
  return bytes;
}

// Blue 50, green 100, red 200.
cv::Mat plain(cv::Size size) { return {size, CV_8UC3, cv::Scalar(50.0, 100.0, 200.0)}; }

TEST(Preprocess, WithoutAnythingToDoGivesTheCamerasPixels) {
  cv::Mat noise(48, 64, CV_8UC3);
  cv::RNG random(1);
  random.fill(noise, cv::RNG::UNIFORM, 0, 256);
  Preprocess preprocess({noise.size(), InputForm::Pixels::kBytes}, kBare);
  const auto prepared = preprocess.run(png(noise));
  ASSERT_TRUE(prepared.ok());
  EXPECT_EQ(cv::norm(prepared->input, noise, cv::NORM_INF), 0.0);
  EXPECT_EQ(prepared->work, (PictureWork{.decoded = 48 * 64}));
}

TEST(Preprocess, GivesANetworkPlanesOfColoursFrom0To1AndFillsUp) {
  Preprocess preprocess({{64, 64}, InputForm::Pixels::kPlanes}, kBare);
  const auto prepared = preprocess.run(png(plain({128, 64})));
  ASSERT_TRUE(prepared.ok());
  const cv::Mat& input = prepared->input;
  ASSERT_EQ(input.dims, 4);
  ASSERT_EQ(input.size[0], 1);
  ASSERT_EQ(input.size[1], 3);
  ASSERT_EQ(input.size[2], 64);
  ASSERT_EQ(input.size[3], 64);
  const auto at = [&](int plane, int y, int x) {
    const std::array<int, 4> index{0, plane, y, x};
    return input.at<float>(index.data());
  };
  for (const int x : {0, 31, 63}) {
    for (const int y : {16, 47}) {  // the picture's first and last row
      EXPECT_FLOAT_EQ(at(0, y, x), 200.0F / 255.0F);
      EXPECT_FLOAT_EQ(at(1, y, x), 100.0F / 255.0F);
      EXPECT_FLOAT_EQ(at(2, y, x), 50.0F / 255.0F);
    }
    for (const int y : {0, 15, 48, 63}) EXPECT_FLOAT_EQ(at(0, y, x), 127.0F / 255.0F);
  }
  EXPECT_EQ(prepared->letterbox.content(), cv::Rect(0, 16, 64, 32));
}

TEST(Preprocess, CountsWhatItDoes) {
  const InputForm form{{320, 320}, InputForm::Pixels::kPlanes};
  const std::uint64_t pixels = 768 * 576;
  EXPECT_EQ(Preprocess(form, {5, Lens{}}).work({768, 576}),
            (PictureWork{.decoded = pixels, .taps = 13 * pixels, .moved = 2 * pixels + 320 * 320}));
  EXPECT_EQ(Preprocess({{768, 576}, InputForm::Pixels::kBytes}, kBare).work({768, 576}),
            (PictureWork{.decoded = pixels}));
  Preprocess preprocess(form);
  const auto prepared = preprocess.run(png(plain({768, 576})));
  ASSERT_TRUE(prepared.ok());
  EXPECT_EQ(prepared->work, preprocess.work({768, 576}));
}

TEST(Preprocess, StraightensWhatTheLensBends) {
  // A line as a lens with barrel distortion shows it: y = 60 in the rectified picture, 100 pixels above the middle.
  const Lens lens{1.0, -0.2, 0.0};
  cv::Mat bent = cv::Mat::zeros(321, 401, CV_8UC3);
  for (double x = 0.0; x <= 400.0; x += 0.1) {
    const double across = (x - 200.0) / 401.0;
    const double down = (60.0 - 160.0) / 401.0;
    const double stretch = 1.0 + lens.k1 * (across * across + down * down);
    cv::circle(bent, {cvRound(200.0 + 401.0 * across * stretch), cvRound(160.0 + 401.0 * down * stretch)}, 2,
               cv::Scalar::all(255), cv::FILLED);
  }
  const auto brightest_row = [](const cv::Mat& picture, int x) {
    cv::Mat grey;
    cv::cvtColor(picture.col(x), grey, cv::COLOR_BGR2GRAY);
    const cv::Moments moments = cv::moments(grey);
    return moments.m01 / moments.m00;
  };
  ASSERT_GT(brightest_row(bent, 20) - brightest_row(bent, 200), 3.0);
  Preprocess preprocess({bent.size(), InputForm::Pixels::kBytes}, {0, lens});
  const auto prepared = preprocess.run(png(bent));
  ASSERT_TRUE(prepared.ok());
  for (const int x : {5, 50, 100, 200, 300, 395}) EXPECT_NEAR(brightest_row(prepared->input, x), 60.0, 0.7) << x;
}

TEST(Preprocess, RemovesNoiseAndKeepsEdges) {
  cv::Mat clean(64, 64, CV_8UC3, cv::Scalar::all(50));
  clean.colRange(32, 64).setTo(cv::Scalar::all(200));
  cv::Mat noise(clean.size(), CV_8UC3);
  cv::RNG random(1);
  random.fill(noise, cv::RNG::UNIFORM, 0, 11);
  Preprocess preprocess({clean.size(), InputForm::Pixels::kBytes}, {11, std::nullopt});
  const auto prepared = preprocess.run(png(clean + noise));
  ASSERT_TRUE(prepared.ok());
  cv::Mat grey;
  cv::cvtColor(prepared->input, grey, cv::COLOR_BGR2GRAY);
  cv::Scalar mean;
  cv::Scalar deviation;
  cv::meanStdDev(grey.colRange(0, 32), mean, deviation);
  EXPECT_LT(deviation[0], 1.0);  // of noise 3.2, in grey 1.9
  EXPECT_GT(grey.at<unsigned char>(32, 32) - grey.at<unsigned char>(32, 31), 140);
}

TEST(Preprocess, TakesPicturesOfAnySizeOneAfterTheOther) {
  Preprocess preprocess({{64, 64}, InputForm::Pixels::kBytes});
  for (const cv::Size size : {cv::Size(64, 64), {30, 200}, {64, 64}, {301, 7}}) {
    const auto prepared = preprocess.run(png(plain(size)));
    ASSERT_TRUE(prepared.ok());
    EXPECT_EQ(prepared->input.size(), cv::Size(64, 64));
    EXPECT_EQ(prepared->letterbox.picture(), size);
    const cv::Mat content = prepared->input(prepared->letterbox.content());
    EXPECT_EQ(content.at<cv::Vec3b>(content.rows / 2, content.cols / 2), cv::Vec3b(50, 100, 200));
  }
}

TEST(Preprocess, GivesEachRunPixelsOfItsOwn) {
  Preprocess preprocess({{64, 64}, InputForm::Pixels::kBytes});
  const auto first = preprocess.run(png(plain({64, 64})));
  ASSERT_TRUE(first.ok());
  const cv::Mat before = first->input.clone();
  ASSERT_TRUE(preprocess.run(png(cv::Mat::zeros(64, 64, CV_8UC3))).ok());
  EXPECT_EQ(cv::norm(first->input, before, cv::NORM_INF), 0.0);
}

TEST(Preprocess, RefusesWhatIsNoPicture) {
  Preprocess preprocess({{64, 64}, InputForm::Pixels::kBytes});
  for (const EncodedPicture& bytes : {EncodedPicture{}, EncodedPicture{'n', 'o'}}) {
    const auto prepared = preprocess.run(bytes);
    ASSERT_FALSE(prepared.ok());
    EXPECT_EQ(prepared.error().kind(), ErrorKind::kEnvironment);
  }
}

}  // namespace
}  // namespace ctn::navigation
