#include "doctor/checkup.h"

#include <gtest/gtest.h>

#include <set>

#include "os/fake/fake_os.h"

namespace ctn::doctor {
namespace {

using namespace std::chrono_literals;

TEST(Checkup, OfAFakeMachineIsExact) {
  os::FakeOs os;
  os.set_real_time_facts({true, "", 0.05, "fair server"});
  const auto observed = observe(os, {});
  ASSERT_TRUE(observed.ok());
  EXPECT_EQ(observed->cpus, (os::CpuSet{0, 1}));
  EXPECT_EQ(observed->level, os::Level::kDispatcher);
  ASSERT_EQ(observed->wake_ups.size(), 2U);
  EXPECT_EQ(observed->wake_ups[1].cpu, 1);
  EXPECT_EQ(observed->wake_ups[1].lateness, std::vector<Nanos>(200, 0ns));
  EXPECT_EQ(observed->measured, 300ms) << "on all CPUs at once";
}

TEST(Checkup, EveryThreadGetsItsLevelBack) {
  os::FakeOs os;
  os.set_real_time_facts({true, "", 0.0, "nothing"});
  ASSERT_TRUE(observe(os, {}).ok());
  std::set<os::ThreadId> raised;
  std::set<os::ThreadId> raised_still;
  for (const auto& change : os.changes()) {
    if (!change.level) continue;
    if (*change.level == os::Level::kOrdinary) {
      raised_still.erase(change.thread);
    } else {
      raised.insert(change.thread);
      raised_still.insert(change.thread);
    }
  }
  EXPECT_EQ(raised.size(), 2U) << "one a CPU";
  EXPECT_TRUE(raised_still.empty());
}

TEST(Checkup, WithoutPermissionItMeasuresAtTheOrdinaryLevel) {
  os::FakeOs os;
  os.set_real_time_facts({false, "no privilege", 0.05, "fair server"});
  const auto observed = observe(os, os::CpuSet{1});
  ASSERT_TRUE(observed.ok());
  EXPECT_EQ(observed->level, os::Level::kOrdinary);
  EXPECT_EQ(observed->wake_ups.front().lateness.size(), 200U);
}

// At a real-time level that gets no CPU time, measuring would never end.
TEST(Checkup, NeverRaisesAThreadThatWouldStarve) {
  os::FakeOs os;
  os.set_real_time_facts({true, "", 1.0, "throttling"});
  EXPECT_EQ(observe(os, {})->level, os::Level::kOrdinary);
}

TEST(Checkup, CpuThatTheMachineDoesNotHaveIsTheCallersMistake) {
  os::FakeOs os;
  const auto observed = observe(os, os::CpuSet{0, 7});
  ASSERT_FALSE(observed.ok());
  EXPECT_EQ(observed.error().kind(), ErrorKind::kCaller);
}

TEST(Checkup, CpuThatIsOfflineIsRefusedAlone) {
  os::FakeOs os;
  os.set_real_time_facts({true, "", 0.05, "fair server"});
  os.set_cpu_online(1, false);
  const auto observed = observe(os, os::CpuSet{0, 1});
  ASSERT_TRUE(observed.ok());
  EXPECT_FALSE(observed->wake_ups[0].refused);
  EXPECT_TRUE(observed->wake_ups[1].refused);
  EXPECT_TRUE(observed->wake_ups[1].lateness.empty());
}

TEST(Checkup, PercentilesAreByNearestRank) {
  const WakeUps one{0, {1us, 2us, 3us, 4us}, std::nullopt};
  EXPECT_EQ(one.percentile(50.0), 2us);
  EXPECT_EQ(one.percentile(99.0), 4us);
  EXPECT_EQ(WakeUps{}.percentile(50.0), 0ns);
  EXPECT_EQ(together({one, {1, {0us, 9us}, std::nullopt}}).lateness,
            (std::vector<Nanos>{0us, 1us, 2us, 3us, 4us, 9us}));
}

TEST(Checkup, WorstFindingDecides) {
  EXPECT_EQ(worst({}), Verdict::kOk);
  EXPECT_EQ(worst({{"a", Verdict::kNote, {}, {}, {}, {}}, {"b", Verdict::kWarning, {}, {}, {}, {}}}),
            Verdict::kWarning);
  EXPECT_STREQ(to_string(Verdict::kProblem), "problem");
}

}  // namespace
}  // namespace ctn::doctor
