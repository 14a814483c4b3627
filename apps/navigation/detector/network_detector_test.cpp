#include "detector/network_detector.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <limits>

#include <opencv2/imgcodecs.hpp>

#include "detector/preprocess.h"
#include "detector/testing/files.h"
#include "detector/testing/tiny_network.h"

namespace ctn::navigation {
namespace {

std::unique_ptr<NetworkDetector> opened(const NetworkFiles& files) {
  auto detector = NetworkDetector::open(files);
  EXPECT_TRUE(detector.ok()) << detector.error().message();
  return detector.ok() ? std::move(detector).value() : nullptr;
}

// What is wrong, as the user reads it.
std::string mistake(const NetworkFiles& files) {
  const auto detector = NetworkDetector::open(files);
  if (detector.ok()) return "none";
  EXPECT_EQ(detector.error().kind(), ErrorKind::kCaller);
  EXPECT_FALSE(detector.error().problems().front().hint.empty());
  return detector.error().message();
}

Prepared prepared_for(const NetworkDetector& detector, cv::Size picture) {
  EncodedPicture bytes;
  cv::imencode(".png", cv::Mat(picture, CV_8UC3, cv::Scalar::all(90)), bytes);
  return Preprocess(detector.form(), {0, std::nullopt}).run(bytes).value();
}

TEST(NetworkDetector, MapsBoxesFromTheInputToThePicture) {
  const auto detector = opened(testing::tiny_network());
  ASSERT_NE(detector, nullptr);
  // 128 x 64 is 64 x 32 in the input's middle: boxes of 16 x 32 at (8, 0), (40, 0), (8, 32), (40, 32) of it.
  const Detections found = detector->run(prepared_for(*detector, {128, 64}));
  ASSERT_EQ(found.things.size(), 4U);
  std::vector<cv::Rect2d> boxes;
  for (const Detection& thing : found.things) {
    EXPECT_EQ(thing.label, 1);
    EXPECT_NEAR(thing.confidence, testing::kTinyConfidence, 1e-5);
    boxes.push_back(thing.box);
  }
  for (const cv::Rect2d expected : {cv::Rect2d(16, 0, 32, 32), {80, 0, 32, 32}, {16, 32, 32, 32}, {80, 32, 32, 32}}) {
    EXPECT_TRUE(std::ranges::any_of(boxes, [&](const cv::Rect2d& box) {
      return std::abs(box.x - expected.x) < 1e-3 && std::abs(box.y - expected.y) < 1e-3 &&
             std::abs(box.width - expected.width) < 1e-3 && std::abs(box.height - expected.height) < 1e-3;
    })) << expected;
  }
}

TEST(NetworkDetector, KeepsOneOfThoseThatOverlap) {
  const auto detector = opened(testing::tiny_network("640,640"));  // each as large as the whole picture
  ASSERT_NE(detector, nullptr);
  const Detections found = detector->run(prepared_for(*detector, {64, 64}));
  ASSERT_EQ(found.things.size(), 1U);
  EXPECT_EQ(found.things.front().box, cv::Rect2d(0, 0, 64, 64));
}

TEST(NetworkDetector, TakesNothingFromNumbersThatAreNone) {
  const NetworkFiles files = testing::tiny_network();
  const auto with_bias = [&](std::size_t number, float value) {
    std::string weights = testing::tiny_weights();
    std::memcpy(weights.data() + 20 + number * sizeof(float), &value, sizeof(value));
    return opened({files.description, testing::written("odd.weights", weights), std::nullopt});
  };
  for (const std::size_t number : {0U, 2U, 4U, 6U}) {  // x, width, whether there is anything, class 1
    const auto detector = with_bias(number, std::numeric_limits<float>::quiet_NaN());
    ASSERT_NE(detector, nullptr);
    EXPECT_TRUE(detector->run(prepared_for(*detector, {64, 64})).things.empty()) << number;
  }
  const auto endless = with_bias(2, 1000.0F);  // infinitely wide
  ASSERT_NE(endless, nullptr);
  for (const Detection& thing : endless->run(prepared_for(*endless, {64, 64})).things) {
    EXPECT_EQ(thing.box & cv::Rect2d(0, 0, 64, 64), thing.box);
  }
}

TEST(NetworkDetector, CountsMultiplyAdds) {
  const auto detector = opened(testing::tiny_network());
  ASSERT_NE(detector, nullptr);
  const PictureWork work{.multiply_adds = 4 * 7 * 3 * 32 * 32, .emitted = 4 * 7};
  EXPECT_EQ(detector->work(), work);
  EXPECT_EQ(detector->run(prepared_for(*detector, {64, 64})).work, work);
}

TEST(NetworkDetector, NamesClassesIfItIsTold) {
  NetworkFiles files = testing::tiny_network();
  const auto without = opened(files);
  ASSERT_NE(without, nullptr);
  EXPECT_EQ(without->name(1), "class 1");
  files.names = testing::written("tiny.names", "cup\r\nsaucer\n\n");
  const auto with = opened(files);
  ASSERT_NE(with, nullptr);
  EXPECT_EQ(with->name(0), "cup");
  EXPECT_EQ(with->name(1), "saucer");
  files.names = testing::written("wrong.names", "cup\n");
  EXPECT_NE(mistake(files).find("has 1 names"), std::string::npos);
}

TEST(NetworkDetector, IsAnotherWithOtherWeights) {
  const NetworkFiles files = testing::tiny_network();
  const std::string before = opened(files)->identity();
  EXPECT_EQ(opened(files)->identity(), before);
  std::string weights = testing::tiny_weights();
  weights.back() = '\1';
  EXPECT_NE(opened({files.description, testing::written("other.weights", weights), std::nullopt})->identity(), before);
}

TEST(NetworkDetector, SaysWhichFileIsMissing) {
  const NetworkFiles good = testing::tiny_network();
  EXPECT_NE(mistake({"/nowhere.cfg", good.weights, {}}).find("cannot read the network's description /nowhere.cfg"),
            std::string::npos);
  EXPECT_NE(mistake({good.description, "/nowhere.weights", {}}).find("weights /nowhere.weights"), std::string::npos);
  EXPECT_NE(mistake({good.description, ::testing::TempDir(), {}}).find("cannot read"), std::string::npos);
  EXPECT_NE(mistake({good.description, good.weights, "/nowhere.names"}).find("/nowhere.names"), std::string::npos);
}

TEST(NetworkDetector, SaysThatFilesAreSwappedOrDoNotBelongTogether) {
  const NetworkFiles good = testing::tiny_network();
  EXPECT_NE(mistake({good.weights, good.description, {}}).find("no section [net]"), std::string::npos);
  for (const int more : {-testing::kTinyNumbers, -1, 1, 1000}) {
    const std::string weights = testing::written("wrong.weights", testing::tiny_weights(testing::kTinyNumbers + more));
    const std::string what = mistake({good.description, weights, {}});
    EXPECT_NE(what.find("wrong.weights"), std::string::npos) << more << ": " << what;
    EXPECT_NE(what.find("must be of the same network"), std::string::npos) << more << ": " << what;
  }
  EXPECT_NE(mistake({good.description, testing::written("empty.weights", ""), {}}), "none");
}

TEST(NetworkDetector, SaysWhatOpenCvCannotDo) {
  const NetworkFiles good = testing::tiny_network();
  std::string text = testing::tiny_description();
  text.insert(text.find("[yolo]"), "[hologram]\nsize=3\n\n");
  const std::string what = mistake({testing::written("new.cfg", text), good.weights, {}});
  EXPECT_NE(what.find("hologram"), std::string::npos) << what;
}

// With a real network.

class RealNetwork : public ::testing::Test {
 protected:
  void SetUp() override {
    CATAN_NEEDS_NETWORK();
    const std::string folder = testing::network_folder() + "/";
    detector_ = opened({folder + "yolo-fastest-1.1.cfg", folder + "yolo-fastest-1.1.weights", folder + "coco.names"});
    ASSERT_NE(detector_, nullptr);
  }

  // Whether something of this name covers nearly this box, to within a quarter of its sides.
  bool finds(const std::string& picture, const std::string& name, const cv::Rect2d& box) {
    Preprocess preprocess(detector_->form(), {0, std::nullopt});
    const auto prepared = preprocess.run(testing::picture_in(testing::network_folder() + "/" + picture));
    EXPECT_TRUE(prepared.ok());
    if (!prepared.ok()) return false;
    return std::ranges::any_of(detector_->run(*prepared).things, [&](const Detection& thing) {
      const double common = (thing.box & box).area();
      return detector_->name(thing.label) == name && common > 0.5 * std::max(thing.box.area(), box.area());
    });
  }

  std::unique_ptr<NetworkDetector> detector_;
};

TEST_F(RealNetwork, FindsDogBicycleAndCar) {
  EXPECT_TRUE(finds("dog.jpg", "dog", {125, 220, 190, 320}));
  EXPECT_TRUE(finds("dog.jpg", "bicycle", {125, 130, 440, 300}));
  EXPECT_TRUE(finds("dog.jpg", "car", {465, 75, 215, 95}));
}

TEST_F(RealNetwork, FindsThePersonAndTheDogBesideThem) {
  EXPECT_TRUE(finds("person.jpg", "person", {190, 95, 85, 285}));
  EXPECT_TRUE(finds("person.jpg", "dog", {70, 262, 135, 88}));
}

TEST_F(RealNetwork, CostsWhatItsAuthorsSay) {
  EXPECT_NEAR(static_cast<double>(detector_->work().multiply_adds), 0.252e9 / 2.0, 0.001e9);  // 0.252 BFLOPs
}

}  // namespace
}  // namespace ctn::navigation
