#include "detector.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <string>
#include <utility>

#include "footage.h"
#include "lens.h"
#include "preprocess.h"
#include "view.h"

namespace ctn::face_tracking {
namespace {

// On the real footage, from Debian's opencv-doc and opencv-data.
class Detection : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    cv::setNumThreads(1);
    auto footage = load_footage({});
    ASSERT_TRUE(footage.ok()) << footage.error().problems().front().what;
    view_ = new View(std::move(footage).value(), 1);
  }
  static void TearDownTestSuite() {
    delete view_;
    view_ = nullptr;
  }

  std::optional<Found> look(double pan, double angle, double time, std::uint64_t noise) {
    view_->render({pan + angle, pan, wrapped(angle)}, time, noise, raw_);
    preprocess_.run(raw_, flat_);
    return detector_.run(flat_);
  }

  static View* view_;
  Preprocess preprocess_;
  Detector detector_ = Detector::open(FootageFiles{}.cascade()).value();
  cv::Mat raw_;
  cv::Mat flat_;
};

View* Detection::view_ = nullptr;

TEST_F(Detection, FindsTheFaceWhereverItIsWhollyInView) {
  // Bearings all round, angles from edge to edge, all faces of the film.
  constexpr int kPictures = 30;
  constexpr double kWhole = 0.42;  // radians; further out the picture's edge cuts the face
  int found = 0;
  for (int i = 0; i < kPictures; ++i) {
    const double angle = kWhole * (2.0 * (i * 0.618034 - std::floor(i * 0.618034)) - 1.0);
    const auto face = look(2.399963 * i, angle, 0.37 * i, static_cast<std::uint64_t>(i));
    found += face && std::abs(face->angle - angle) < 0.06 ? 1 : 0;
  }
  EXPECT_GE(found, kPictures * 95 / 100);
}

TEST_F(Detection, FindsHardlyAnythingWhereNoFaceIs) {
  constexpr int kPictures = 30;
  int wrong = 0;
  for (int i = 0; i < kPictures; ++i) wrong += look(2.399963 * i, 2.0, 0.0, static_cast<std::uint64_t>(i)) ? 1 : 0;
  EXPECT_LE(wrong, kPictures / 30);
}

TEST(Detector, TellsWhichPackageIsMissing) {
  const auto detector = Detector::open("/nowhere/cascade.xml");
  ASSERT_FALSE(detector.ok());
  EXPECT_EQ(detector.error().kind(), ErrorKind::kEnvironment);
  EXPECT_NE(detector.error().problems().front().hint.find("opencv-data"), std::string::npos);
}

// So that many runs look for them only once.
TEST(Footage, FacesThatWereFoundBeforeAreTheSame) {
  FootageFiles files;
  files.faces = testing::TempDir() + "faces_" + std::to_string(getpid()) + ".png";
  std::filesystem::remove(files.faces);
  const auto found = load_footage(files);
  ASSERT_TRUE(found.ok()) << found.error().message();
  ASSERT_TRUE(std::filesystem::exists(files.faces));
  const auto read = load_footage(files);
  ASSERT_TRUE(read.ok()) << read.error().message();
  ASSERT_EQ(read->faces.size(), found->faces.size());
  for (std::size_t face = 0; face < read->faces.size(); ++face) {
    EXPECT_EQ(cv::norm(read->faces[face].pixels, found->faces[face].pixels, cv::NORM_INF), 0.0);
    EXPECT_EQ(cv::norm(read->faces[face].alpha, found->faces[face].alpha, cv::NORM_INF), 0.0);
  }
}

TEST(Footage, AnotherPictureIsRefused) {
  FootageFiles files;
  files.faces = files.examples + "/leuvenA.jpg";
  const auto footage = load_footage(files);
  ASSERT_FALSE(footage.ok());
  EXPECT_NE(footage.error().message().find("no picture of the film's faces"), std::string::npos);
}

TEST(Footage, FacesThatCannotBeKeptAreAnError) {
  FootageFiles files;
  files.faces = "/nowhere/faces.png";
  const auto footage = load_footage(files);
  ASSERT_FALSE(footage.ok());
  EXPECT_NE(footage.error().message().find("cannot write /nowhere/faces.png"), std::string::npos);
}

TEST(Footage, TellsWhichPackageIsMissing) {
  FootageFiles files;
  files.examples = "/nowhere";
  const auto footage = load_footage(files);
  ASSERT_FALSE(footage.ok());
  EXPECT_NE(footage.error().problems().front().hint.find("opencv-doc"), std::string::npos);
}

}  // namespace
}  // namespace ctn::face_tracking
