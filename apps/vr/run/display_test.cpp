#include "run/display.h"

#include <gtest/gtest.h>

namespace ctn::vr::run {
namespace {

using namespace std::chrono_literals;

Picture picture_at(std::chrono::nanoseconds finished, double x) {
  Picture picture;
  picture.finished = finished;
  picture.drawn.position.x() = x;
  return picture;
}

TEST(Clock, TicksBeforeAndAfterItsFirst) {
  const Clock clock{3ms, 10ms};
  EXPECT_EQ(clock.last(13ms), 13ms);
  EXPECT_EQ(clock.last(12ms), 3ms);
  EXPECT_EQ(clock.last(0ms), -7ms);
  EXPECT_EQ(clock.next(13ms), 13ms);
  EXPECT_EQ(clock.next(13ms + 1ns), 23ms);
  EXPECT_EQ(clock.next(-8ms), -7ms);
}

TEST(Display, ShowsTheNewestPictureThatIsFinished) {
  Display display({2ms, 10ms});
  display.finished(picture_at(5ms, 1.0));
  display.finished(picture_at(9ms, 2.0));
  display.finished(picture_at(13ms, 3.0));
  display.advance(30ms);
  const auto& photons = display.photons();
  ASSERT_EQ(photons.size(), 2U) << "none before the first picture, and none after 30 ms";
  EXPECT_EQ(photons[0].tick, 12ms);
  EXPECT_EQ(photons[0].picture.drawn.position.x(), 2.0);
  EXPECT_EQ(photons[1].tick, 22ms);
  EXPECT_EQ(photons[1].picture.drawn.position.x(), 3.0);
}

TEST(Display, MissesATickWithoutANewPicture) {
  Display display({0ms, 10ms});
  display.finished(picture_at(5ms, 1.0));
  display.finished(picture_at(30ms, 2.0));
  display.advance(30ms);
  const auto& photons = display.photons();
  ASSERT_EQ(photons.size(), 3U);
  EXPECT_TRUE(photons[0].fresh);
  EXPECT_FALSE(photons[1].fresh);
  EXPECT_EQ(photons[1].picture.drawn.position.x(), 1.0);
  EXPECT_TRUE(photons[2].fresh) << "finished at the instant of the tick";
  EXPECT_EQ(photons[2].picture.drawn.position.x(), 2.0);
}

}  // namespace
}  // namespace ctn::vr::run
