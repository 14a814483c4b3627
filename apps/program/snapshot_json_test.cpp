#include "program/snapshot_json.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace ctn::program {
namespace {

using Json = nlohmann::ordered_json;
using ::testing::ElementsAre;
using ::testing::Optional;

TEST(SnapshotJson, FiguresAreReadAsTheyWereWritten) {
  const Json document{{"figures", json_of(std::vector<Figure>{{"way_m", 2.5}, {"goal_s", std::nullopt}})}};
  EXPECT_EQ(document.dump(), R"({"figures":{"way_m":2.5,"goal_s":null}})");
  ASSERT_TRUE(has_figures(document));
  const std::vector<Figure> figures = figures_in(document);
  ASSERT_EQ(figures.size(), 2U);
  EXPECT_EQ(figures[0].name, "way_m");
  EXPECT_THAT(figures[0].value, Optional(2.5));
  EXPECT_EQ(figures[1].name, "goal_s");
  EXPECT_EQ(figures[1].value, std::nullopt);
}

TEST(SnapshotJson, KnowsWhatIsNoOutcome) {
  for (const char* text : {"", "[]", "{}", R"({"figures": 3})"}) {
    EXPECT_FALSE(has_figures(Json::parse(text, nullptr, false))) << text;
  }
}

TEST(SnapshotJson, NumbersByTimeAreReadAsTheyWereWritten) {
  const Json list = json_of(ByTime{10.0, std::nullopt, 30.0});
  EXPECT_EQ(list.dump(), "[10.0,null,30.0]");
  EXPECT_THAT(by_time_in(list), ElementsAre(Optional(10.0), std::nullopt, Optional(30.0)));
  EXPECT_EQ(json_of(ByTime{}).dump(), "[]");
}

TEST(SnapshotJson, ADocumentNamesWhatRunsHaveInCommon) {
  const Json options{{"map", "1"}, {"seed", 7}, {"calibration", {{"LP", 1.5}}}, {"cpus", {0}}};
  Json document = options;
  document["real_time"] = true;
  document["figures"] = Json::object();
  add_in_common(options, document);
  EXPECT_EQ(document["in_common"].dump(), R"(["map","cpus","real_time"])");
  EXPECT_EQ(common_options_in(document).value().dump(), R"({"map":"1","cpus":[0],"real_time":true})");
  document.erase("in_common");
  EXPECT_EQ(common_options_in(document), std::nullopt);
}

TEST(SnapshotJson, OfNoSamplesThereIsNothingToTell) {
  EXPECT_EQ(json_of(Summary{}).dump(), R"({"mean":null,"p50":null,"p95":null,"count":0})");
}

}  // namespace
}  // namespace ctn::program
