#include "run/options.h"

#include <gtest/gtest.h>

#include <initializer_list>
#include <vector>

#include "program/testing/parsed.h"

namespace ctn::navigation::run {
namespace {

using program::Leave;

std::variant<Options, Leave> parse(std::initializer_list<const char*> words) {
  return program::testing::parsed("navigation", words, parse_options);
}
int code_of(std::initializer_list<const char*> words) { return program::testing::code_of(parse(words)); }

TEST(Options, AreWhatWasGiven) {
  const auto parsed = parse({"--map",  "w.yaml", "--scheduler", "default",    "--cpus", "0,2-4",      "--seconds",
                             "3.5",    "--seed", "9",           "--record",   "r.db",   "--slowdown", "2",
                             "--json", "--app",  "a.yaml",      "--pictures", "p",      "--detector", "none"});
  ASSERT_TRUE(std::holds_alternative<Options>(parsed));
  const auto& options = std::get<Options>(parsed);
  EXPECT_EQ(options.map, "w.yaml");
  EXPECT_EQ(options.world_file, "w.yaml");
  EXPECT_EQ(options.scheduler, "default");
  EXPECT_EQ(options.cpus, (std::vector<int>{0, 2, 3, 4}));
  EXPECT_EQ(options.seconds, 3.5);
  EXPECT_EQ(options.seed, 9U);
  EXPECT_EQ(options.record, "r.db");
  EXPECT_EQ(options.slowdown, 2.0);
  EXPECT_EQ(options.app_file, "a.yaml");
  EXPECT_EQ(options.pictures, "p");
  EXPECT_TRUE(options.json);
  EXPECT_FALSE(options.virtual_time);
}

TEST(Options, OfVirtualTimeAndBatches) {
  const auto parsed = parse({"--virtual", "--cores", "2", "--runs", "20", "--out", "d", "--map", "2"});
  ASSERT_TRUE(std::holds_alternative<Options>(parsed));
  const auto& options = std::get<Options>(parsed);
  EXPECT_TRUE(options.virtual_time);
  EXPECT_EQ(options.cores, 2);
  EXPECT_EQ(options.runs, 20);
  EXPECT_EQ(options.out, "d");
  EXPECT_NE(options.world_file.find("map2.yaml"), std::string::npos);
  EXPECT_EQ(std::get<Options>(parse({"--map", "crowd"})).world_file, "");
}

TEST(Options, FastLocalIsTheDefaultWithAnotherAppFile) {
  const auto parsed = std::get<Options>(parse({"--scheduler", "fast-local"}));
  EXPECT_EQ(parsed.scheduler, "fast-local");
  EXPECT_EQ(parsed.policy, "default");
  EXPECT_NE(parsed.app_file.find("robot_fast_local.yaml"), std::string::npos);
  EXPECT_EQ(std::get<Options>(parse({"--scheduler", "fifo"})).policy, "fifo");
  EXPECT_NE(std::get<Options>(parse({})).app_file.find("robot.yaml"), std::string::npos);
  EXPECT_EQ(std::get<Options>(parse({"--scheduler", "fast-local", "--app", "mine.yaml"})).app_file, "mine.yaml");
}

TEST(Options, WithADetectorTheAppFileHasOne) {
  const auto hog = std::get<Options>(parse({"--detector", "hog", "--film", "f.avi"}));
  EXPECT_EQ(hog.detector, "hog");
  EXPECT_EQ(hog.film, "f.avi");
  EXPECT_NE(hog.app_file.find("robot_with_detector.yaml"), std::string::npos);
  const auto yolo =
      std::get<Options>(parse({"--detector", "yolo", "--model", "a.cfg", "a.weights", "--app", "b.yaml"}));
  EXPECT_EQ(yolo.model, (std::vector<std::string>{"a.cfg", "a.weights"}));
  EXPECT_EQ(yolo.app_file, "b.yaml");
  const auto named = std::get<Options>(parse({"--detector", "yolo", "--model", "a.cfg", "a.weights", "a.names"}));
  EXPECT_EQ(named.model.size(), 3U);
}

TEST(Options, OfBaselines) {
  const auto parsed =
      std::get<Options>(parse({"--scheduler", "davare", "--costs", "c.yaml", "--no-stealing", "--cpus", "0"}));
  EXPECT_EQ(parsed.costs, "c.yaml");
  EXPECT_FALSE(parsed.stealing);
  EXPECT_TRUE(std::get<Options>(parse({"--scheduler", "static-20s", "--virtual"})).stealing);
  EXPECT_EQ(code_of({"--costs", "c.yaml"}), 2) << "catan measures itself";
  EXPECT_EQ(code_of({"--scheduler", "static-20s"}), 2) << "on one CPU, or on several?";
}

TEST(Options, SaysWhatYoloNeeds) {
  const auto parsed = parse({"--detector", "yolo"});
  EXPECT_NE(std::get<Leave>(parsed).text.find("--model FILE.cfg FILE.weights"), std::string::npos);
}

TEST(Options, MistakesLeaveWithTwo) {
  EXPECT_EQ(code_of({"--cpus", "0,,1"}), 2);
  EXPECT_EQ(code_of({"--seconds", "0"}), 2);
  EXPECT_EQ(code_of({"--seconds", "nan"}), 2);
  EXPECT_EQ(code_of({"--slowdown", "0.5"}), 2);
  EXPECT_EQ(code_of({"--mover-speed", "0"}), 2);
  EXPECT_EQ(code_of({"--seed", "x"}), 2);
  EXPECT_EQ(code_of({"--runs", "0"}), 2);
  EXPECT_EQ(code_of({"--cores", "2"}), 2) << "only in virtual time";
  EXPECT_EQ(code_of({"--calibration", "life.json"}), 2) << "only in virtual time";
  EXPECT_EQ(code_of({"--virtual", "--cores", "0"}), 2);
  EXPECT_EQ(code_of({"--virtual", "--cpus", "0"}), 2);
  EXPECT_EQ(code_of({"--runs", "2", "--record", "r"}), 2) << "a record is of one run";
  EXPECT_EQ(code_of({"--out", "d"}), 2) << "only with --runs";
  EXPECT_EQ(code_of({"--detector", "eyes"}), 2);
  EXPECT_EQ(code_of({"--detector", "yolo"}), 2) << "needs a network";
  EXPECT_EQ(code_of({"--detector", "yolo", "--model", "a.cfg"}), 2) << "two files";
  EXPECT_EQ(code_of({"--detector", "hog", "--model", "a.cfg", "a.weights"}), 2) << "needs no network";
  EXPECT_EQ(code_of({"--film", "a.avi"}), 2) << "seen by no detector";
  EXPECT_EQ(code_of({"--detector", "hog", "--scheduler", "fast-local"}), 2) << "there is no such app file";
  EXPECT_EQ(code_of({"--frobnicate"}), 2);
  EXPECT_EQ(code_of({"stray"}), 2);
}

TEST(Options, HelpHasExamples) { EXPECT_TRUE(program::testing::shows_examples(parse({"--help"}))); }

}  // namespace
}  // namespace ctn::navigation::run
