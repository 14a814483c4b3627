#include "detector/known_detections.h"

#include <gtest/gtest.h>

#include <memory>

#include "detector/people_detector.h"
#include "detector/testing/files.h"

namespace ctn::navigation {
namespace {

// A detector that counts how often it is asked.
class Counting final : public Detector {
 public:
  explicit Counting(int& runs) : runs_(runs) {}
  InputForm form() const override { return detector_.form(); }
  PictureWork work() const override { return detector_.work(); }
  std::string name(int label) const override { return detector_.name(label); }
  std::string identity() const override { return detector_.identity(); }
  Detections run(const Prepared& picture) override {
    ++runs_;
    return detector_.run(picture);
  }

 private:
  int& runs_;
  PeopleDetector detector_;
};

class Known : public ::testing::Test {
 protected:
  KnownDetections with(const PreprocessSettings& settings = {}) {
    return {testing::debian_film(), std::make_unique<Counting>(runs_), settings};
  }

  int runs_ = 0;
};

TEST_F(Known, AreWhatTheNodesComputeEachFrameOnce) {
  KnownDetections known = with();
  PeopleDetector detector;
  Preprocess preprocess(detector.form());
  for (const std::size_t frame : {50U, 794U, 50U, 794U, 50U}) {
    const auto prepared = preprocess.run(testing::debian_film().picture(frame));
    ASSERT_TRUE(prepared.ok());
    const Detections found = detector.run(*prepared);
    EXPECT_EQ(known.at(frame), found.things);
    EXPECT_EQ(known.preprocess_work(), prepared->work);
    EXPECT_EQ(known.detect_work(), found.work);
  }
  EXPECT_EQ(runs_, 2);
  EXPECT_EQ(known.known(), 2U);
}

TEST_F(Known, AreTakenFromAFileExactly) {
  const std::string path = testing::own_file("detections.json");
  KnownDetections first = with();
  const auto computed = first.at(50);
  ASSERT_FALSE(computed.empty());
  first.at(0);
  ASSERT_TRUE(first.save(path).ok());
  EXPECT_EQ(runs_, 2);

  KnownDetections second = with();
  second.load(path);
  EXPECT_EQ(second.known(), 2U);
  EXPECT_EQ(second.at(50), computed);
  EXPECT_EQ(runs_, 2);
  second.at(100);
  EXPECT_EQ(runs_, 3);
}

TEST_F(Known, AreNotTakenFromAFileOfOtherSettings) {
  const std::string path = testing::own_file("detections.json");
  KnownDetections first = with();
  first.at(0);
  ASSERT_TRUE(first.save(path).ok());
  KnownDetections second = with({9, Lens{}});
  second.load(path);
  EXPECT_EQ(second.known(), 0U);
  KnownDetections third = with({11, std::nullopt});
  third.load(path);
  EXPECT_EQ(third.known(), 0U);
}

TEST_F(Known, IgnoreAFileThatIsDamagedOrNotThere) {
  const std::string path = testing::own_file("detections.json");
  KnownDetections first = with();
  first.at(50);
  ASSERT_TRUE(first.save(path).ok());
  const EncodedPicture bytes = testing::picture_in(path);
  const std::string whole(bytes.begin(), bytes.end());
  std::string beyond = whole;
  beyond.replace(beyond.find("\"50\""), 4, "\"5000\"");
  for (const std::string& damaged : {whole.substr(0, whole.size() / 2), std::string("{}"), std::string(), beyond}) {
    KnownDetections known = with();
    known.load(testing::written("damaged.json", damaged));
    EXPECT_EQ(known.known(), 0U);
  }
  KnownDetections known = with();
  known.load("/nowhere/detections.json");
  EXPECT_EQ(known.known(), 0U);
}

TEST_F(Known, SayWhereTheyCannotBeKept) {
  const auto saved = with().save("/nowhere/detections.json");
  ASSERT_FALSE(saved.ok());
  EXPECT_EQ(saved.error().kind(), ErrorKind::kEnvironment);
  EXPECT_NE(saved.error().message().find("/nowhere/detections.json"), std::string::npos);
}

}  // namespace
}  // namespace ctn::navigation
