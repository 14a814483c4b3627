#include "run/live_headset.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <string>
#include <thread>
#include <vector>

#include "run/headset_app.h"

namespace ctn::vr::run {
namespace {

using namespace std::chrono_literals;
using std::chrono::nanoseconds;
using ::testing::Ge;
using ::testing::SizeIs;

class NoExposures final : public Exposures {
 public:
  Result<Exposure> newest(nanoseconds /*now*/) override { return Exposure{}; }
};

// Of a camera with a clock the session hears of each exposure, of when it was, once it has been.
TEST(LiveHeadset, TellsTicksOfTheDisplayAndOfTheCamera) {
  const auto surroundings = Surroundings::make(Options(), kImuPeriod);
  ASSERT_TRUE(surroundings.ok());
  NoExposures exposures;
  const std::vector<nanoseconds> exposed_at{-1ms, 5ms, 30ms, 31ms, 1h};
  LiveHeadset headset(**surroundings, {3ms, 8ms}, exposed_at, exposures);
  // The thread's own until it has ended.
  std::vector<nanoseconds> shown;
  std::vector<nanoseconds> exposed;
  std::atomic<bool> done = false;
  headset.start([&](const char* node, std::chrono::steady_clock::time_point tick) {
    const bool display = node == std::string(kDisplayNode);
    EXPECT_TRUE(display || node == std::string(kExposure)) << node;
    (display ? shown : exposed).push_back(tick.time_since_epoch());
    EXPECT_LE(tick, std::chrono::steady_clock::now());
    if (exposed.size() == 4) done = true;
  });
  static_cast<void>(headset.samples());  // time begins
  for (int look = 0; look < 6000 && !done; ++look) std::this_thread::sleep_for(10ms);
  headset.stop();
  ASSERT_THAT(exposed, SizeIs(4)) << "the last one did not come";
  ASSERT_THAT(shown, SizeIs(Ge(4U)));
  const nanoseconds begin = shown[0] - 3ms;
  EXPECT_EQ(shown[1] - begin, 11ms);
  for (std::size_t i = 0; i < exposed.size(); ++i) EXPECT_EQ(exposed[i] - begin, exposed_at[i]);
}

}  // namespace
}  // namespace ctn::vr::run
