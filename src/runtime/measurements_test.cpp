#include "runtime/measurements.h"

#include <gtest/gtest.h>

namespace ctn::runtime {
namespace {

using std::chrono::milliseconds;

TEST(SampleWindow, KeepsTheNewestAndCountsAll) {
  SampleWindow window;
  for (std::size_t k = 0; k < SampleWindow::kSamples; ++k) window.add(milliseconds{1});
  EXPECT_EQ(window.summary_ms().mean, 1.0);
  for (std::size_t k = 0; k < SampleWindow::kSamples; ++k) window.add(milliseconds{3});
  EXPECT_EQ(window.summary_ms().mean, 3.0);
  EXPECT_EQ(window.summary_ms().count, 2 * SampleWindow::kSamples);
}

}  // namespace
}  // namespace ctn::runtime
