#include "run/headset_app.h"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "catan/simulation.h"
#include "program/temporary_folder.h"

namespace ctn::vr::run {
namespace {

// What is in the repository is what the program makes where nothing else is asked for.
TEST(HeadsetApp, IsTheFile) {
  std::ostringstream file;
  file << std::ifstream(VR_FOLDER "/headset.yaml").rdbuf();
  EXPECT_EQ(app_text({}), file.str());
}

TEST(HeadsetApp, CanBeRunForAllOptions) {
  const auto folder = program::TemporaryFolder::make("headset_app_test");
  ASSERT_TRUE(folder.ok());
  for (const char* scheduler : {"catan", "paper", "default", "fifo", "pacer"}) {
    for (const double hz : {30.0, 59.94, 72.0, 90.0, 144.0, 500.0}) {
      for (const bool clocked : {false, true}) {
        Options options;
        options.scheduler = scheduler;
        options.hz = hz;
        if (clocked) options.camera_hz = 25.0;
        const auto path = (*folder)->write("app.yaml", app_text(options));
        ASSERT_TRUE(path.ok());
        const std::string policy = options.scheduler == "pacer" ? "fifo" : options.scheduler;
        const auto simulation =
            Simulation::open(*path, {.costs = {}, .policy = policy, .cores = 1, .record = {}, .note = {}});
        EXPECT_TRUE(simulation.ok()) << scheduler << " " << hz << "\n"
                                     << (simulation.ok() ? "" : simulation.error().message()) << app_text(options);
      }
    }
  }
}

}  // namespace
}  // namespace ctn::vr::run
