#include "studies.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "sample.h"

namespace ctn::case_studies {
namespace {

using ::testing::Contains;
using ::testing::Each;
using ::testing::Field;

class Studies : public ::testing::TestWithParam<std::string> {
 protected:
  Study study(const Setting& setting = {}) const { return study_with(GetParam(), setting); }
};

TEST_P(Studies, HaveEachBatchOnceAndEachMeasurementThatIsNeeded) {
  const Study of = study();
  std::set<std::string> names;
  for (const Batch& batch : of.batches) {
    EXPECT_TRUE(names.insert(batch.name).second) << batch.name;
    EXPECT_GT(batch.runs, 0);
    EXPECT_GT(batch.seconds, 0.0);
    if (!batch.costs.empty()) {
      EXPECT_THAT(of.measurements, Contains(Field(&Measurement::name, batch.costs)));
    }
    const auto in_group = [&](const Batch& other) { return other.reference && other.group == batch.group; };
    EXPECT_EQ(std::ranges::count_if(of.batches, in_group), 1) << batch.name;
  }
}

TEST_P(Studies, KeepToLimits) {
  Setting setting;
  setting.max_runs = 2;
  setting.max_seconds = 3.0;
  const Study of = study(setting);
  EXPECT_THAT(of.batches, Each(Field(&Batch::runs, 2)));
  EXPECT_THAT(of.batches, Each(Field(&Batch::seconds, 3.0)));
  for (const Batch& batch : of.batches) {
    EXPECT_EQ(*(std::ranges::find(batch.arguments, "--seconds") + 1), "3") << batch.name;
  }
}

TEST_P(Studies, AreShorterIfQuick) {
  Setting quick;
  quick.quick = true;
  const Study whole = study();
  const Study less = study(quick);
  ASSERT_EQ(whole.batches.size(), less.batches.size());
  for (std::size_t i = 0; i < whole.batches.size(); ++i) EXPECT_LT(less.batches[i].runs, whole.batches[i].runs);
}

INSTANTIATE_TEST_SUITE_P(All, Studies, ::testing::ValuesIn(ids_of_studies()), as_name);

TEST(StudiesList, HasEachStudyOnce) {
  const std::vector<std::string> ids = ids_of_studies();
  EXPECT_EQ(std::set<std::string>(ids.begin(), ids.end()).size(), ids.size());
}

TEST(LeaveOut, IsOfOneProgramAndKeepsWhatIsMissingAlready) {
  Setting setting;
  setting.no_life = "It takes two CPUs.";
  std::vector<Study> studies = make_studies(setting);
  leave_out(studies, "vr", "Nothing can be drawn.");
  for (const Study& study : studies) {
    const bool live = study.id == "life" || study.id == "headset-life";
    EXPECT_EQ(study.missing, live ? setting.no_life : study.program == "vr" ? "Nothing can be drawn." : "") << study.id;
  }
}

}  // namespace
}  // namespace ctn::case_studies
