// What is measured and planned before a run, with runs of a small world in virtual time.
#include "run/scheme.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "run/testing/virtual_options.h"
#include "run/virtual_run.h"
#include "world/world_file.h"

namespace ctn::navigation::run {
namespace {

using ::testing::StartsWith;

class SchemeTest : public ::testing::Test {
 protected:
  static Options options(const std::string& scheduler, double seconds = 6.0) {
    return virtual_options(scheduler, seconds);
  }
  Result<Outcome> run(const Options& one) {
    runs_.push_back(one);
    auto world = world::read_world(one.world_file);
    if (!world) return world.error();
    return run_virtually(one, *world, nullptr, {.signal = {}, .show = {}});
  }
  // The run that these options' scheme begins with. It is stopped at once.
  static Options measuring_run_of(const Options& of) {
    Options asked;
    const auto scheme = Scheme::prepare(of, [&](const Options& one) -> Result<Outcome> {
      asked = one;
      Outcome outcome;
      outcome.options = one;
      outcome.signal = 2;
      return outcome;
    });
    EXPECT_TRUE(scheme.ok() && scheme->interrupted());
    return asked;
  }
  Scheme prepared(const Options& of) {
    auto scheme = Scheme::prepare(of, [this](const Options& one) { return run(one); });
    EXPECT_TRUE(scheme.ok()) << (scheme.ok() ? "" : scheme.error().message());
    return scheme.ok() ? *scheme : Scheme();
  }

  std::vector<Options> runs_;
};

TEST_F(SchemeTest, MostSchedulersNeedNothing) {
  for (const char* scheduler : {"catan", "paper", "default", "fifo", "davare:costs.yaml"}) {
    EXPECT_EQ(prepared(options(scheduler)).options().policy, scheduler);
  }
  EXPECT_TRUE(runs_.empty());
}

TEST_F(SchemeTest, ARunOnOneCoreMeasures) {
  Options two = options("static-20s", 30.0);
  two.cores = 2;
  two.stealing = false;
  two.pictures = "pictures";
  const Options measuring = measuring_run_of(two);
  EXPECT_EQ(measuring.policy, "catan");
  EXPECT_EQ(measuring.cores, 1);
  EXPECT_TRUE(measuring.stealing);
  EXPECT_EQ(measuring.seconds, 20.0) << "the first 20 s";
  EXPECT_EQ(measuring.pictures, "");
  EXPECT_EQ(measuring_run_of(options("davare", 30.0)).seconds, 30.0);
}

TEST_F(SchemeTest, APlanIsOfThatRunAndGoesWithTheScheme) {
  for (const int cores : {1, 2}) {
    Options asked = options("static-20s", 3.0);
    asked.cores = cores;
    const std::string policy = prepared(asked).options().policy;
    const std::string kind = cores == 1 ? "static:" : "rates-of:";
    EXPECT_THAT(policy, StartsWith(kind));
    EXPECT_FALSE(std::filesystem::exists(policy.substr(kind.size())));
  }
  EXPECT_EQ(runs_.size(), 2U);
}

// By hand, GM runs for the first time after five seconds, and the robot stands until then.
TEST_F(SchemeTest, RunsUnderEachOfThem) {
  constexpr double kSeconds = 8.0;
  // At rates set by hand, where most runs of GM have something to do: their costs at a percentile are what that takes.
  Options measured = options("default", kSeconds);
  measured.record = ::testing::TempDir() + "navigation_scheme.catan";
  std::filesystem::remove(measured.record);
  ASSERT_TRUE(run(measured).ok());
  for (const char* scheduler : {"static-full-run", "davare", "verucchi", "picas", "deadline"}) {
    Options asked = options(scheduler, kSeconds);
    asked.costs = measured.record;
    const Scheme scheme = prepared(asked);
    const auto outcome = run(scheme.options());
    ASSERT_TRUE(outcome.ok()) << scheduler << ": " << outcome.error().message();
    EXPECT_GT(outcome->findings.way, 0.5) << scheduler;
    EXPECT_FALSE(outcome->findings.guidance_ages.empty()) << scheduler;
  }
  std::filesystem::remove(measured.record);
}

TEST_F(SchemeTest, GivenComputeTimesAreTaken) {
  const std::string costs = ::testing::TempDir() + "navigation_scheme_costs.yaml";
  std::ofstream(costs) << "scan: 0.2ms\nLM: 3ms\nLP: 3ms\nGL: { modes: { skip: [0.8, 1ms], match: [0.2, 8ms] } }\n"
                          "GM: 40ms\nGP: 30ms\nNC: 0.1ms\n";
  Options given = options("picas");
  given.costs = costs;
  EXPECT_EQ(prepared(given).options().policy, "picas:" + costs);
  EXPECT_TRUE(runs_.empty());
  given.scheduler = "static-full-run";
  given.costs = "/nowhere";
  EXPECT_FALSE(Scheme::prepare(given, [this](const Options& one) { return run(one); }).ok());
  std::filesystem::remove(costs);
}

TEST_F(SchemeTest, ASignalWhileItMeasuresEndsAll) {
  const auto scheme = Scheme::prepare(options("davare"), [](const Options& one) -> Result<Outcome> {
    Outcome outcome;
    outcome.options = one;
    outcome.signal = 2;
    return outcome;
  });
  ASSERT_TRUE(scheme.ok());
  ASSERT_TRUE(scheme->interrupted());
  EXPECT_EQ(scheme->interrupted()->signal, 2);
}

}  // namespace
}  // namespace ctn::navigation::run
