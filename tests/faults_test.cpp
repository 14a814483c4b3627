// A few of each fault (faults/faults.h), on the real machine: what must hold does hold. Times are bounded, too; the
// benchmark measures them.
#include "faults/faults.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "os/linux/linux_os.h"
#include "os/testing/requires_real_time.h"

namespace ctn::faults {
namespace {

constexpr int kTimes = 5;
// What must be over by when, after what the fault takes by itself (Fault::by_design). Most takes milliseconds; programs
// into whose memory garbage was written wait for the next server.
#ifdef CATAN_SANITIZED
// Sanitizers make server and programs ten times as slow, on a CPU whose nodes leave them what is over: no defect.
constexpr double kSlowness = 5.0;
#else
constexpr double kSlowness = 1.0;
#endif
constexpr double kLongestMs = 2000.0 * kSlowness;
constexpr double kLongestUntrueMs = 5000.0 * kSlowness;

class FaultsTest : public testing::TestWithParam<Fault> {};

TEST_P(FaultsTest, IsSurvived) {
  CATAN_REQUIRE_REAL_TIME(*os::make_linux_os());
  const FaultReport report = inject(GetParam(), kTimes, {CATAN_COMMAND, FAULT_PLAYER});
  EXPECT_EQ(report.survived, report.injected);
  EXPECT_GE(report.injected, kTimes);
  EXPECT_EQ(report.records_whole, report.records);
  EXPECT_EQ(report.raised_left, 0);
  EXPECT_LE(report.files_left, 0);
  const double longest = to_millis(GetParam().by_design).count() + (GetParam().untrue ? kLongestUntrueMs : kLongestMs);
  for (const Recovery& recovery : report.recoveries) {
    EXPECT_TRUE(!recovery.ms.empty() || !recovery.all);
    for (const double ms : recovery.ms) EXPECT_LT(ms, longest) << "until " << recovery.until;
  }
  for (const std::string& failure : report.failures) ADD_FAILURE() << failure;
}

std::string name_of(const testing::TestParamInfo<Fault>& info) {
  std::string name = info.param.name;
  std::replace_if(
      name.begin(), name.end(), [](char c) { return std::isalnum(static_cast<unsigned char>(c)) == 0; }, '_');
  return name;
}

INSTANTIATE_TEST_SUITE_P(All, FaultsTest, testing::ValuesIn(all_faults()), name_of);

}  // namespace

// For messages of the test framework.
void PrintTo(const Fault& fault, std::ostream* out) { *out << fault.name; }

}  // namespace ctn::faults
