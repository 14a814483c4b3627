#include "run/options.h"

#include <gtest/gtest.h>

#include <initializer_list>
#include <vector>

#include "program/testing/parsed.h"

namespace ctn::vr::run {
namespace {

using program::Leave;

std::variant<Options, Leave> parse(std::initializer_list<const char*> words) {
  return program::testing::parsed("vr", words, parse_options);
}
int code_of(std::initializer_list<const char*> words) { return program::testing::code_of(parse(words)); }

TEST(Options, AreWhatWasGiven) {
  const auto options = std::get<Options>(parse({"--scheduler",
                                                "default",
                                                "--cpus",
                                                "0,2-4",
                                                "--size",
                                                "640x480",
                                                "--hz",
                                                "90",
                                                "--camera",
                                                "20",
                                                "--seconds",
                                                "12.5",
                                                "--seed",
                                                "9",
                                                "--record",
                                                "r.db",
                                                "--drift",
                                                "50",
                                                "--warp",
                                                "translational",
                                                "--slowdown",
                                                "2",
                                                "--json",
                                                "--app",
                                                "a.yaml",
                                                "--pictures",
                                                "p",
                                                "--tracking-slowdown",
                                                "1"}));
  EXPECT_EQ(options.scheduler, "default");
  EXPECT_EQ(options.cpus, (std::vector<int>{0, 2, 3, 4}));
  EXPECT_EQ(options.width, 640);
  EXPECT_EQ(options.height, 480);
  EXPECT_EQ(options.hz, 90.0);
  EXPECT_EQ(options.display_period().count(), 11'111'111);
  EXPECT_EQ(options.camera_hz, 20.0);
  EXPECT_EQ(options.seconds, 12.5);
  EXPECT_EQ(options.seed, 9U);
  EXPECT_EQ(options.drift_ppm, 50.0);
  EXPECT_TRUE(options.translational);
  EXPECT_EQ(options.slowdown, 2.0);
  EXPECT_EQ(options.tracking_slowdown, 1.0);
  EXPECT_EQ(options.app_file, "a.yaml");
  EXPECT_EQ(options.record, "r.db");
  EXPECT_EQ(options.pictures, "p");
  EXPECT_TRUE(options.json);
  EXPECT_FALSE(options.virtual_time);
}

TEST(Options, OfVirtualTimeAndBatches) {
  const auto options = std::get<Options>(parse({"--virtual", "--cores", "2", "--runs", "20", "--out", "d"}));
  EXPECT_TRUE(options.virtual_time);
  EXPECT_EQ(options.cores, 2);
  EXPECT_EQ(options.runs, 20);
  EXPECT_EQ(options.out, "d");
  EXPECT_EQ(options.camera_hz, std::nullopt) << "triggered";
}

TEST(Options, APacerRunsUnderFifo) {
  EXPECT_EQ(std::get<Options>(parse({"--scheduler", "pacer"})).policy, "fifo");
  EXPECT_EQ(std::get<Options>(parse({"--scheduler", "paper"})).policy, "paper");
}

TEST(Options, MistakesLeaveWithTwo) {
  EXPECT_EQ(code_of({"--cpus", "0,,1"}), 2);
  EXPECT_EQ(code_of({"--size", "320"}), 2);
  EXPECT_EQ(code_of({"--size", "320x240x3"}), 2);
  EXPECT_EQ(code_of({"--size", "8x240"}), 2);
  EXPECT_EQ(code_of({"--size", "320x4000"}), 2);
  EXPECT_EQ(code_of({"--hz", "0"}), 2);
  EXPECT_EQ(code_of({"--hz", "nan"}), 2);
  EXPECT_EQ(code_of({"--camera", "soon"}), 2);
  EXPECT_EQ(code_of({"--camera", "120"}), 2);
  EXPECT_EQ(code_of({"--warp", "sideways"}), 2);
  EXPECT_EQ(code_of({"--seconds", "0.5"}), 2);
  EXPECT_EQ(code_of({"--cores", "2"}), 2) << "only in virtual time";
  EXPECT_EQ(code_of({"--calibration", "life.json"}), 2) << "only in virtual time";
  EXPECT_EQ(code_of({"--virtual", "--cpus", "0"}), 2);
  EXPECT_EQ(code_of({"--runs", "2", "--record", "r"}), 2) << "a record is of one run";
  EXPECT_EQ(code_of({"--out", "d"}), 2) << "only with --runs";
  EXPECT_EQ(code_of({"--costs", "c.yaml"}), 2) << "catan measures itself";
  EXPECT_EQ(code_of({"--scheduler", "davare"}), 2) << "on one CPU, or on several?";
  EXPECT_EQ(code_of({"--dataset", "d", "--camera", "20"}), 2);
  EXPECT_EQ(code_of({"--frobnicate"}), 2);
}

TEST(Options, HelpHasExamples) { EXPECT_TRUE(program::testing::shows_examples(parse({"--help"}))); }

}  // namespace
}  // namespace ctn::vr::run
