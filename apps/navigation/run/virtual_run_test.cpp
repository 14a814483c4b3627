// The whole app in virtual time.
#include "run/virtual_run.h"

#include <gtest/gtest.h>

#include <string>

namespace ctn::navigation::run {
namespace {

using namespace std::chrono_literals;

Options short_run(const std::string& scheduler, std::uint64_t seed) {
  Options options;
  options.app_file = NAVIGATION_FOLDER "/robot.yaml";
  options.world_file = NAVIGATION_FOLDER "/worlds/map1.yaml";
  options.virtual_time = true;
  options.scheduler = options.policy = scheduler;
  options.seconds = 8.0;
  options.seed = seed;
  return options;
}

Outcome outcome_of(const Options& options, std::chrono::nanoseconds step = 500ms) {
  auto world = world::read_world(options.world_file);
  EXPECT_TRUE(world.ok());
  auto outcome = run_virtually(options, *world, {.signal = {}, .show = {}, .step = step});
  EXPECT_TRUE(outcome.ok()) << (outcome.ok() ? "" : outcome.error().message());
  return outcome.ok() ? *outcome : Outcome{};
}

TEST(VirtualRun, IsTheSameEachTimeAndWithAnyStep) {
  for (const char* scheduler : {"catan", "default"}) {
    const std::string once = to_json(outcome_of(short_run(scheduler, 1)));
    EXPECT_EQ(to_json(outcome_of(short_run(scheduler, 1))), once) << scheduler;
    EXPECT_EQ(to_json(outcome_of(short_run(scheduler, 1), 70ms)), once) << scheduler;
    EXPECT_NE(to_json(outcome_of(short_run(scheduler, 2))), once) << scheduler;
  }
}

TEST(VirtualRun, DrivesAndIsMeasured) {
  for (const char* scheduler : {"catan", "default"}) {
    const Outcome outcome = outcome_of(short_run(scheduler, 1));
    EXPECT_GT(outcome.findings.way, 1.0) << scheduler;
    EXPECT_EQ(outcome.findings.lasted, 8s);
    EXPECT_FALSE(outcome.findings.guidance_ages.empty());
    for (const AgeSample& sample : outcome.findings.scan_ages) ASSERT_GT(sample.age, 0ns);
    ASSERT_FALSE(outcome.snapshot.chains.empty());
    EXPECT_GT(outcome.snapshot.chains.front().response_ms.count, 10U);
  }
}

TEST(VirtualRun, SlowerBoardsTakeLonger) {
  const auto mapping_ms = [](double slowdown) {
    Options options = short_run("default", 1);
    options.seconds = 4.0;
    options.slowdown = slowdown;
    const Outcome outcome = outcome_of(options);
    for (const NodeSnapshot& node : outcome.snapshot.nodes) {
      if (node.name == "LM") return node.compute_ms.mean;
    }
    return 0.0;
  };
  EXPECT_GT(mapping_ms(3.0) / mapping_ms(1.0), 1.5);
}

}  // namespace
}  // namespace ctn::navigation::run
