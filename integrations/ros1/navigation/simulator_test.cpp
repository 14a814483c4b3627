#include "ros1/navigation/simulator.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

namespace ctn::navigation::ros1 {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;

world::WorldFile corridor() {
  world::WorldFile file;
  file.name = "corridor";
  file.bounds = {{0.0, 0.0}, {12.0, 4.0}};
  file.walls = sides_of({{0.0, 0.0}, {12.0, 0.0}, {12.0, 4.0}, {0.0, 4.0}});
  file.start = {1.0, 2.0, 0.0};
  file.goal = Point{6.0, 2.0};
  return file;
}

class SimulatorTest : public testing::Test {
 protected:
  std::vector<std::chrono::nanoseconds> stamps;
  Simulator simulator{corridor(), 1, [this](const run::Reading& reading) {
                        EXPECT_EQ(reading.scan.stamp, reading.odometry.stamp);
                        stamps.push_back(reading.scan.stamp);
                      }};
};

TEST_F(SimulatorTest, GivesAReadingForEachInstantHoweverLateItIsAsked) {
  simulator.advance(0ms);
  EXPECT_EQ(simulator.next_due(), 20ms);
  simulator.advance(19ms);
  simulator.advance(20ms);
  simulator.advance(67ms);
  EXPECT_THAT(stamps, ElementsAre(0ms, 20ms, 40ms, 60ms));
  EXPECT_EQ(simulator.latest(), 27ms) << "that of 40 ms";
}

TEST_F(SimulatorTest, WhatComesCountsFromThenOn) {
  simulator.advance(0ms);
  simulator.move(50ms, {0.75, 0.0}, 20ms);
  EXPECT_THAT(stamps, ElementsAre(0ms, 20ms, 40ms)) << "readings that were due come first";
  simulator.guided(130ms, {1.0, 2.0, 0.0}, 100ms);
  simulator.advance(1050ms);
  const run::Findings findings = simulator.findings();
  EXPECT_THAT(findings.scan_ages, ElementsAre(run::AgeSample{50ms, 30ms}));
  EXPECT_THAT(findings.guidance_ages, ElementsAre(run::AgeSample{130ms, 30ms}));
  EXPECT_NEAR(findings.way, 0.28125 + 0.25 * 0.75, 0.002) << "0.75 m/s after 0.75 s, at 1 m/s^2";
  EXPECT_TRUE(findings.appearances.empty());
}

TEST_F(SimulatorTest, IsOverAtTheGoal) {
  simulator.move(0ms, {0.75, 0.0}, 0ms);
  simulator.advance(6s);
  EXPECT_FALSE(simulator.over());
  simulator.advance(7s);
  EXPECT_TRUE(simulator.over());
  EXPECT_TRUE(simulator.findings().reached_at);
  EXPECT_TRUE(simulator.findings().contacts.empty());
}

// As GP says for ten seconds.
TEST_F(SimulatorTest, IsOverWhenNothingIsLeftToExplore) {
  auto path = std::make_shared<Path>();
  path->outcome = Path::Outcome::kNothingLeft;
  simulator.planned(1s, path);
  simulator.advance(10s);
  EXPECT_FALSE(simulator.over());
  simulator.planned(10s, path);
  simulator.advance(12s);
  EXPECT_TRUE(simulator.over());
}

}  // namespace
}  // namespace ctn::navigation::ros1
