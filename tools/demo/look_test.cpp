#include "look.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "page.h"
#include "record/testing/record_fixture.h"
#include "sample.h"

namespace ctn::demo {
namespace {

using testing::HasSubstr;
using testing::Not;

class LookTest : public testing::Test {
 protected:
  LookTest() {
    setting_.cpu_sets = {{1}, {0, 1}};
    setting_.slowdown = 2.0;
  }
  // As a trial of the robot would.
  void play(const Trial& trial) const {
    const graph::App app = record::test::robot();
    const auto writer = record::test::make(record_of(path(), trial).string(), app);
    for (const record::Run& run : record::test::runs(app, record::test::seconds{103}, 1)) writer->add(run);
    ASSERT_TRUE(writer->close(record::test::at(record::test::seconds{104}), record::test::header().host).ok());
  }
  std::filesystem::path path() const { return folder_.file(""); }

  record::test::Folder folder_;
  Setting setting_;
};

TEST_F(LookTest, IsAtCatanAndTheDefaultOnAllCores) {
  const std::array<Trial, 2> trials = looked_at(setting_);
  EXPECT_EQ(trials[0].scheduler, "catan");
  EXPECT_EQ(trials[1].scheduler, "default");
  for (const Trial& trial : trials) {
    EXPECT_EQ(trial.cpus, (std::vector<int>{0, 1}));
    EXPECT_EQ(trial.seconds, 10.0);
    EXPECT_EQ(trial.speed, setting_.medium_speed);
    EXPECT_EQ(trial.seed, setting_.seed);
  }
}

TEST_F(LookTest, WithoutRecordsThereIsNone) {
  const auto glance = write_look(path(), setting_);
  ASSERT_TRUE(glance.ok());
  EXPECT_FALSE(glance->has_value());
  EXPECT_FALSE(std::filesystem::exists(path() / kLookPage));
}

TEST_F(LookTest, WritesThePageOfBoth) {
  for (const Trial& trial : looked_at(setting_)) play(trial);
  const auto glance = write_look(path(), setting_);
  ASSERT_TRUE(glance.ok()) << glance.error().message();
  ASSERT_TRUE(glance->has_value());
  EXPECT_THAT(record::test::read_bytes((path() / kLookPage).string()), HasSubstr("catan and default"));
  const auto page = render_page(sample_results(), *glance);
  ASSERT_TRUE(page.ok()) << page.error().message();
  EXPECT_THAT(*page, HasSubstr((*glance)->body));
  EXPECT_THAT(*page, HasSubstr("href=\"run.html\""));
  EXPECT_THAT(*render_page(sample_results()), Not(HasSubstr("run.html")));
}

TEST_F(LookTest, ARecordThatIsDamagedIsToldOf) {
  for (const Trial& trial : looked_at(setting_)) {
    record::test::write_bytes(record_of(path(), trial).string(), "no record");
  }
  EXPECT_FALSE(write_look(path(), setting_).ok());
}

}  // namespace
}  // namespace ctn::demo
