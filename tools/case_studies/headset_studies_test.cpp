#include "headset_studies.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "comparison.h"
#include "report/plot.h"
#include "sample.h"

namespace ctn::case_studies {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::Field;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::SizeIs;

// Runs as they would come out if all went as one hopes: Catan's response times are at their floors of 10, 20 and 30 ms,
// on two cores C is shorter; others' are half as long again.
Runs headset_runs_hoped_for(const Study& study) {
  Runs runs;
  for (const Batch& batch : study.batches) {
    const bool ours = batch.name.ends_with("catan") || study.id == "headset-life";
    const double longer = ours ? 1.0 : 1.5;
    for (int number = 0; number < 12; ++number) {
      const double varies = 0.01 * number;
      const double shorter = batch.group == "2-cores" ? 5.0 : 0.0;
      StoredRun run;
      run.seed = 1 + static_cast<std::uint64_t>(number);
      run.figures = {{"response_ms A_mean", 10.0 * longer + varies},
                     {"response_ms B_mean", 20.0 * longer + varies},
                     {"response_ms C_mean", 30.0 * longer + varies - shorter},
                     {"ticks", 1000.0},
                     {"ticks_missed", ours ? 0.0 : 10.0},
                     {"vio_hz", 20.0}};
      for (const char* error : {"error_px_p50", "error_px_p95", "age_error_px_p95"})
        run.figures[error] = longer + varies;
      for (const char* chain : {"A", "B", "C"}) {
        const std::string name = std::string(" ") + chain;
        run.figures["over_floor_percent" + name] = 100.0 * (longer - 1.0);
        run.figures["floor_ms" + name] = 10.0;
      }
      runs[batch.name].push_back(run);
    }
  }
  return runs;
}

// `with(figures)` for each run of the batch.
template <class With>
void change(Runs& runs, const std::string& batch, const With& with) {
  for (StoredRun& run : runs.at(batch)) with(run.figures);
}

class HeadsetStudies : public ::testing::TestWithParam<std::string> {
 protected:
  Study study() const { return study_with(GetParam()); }
};

TEST_P(HeadsetStudies, HoldIfAllIsAsHopedFor) {
  const Study of = study();
  const Runs runs = headset_runs_hoped_for(of);
  ASSERT_TRUE(is_complete_enough(of, runs));
  const std::vector<Claim> claims = of.claim(of, runs);
  EXPECT_THAT(claims, Not(IsEmpty()));
  for (const Claim& claim : claims) EXPECT_EQ(claim.verdict, Verdict::kHeld) << claim.text << ": " << claim.measured;
}

TEST_P(HeadsetStudies, DoNotHoldWhereOthersAreTheBetterOnes) {
  const Study of = study();
  Runs runs = headset_runs_hoped_for(of);
  for (auto& [name, batch] : runs) {
    const bool ours = name.ends_with("catan") || name.ends_with("virtual");
    const double cores = name.starts_with("2-cores") ? 2.0 : 1.0;
    for (StoredRun& run : batch) {
      for (auto& [figure, value] : run.figures) value = ours ? 50.0 * cores : 20.0;
      run.figures["ticks"] = 1000.0;
    }
  }
  for (const Claim& claim : of.claim(of, runs)) {
    EXPECT_EQ(claim.verdict, Verdict::kFailed) << claim.text << ": " << claim.measured;
  }
}

TEST_P(HeadsetStudies, TellWhatIsNotThere) {
  const Study of = study();
  Runs runs = headset_runs_hoped_for(of);
  for (auto& [name, batch] : runs) {
    for (StoredRun& run : batch) run.figures.clear();
  }
  for (const Claim& claim : of.claim(of, runs)) {
    EXPECT_EQ(claim.verdict, Verdict::kFailed) << claim.text << ": " << claim.measured;
    EXPECT_THAT(claim.measured, HasSubstr("nothing"));
  }
}

TEST_P(HeadsetStudies, DrawFigures) {
  const Study of = study();
  if (!of.draw) return;
  for (const Drawn& drawn : of.draw(of, headset_runs_hoped_for(of))) {
    const auto svg = report::render_svg(drawn.figure);
    EXPECT_TRUE(svg.ok()) << svg.error().message();
  }
}

INSTANTIATE_TEST_SUITE_P(All, HeadsetStudies, ::testing::ValuesIn(ids_of_studies("vr")), as_name);

Claim claim_with(const Study& study, const Runs& runs, const std::string& text) {
  for (const Claim& claim : study.claim(study, runs)) {
    if (claim.text.find(text) != std::string::npos) return claim;
  }
  ADD_FAILURE() << "no claim says " << text;
  return {};
}

TEST(HeadsetStudy, FewRunsShowNothing) {
  const Study study = headset({});
  Runs runs = headset_runs_hoped_for(study);
  for (auto& [name, batch] : runs) batch.resize(3);
  EXPECT_EQ(claim_with(study, runs, "smaller error than that of FIFO").verdict, Verdict::kNotShown);
  EXPECT_EQ(claim_with(study, runs, "C is 20 % shorter").verdict, Verdict::kNotShown);
  EXPECT_EQ(claim_with(study, runs, "A is at most 5 %").verdict, Verdict::kHeld) << "there is no test of it";
}

TEST(HeadsetStudy, CIsComparedWithTheBetterBaseline) {
  const Study study = headset({});
  Runs runs = headset_runs_hoped_for(study);
  change(runs, "1-core/default", [](auto& figures) { figures["response_ms C_mean"] = 36.0; });
  const Claim claim = claim_with(study, runs, "C is 20 % shorter");
  EXPECT_EQ(claim.verdict, Verdict::kFailed) << "17 %";
  EXPECT_THAT(claim.measured, HasSubstr("beside 36.00 (-16.5 %)"));
}

TEST(HeadsetStudy, AtItsFloorItMayBeBehindThePacer) {
  const Study study = headset({});
  Runs runs = headset_runs_hoped_for(study);
  change(runs, "1-core/pacer", [](auto& figures) { figures["response_ms A_mean"] = 9.95; });
  EXPECT_EQ(claim_with(study, runs, "A is no longer than the pacer's").verdict, Verdict::kHeld);
  change(runs, "1-core/catan", [](auto& figures) { figures["over_floor_percent A"] = 2.0; });
  EXPECT_EQ(claim_with(study, runs, "A is no longer than the pacer's").verdict, Verdict::kFailed);
}

TEST(HeadsetStudy, ItsCameraHasAFloorWhereItHasARate) {
  const auto over_c = Field(&Metric::name, HasSubstr("C above its floor"));
  EXPECT_THAT(headset({}).metrics, Not(Contains(over_c)));
  EXPECT_THAT(headset_20hz({}).metrics, Contains(over_c));
  for (const Batch& batch : headset_20hz({}).batches) EXPECT_THAT(batch.arguments, Contains("--camera")) << batch.name;
}

TEST(HeadsetStudy, DrawsThePapersFigureWithMeansDeviationsAndFloors) {
  const Study study = headset_20hz({});
  const std::vector<Drawn> drawn = study.draw(study, headset_runs_hoped_for(study));
  ASSERT_THAT(drawn, SizeIs(2));
  ASSERT_THAT(drawn[0].figure.panels, SizeIs(3));
  EXPECT_THAT(drawn[0].caption, AllOf(HasSubstr("A -33 %"), HasSubstr("B -25 %")));
  const report::Panel& panel = drawn[0].figure.panels[0];
  ASSERT_THAT(panel.levels, SizeIs(1));
  EXPECT_EQ(panel.levels[0].y, 10.0);
  ASSERT_THAT(panel.series, SizeIs(2));
  ASSERT_THAT(panel.series[1].points, SizeIs(5)) << "a scheduler each, on two cores";
  const report::Point& point = panel.series[0].points[4];
  EXPECT_NEAR(point.y, 10.055, 1e-9);
  EXPECT_NEAR(*point.high - point.y, 0.036, 1e-3) << "the standard deviation of 0, 0.01, ... 0.11";
}

TEST(HeadsetLife, IsWithinTenPercentOrNot) {
  const Study study = headset_life({});
  Runs runs = headset_runs_hoped_for(study);
  change(runs, "pacer/life", [](auto& figures) { figures["response_ms B_mean"] *= 1.2; });
  const Claim claim = claim_with(study, runs, "pacer");
  EXPECT_EQ(claim.verdict, Verdict::kFailed);
  EXPECT_THAT(claim.measured, HasSubstr("B 24.1 in life, 20.1 (-17 %)"));
  EXPECT_EQ(claim_with(study, runs, "FIFO").verdict, Verdict::kHeld);
  for (const Batch& batch : study.batches) {
    EXPECT_EQ(batch.live, batch.name.ends_with("/life"));
    EXPECT_EQ(batch.calibration, batch.live ? "" : batch.group + "/life");
  }
}

}  // namespace
}  // namespace ctn::case_studies
