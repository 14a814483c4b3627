#include "detector/people_detector.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <iterator>

#include "detector/film.h"
#include "detector/preprocess.h"
#include "detector/testing/files.h"

namespace ctn::navigation {
namespace {

class People : public ::testing::Test {
 protected:
  Detections look(std::size_t frame) {
    const auto prepared = preprocess_.run(testing::debian_film().picture(frame));
    EXPECT_TRUE(prepared.ok());
    return detector_.run(*prepared);
  }

  PeopleDetector detector_;
  Preprocess preprocess_{detector_.form()};
};

struct Person {
  std::size_t frame;
  double x;  // of the middle
  double y;
  double height;
};
// Where people are in the film, by eye; those who stand clear of others, large enough for the classifier.
constexpr Person kPeople[] = {{0, 266, 262, 90},    {50, 525, 266, 95},  {50, 569, 262, 90},   {50, 696, 314, 105},
                              {250, 617, 306, 100}, {250, 400, 280, 95}, {550, 194, 447, 145}, {550, 258, 448, 135},
                              {550, 656, 358, 110}, {600, 581, 245, 90}, {600, 659, 361, 105}, {650, 486, 274, 90},
                              {650, 357, 445, 135}};

TEST_F(People, AreFoundInKnownFramesWhereTheyAre) {
  for (const Person& person : kPeople) {
    const Detections found = look(person.frame);
    const bool seen = std::ranges::any_of(found.things, [&](const Detection& thing) {
      const double x = thing.box.x + 0.5 * thing.box.width;
      const double y = thing.box.y + 0.5 * thing.box.height;
      const double ratio = thing.box.height / person.height;
      return std::abs(x - person.x) < 15.0 && std::abs(y - person.y) < 20.0 && ratio > 0.75 && ratio < 1.4;
    });
    EXPECT_TRUE(seen) << "frame " << person.frame << ", at " << person.x << ", " << person.y;
  }
}

TEST_F(People, HaveBoxesInsideThePictureAndTheSurestComesFirst) {
  std::size_t found = 0;
  for (std::size_t frame = 25; frame < testing::debian_film().frames(); frame += 100) {
    const Detections people = look(frame);
    found += people.things.size();
    for (std::size_t i = 0; i < people.things.size(); ++i) {
      const Detection& person = people.things[i];
      EXPECT_EQ(detector_.name(person.label), "person");
      EXPECT_GE(person.confidence, PeopleDetector::kConfidenceMin);
      EXPECT_GT(person.box.height, 80.0);  // the classifier's window is 128 pixels high
      EXPECT_GT(person.box.height, 1.5 * person.box.width);
      EXPECT_EQ(person.box & cv::Rect2d({}, cv::Size2d(testing::debian_film().size())), person.box);
      EXPECT_LE(person.confidence, people.things[i == 0 ? 0 : i - 1].confidence);
    }
  }
  EXPECT_GE(found, 8U);  // of 8 pictures, each with people in it
}

TEST_F(People, AreTheSameEachTimeForEachObject) {
  const Detections once = look(50);
  EXPECT_FALSE(once.things.empty());
  look(300);
  EXPECT_EQ(look(50).things, once.things);
  PeopleDetector other;
  EXPECT_EQ(other.run(*preprocess_.run(testing::debian_film().picture(50))).things, once.things);
}

TEST_F(People, AreLookedForByTheThreadThatAsks) {
  // No pool of OpenCV's beside it, which no plan knows of.
  const auto threads = [] {
    return std::distance(std::filesystem::directory_iterator("/proc/self/task"), std::filesystem::directory_iterator{});
  };
  const auto before = threads();
  look(50);
  EXPECT_EQ(threads(), before);
}

TEST(PeopleDetector, FindsNobodyInAnEmptyPicture) {
  PeopleDetector detector;
  const cv::Size size(PeopleDetector::kWidth, PeopleDetector::kHeight);
  const Prepared grey{cv::Mat(size, CV_8UC3, cv::Scalar::all(127)), Letterbox(size, size), {}};
  EXPECT_TRUE(detector.run(grey).things.empty());
}

TEST(PeopleDetector, CountsItsWindows) {
  // One size alone: (64 - 64) / 8 + 1 places across, (136 - 128) / 8 + 1 down.
  const PictureWork small = PeopleDetector({64, 134}).work();
  EXPECT_EQ(small, (PictureWork{.gradients = 64 * 134, .windows = 1}));
  const PictureWork two = PeopleDetector({68, 136}).work();  // and at 65 x 130
  EXPECT_EQ(two, (PictureWork{.gradients = 68 * 136 + 65 * 130, .windows = 2 + 1}));
  EXPECT_EQ(PeopleDetector({63, 500}).work(), PictureWork{});
}

}  // namespace
}  // namespace ctn::navigation
