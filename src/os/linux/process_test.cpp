#include "os/linux/process.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <string>

#include "os/linux/forked_process.h"
#include "os/linux/testing/fabricated_tree.h"
#include "os/testing/requires_real_time.h"

namespace ctn::os {
namespace {

ThreadId this_thread() { return ThreadId{static_cast<pid_t>(::syscall(SYS_gettid))}; }

std::string stat_of(const std::string& name) {
  std::string text = "42 (" + name + ") S";
  for (int field = 4; field <= 52; ++field) text += ' ' + std::to_string(field == 22 ? 987654321 : field);
  return text + '\n';
}

TEST(StartTime, IsThatOfTheThread) {
  const auto ours = start_time(this_thread());
  ASSERT_TRUE(ours.has_value());
  EXPECT_EQ(start_time(this_thread()), ours);
  const ForkedProcess child([] { return ::pause(); });
  const auto theirs = start_time(ThreadId{child.number()});
  ASSERT_TRUE(theirs.has_value());
  EXPECT_GE(*theirs, *ours);
  EXPECT_EQ(start_time(ThreadId{0}), std::nullopt);
  EXPECT_EQ(start_time(ThreadId{-1}), std::nullopt);
  EXPECT_EQ(start_time(ThreadId{0x3fffffff}), std::nullopt);
}

TEST(Ending, IsAProcessThatIsBeingReapedOrGone) {
  EXPECT_FALSE(is_ending(ProcessId{::getpid()}));
  {
    ForkedProcess child([] { return ::pause(); });
    EXPECT_FALSE(is_ending(ProcessId{child.number()}));
    ::kill(child.number(), SIGKILL);
    const Descriptor end = watch_process(ProcessId{child.number()});
    pollfd source{end.number(), POLLIN, 0};
    ASSERT_EQ(::poll(&source, 1, 5000), 1);
    EXPECT_TRUE(is_ending(ProcessId{child.number()})) << "it has not been reaped";
  }
  EXPECT_TRUE(is_ending(ProcessId{0x3fffffff}));
}

TEST(StartTime, IsFoundBehindAnyName) {
  for (const char* name : {"catan", "a b", ") S 1 2 3", "((", ")))", "", "x\ny) Z 0"}) {
    EXPECT_EQ(parse_start_time(stat_of(name)), 987654321U) << name;
  }
  ForkedProcess child([] {
    ::prctl(PR_SET_NAME, ") R 1 2 (3)");
    const auto found = start_time(this_thread());
    const auto parents = start_time(ThreadId{::getppid()});
    return found && parents && *found >= *parents ? 0 : 1;
  });
  EXPECT_EQ(child.join(), 0);
}

TEST(StartTime, OddTextsHaveNone) {
  const std::string whole = stat_of("catan");
  for (std::size_t length = 0; length < whole.find("987654321"); ++length) {
    EXPECT_EQ(parse_start_time(std::string_view(whole).substr(0, length)), std::nullopt);
  }
  std::string negative = whole;
  negative.replace(negative.find("987654321"), 9, "-1");
  EXPECT_EQ(parse_start_time(negative), std::nullopt);
  std::string double_blank = whole;
  double_blank.replace(double_blank.find(" S "), 3, " S  ");
  EXPECT_EQ(parse_start_time(double_blank), std::nullopt);
  FabricatedTree tree;
  tree.write("proc/42/stat", whole).write("proc/43/stat", "");
  EXPECT_EQ(start_time(ThreadId{42}, tree.roots()), 987654321U);
  EXPECT_EQ(start_time(ThreadId{43}, tree.roots()), std::nullopt);
  EXPECT_EQ(read_start_time(std::string(2000, 'x').c_str(), ThreadId{42}), std::nullopt);
}

TEST(WatchedProcess, IsReadableOnceItHasEnded) {
  ForkedProcess child([] { return ::pause(); });
  const Descriptor watched = watch_process(child.process());
  CATAN_REQUIRE(watched.valid(), "needs a kernel with pidfd_open (Linux 5.3)");
  pollfd source{watched.number(), POLLIN, 0};
  EXPECT_EQ(::poll(&source, 1, 0), 0);
  ::kill(child.number(), SIGKILL);
  EXPECT_EQ(::poll(&source, 1, 10'000), 1);
  const ProcessId gone = child.process();
  child.join();
  EXPECT_FALSE(watch_process(gone).valid());
  EXPECT_EQ(errno, ESRCH);
}

}  // namespace
}  // namespace ctn::os
