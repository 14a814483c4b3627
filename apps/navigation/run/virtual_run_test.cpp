// The whole app in virtual time.
#include "run/virtual_run.h"

#include <gtest/gtest.h>

#include <string>

#include <opencv2/videoio.hpp>

#include "detector/cost.h"
#include "detector/testing/tiny_network.h"
#include "run/testing/virtual_options.h"

namespace ctn::navigation::run {
namespace {

using namespace std::chrono_literals;

Options short_run(const std::string& scheduler, std::uint64_t seed, double seconds = 8.0) {
  Options options = virtual_options(scheduler, seconds);
  options.seed = seed;
  return options;
}

Outcome outcome_of(const Options& options, std::chrono::nanoseconds step = 500ms) {
  auto world = world::read_world(options.world_file);
  EXPECT_TRUE(world.ok());
  auto detector = DetectorChain::open(options);
  EXPECT_TRUE(detector.ok());
  auto outcome = run_virtually(options, *world, *detector, {.signal = {}, .show = {}, .step = step});
  EXPECT_TRUE(outcome.ok()) << (outcome.ok() ? "" : outcome.error().message());
  return outcome.ok() ? *outcome : Outcome{};
}

TEST(VirtualRun, IsTheSameEachTimeAndWithAnyStep) {
  constexpr double kSeconds = 6.0;  // set by hand, GM runs for the first time after five
  for (const char* scheduler : {"catan", "default"}) {
    const Options options = short_run(scheduler, 1, kSeconds);
    const std::string once = to_json(outcome_of(options));
    EXPECT_EQ(to_json(outcome_of(options)), once) << scheduler;
    EXPECT_EQ(to_json(outcome_of(options, 70ms)), once) << scheduler;
    EXPECT_NE(to_json(outcome_of(short_run(scheduler, 2, kSeconds))), once) << scheduler;
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

// A film that shows nothing, and a network that needs no training.
Options with_detector(const std::string& scheduler, const std::string& detector) {
  Options options = short_run(scheduler, 1);
  options.app_file = NAVIGATION_FOLDER "/robot_with_detector.yaml";
  options.detector = detector;
  options.film = testing::own_file("film.avi");
  cv::VideoWriter film(options.film, cv::CAP_OPENCV_MJPEG, cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), 10.0,
                       {320, 240});
  for (int frame = 0; frame < 3; ++frame) film.write(cv::Mat(240, 320, CV_8UC3, cv::Scalar::all(40 * frame)));
  film.release();
  if (detector != "yolo") return options;
  const NetworkFiles network = testing::tiny_network();
  options.model = {network.description, network.weights};
  return options;
}

TEST(VirtualRun, TheDetectorCostsWhatItsWorkIsWorth) {
  for (const char* detector : {"hog", "yolo"}) {
    const Options options = with_detector("default", detector);
    const Outcome outcome = outcome_of(options);
    const auto chain = DetectorChain::open(options);
    ASSERT_TRUE(chain.ok());
    // At its 1 Hz, a first one at 0.
    EXPECT_NEAR(static_cast<double>(outcome.findings.detections.size()), 8.0, 1.0) << detector;
    for (const NodeSnapshot& node : outcome.snapshot.nodes) {
      if (node.name != "detect") continue;
      EXPECT_NEAR(node.compute_ms.mean, 1e3 * cost((*chain)->detect_work(), 1.0), 0.1) << detector;
    }
    EXPECT_EQ(to_json(outcome_of(options)), to_json(outcome)) << detector;
  }
}

TEST(VirtualRun, WithoutStealingIsAnotherRun) {
  Options without = short_run("paper", 1);
  without.slowdown = 8.0;  // so that runs are unfinished when their slots end
  Options with = without;
  without.stealing = false;
  EXPECT_TRUE(outcome_of(without).findings.scan_ages != outcome_of(with).findings.scan_ages);
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
