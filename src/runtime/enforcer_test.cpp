// In virtual time, with the fake OS: what threads get back.
#include "runtime/enforcer.h"

#include <gtest/gtest.h>

#include <memory>
#include <utility>

#include "os/fake/fake_os.h"
#include "os/fake/faulty_os.h"

namespace ctn::runtime {
namespace {

using os::CpuSet;
using os::Level;

class EnforcerTest : public ::testing::Test {
 protected:
  EnforcerTest() {
    node = fake.spawn("node", [this] {
      thread = fake.current_thread();
      fake.sleep_until(TimePoint{std::chrono::hours{1}});
    });
    fake.sleep_until(fake.now() + std::chrono::milliseconds{1});
  }
  void raise() { ASSERT_TRUE(enforcer.apply(thread, Level::kActive, CpuSet{1}).ok()); }

  os::FakeOs fake;
  os::ThreadId thread{};
  std::unique_ptr<os::Thread> node;
  Enforcer enforcer{fake, true, nullptr, nullptr};
};

TEST_F(EnforcerTest, AThreadGetsBackWhatItHadBeforeTheFirstApply) {
  raise();
  ASSERT_TRUE(enforcer.apply(thread, Level::kBackground, CpuSet{0}).ok());
  enforcer.restore(thread);
  EXPECT_EQ(*fake.level(thread), Level::kOrdinary);
  EXPECT_EQ(*fake.affinity(thread), (CpuSet{0, 1}));
}

// Guards: a thread that was named for a node while a session stopped stayed raised.
TEST_F(EnforcerTest, NoThreadIsRaisedOnceAllHaveBeenRestored) {
  enforcer.restore_for_good();
  raise();
  enforcer.raise(thread, Level::kActive);
  EXPECT_EQ(*fake.level(thread), Level::kOrdinary);
  EXPECT_EQ(*fake.affinity(thread), (CpuSet{0, 1}));
}

TEST_F(EnforcerTest, AThreadThatReusesTheNumberOfOneThatEndedIsNotTouched) {
  raise();
  fake.reuse_number(thread);
  enforcer.restore_all();
  enforcer.restore(thread);
  EXPECT_EQ(*fake.level(thread), Level::kActive) << "what raised it will lower it";
  EXPECT_EQ(*fake.affinity(thread), CpuSet{1});
}

TEST_F(EnforcerTest, ALevelThatWasTriedIsNotKept) {
  ASSERT_TRUE(enforcer.apply(thread, Level::kOrdinary, CpuSet{1}).ok());
  enforcer.try_level(thread, Level::kActive, fake.current_process());
  EXPECT_EQ(*fake.level(thread), Level::kOrdinary);
  EXPECT_TRUE(enforcer.real_time());
  fake.set_real_time_facts({false, "not here", 0.05, "fair server"});
  enforcer.try_level(thread, Level::kActive, fake.current_process());
  EXPECT_FALSE(enforcer.real_time());
}

// Its own program may restore it just then: no other thread is to pay for that.
TEST(Enforcer, ALevelThatAThreadOfAnotherProcessLosesAtOnceIsAskedForAgain) {
  os::FakeOs fake;
  os::FaultyOs faulty(fake);
  const os::ProcessId other{static_cast<int>(fake.current_process()) + 1};
  const os::ThreadId thread = fake.current_thread();
  Enforcer enforcer(faulty, true, *fake.start_guardian(), nullptr);
  faulty.ignore_next(os::Call::kSetLevel, 2);
  ASSERT_TRUE(enforcer.apply(thread, Level::kBackground, CpuSet{0}, other).ok());
  EXPECT_TRUE(enforcer.real_time());
  EXPECT_EQ(*fake.level(thread), Level::kBackground);
  faulty.ignore_next(os::Call::kSetLevel, 3);
  ASSERT_TRUE(enforcer.apply(thread, Level::kActive, CpuSet{0}, other).ok());
  EXPECT_FALSE(enforcer.real_time()) << "what never stays is refused";
}

TEST_F(EnforcerTest, AThreadThatReusesANumberGetsBackItsOwnScheduling) {
  raise();
  fake.reuse_number(thread);
  ASSERT_TRUE(fake.set_level(thread, Level::kOrdinary).ok());
  ASSERT_TRUE(fake.set_affinity(thread, CpuSet{0}).ok());
  raise();
  enforcer.restore_for_good();
  EXPECT_EQ(*fake.level(thread), Level::kOrdinary);
  EXPECT_EQ(*fake.affinity(thread), CpuSet{0});
}

}  // namespace
}  // namespace ctn::runtime
