#include "os/linux/background.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <csignal>
#include <string>

#include "os/linux/files.h"
#include "os/linux/forked_process.h"

namespace ctn::os {
namespace {

TEST(Background, YieldsToOthers) {
  ForkedProcess process([] {
    yield_to_others();
    return ::getpriority(PRIO_PROCESS, 0);
  });
  EXPECT_GE(process.join(), 5);
}

TEST(Background, LimitsAreOnlyEverLowered) {
  ForkedProcess process([] {
    limit_resources(64, std::uint64_t{1} << 40U);
    limit_resources(1U << 20U, std::uint64_t{1} << 40U);
    rlimit files{};
    ::getrlimit(RLIMIT_NOFILE, &files);
    return static_cast<int>(files.rlim_cur);
  });
  EXPECT_EQ(process.join(), 64);
}

TEST(Background, EndsWithItsParent) {
  const SyncPipe pipe;
  int child = 0;
  {
    ForkedProcess parent([&] {
      const ProcessId own{::getpid()};
      if (::fork() == 0) {
        pipe.send(end_with(own) ? ::getpid() : 0);
        while (true) ::pause();
      }
      return ::pause();
    });
    child = pipe.receive().value_or(0);
    ASSERT_GT(child, 0);
    parent.end(SIGKILL);
  }
  // Its end is collected by the process that adopts orphans here; until then it may be a zombie.
  bool ends = false;
  for (int i = 0; i < 1000 && !ends; ++i) {
    ends = ::kill(child, 0) != 0;
    if (!ends) {
      const auto stat = read_text("/proc/" + std::to_string(child) + "/stat");
      ends = !stat || stat->find(") Z ") != std::string::npos;
    }
    ::usleep(10'000);
  }
  EXPECT_TRUE(ends);
}

TEST(Background, AnotherParentIsTold) {
  ForkedProcess process([] { return end_with(ProcessId{1 << 22}) ? 1 : 0; });
  EXPECT_EQ(process.join(), 0);
}

TEST(Background, RandomDigitsDiffer) {
  const auto one = random_digits(16);
  ASSERT_TRUE(one.ok());
  EXPECT_EQ(one->size(), 32U);
  EXPECT_EQ(one->find_first_not_of("0123456789abcdef"), std::string::npos);
  EXPECT_NE(*one, *random_digits(16));
}

}  // namespace
}  // namespace ctn::os
