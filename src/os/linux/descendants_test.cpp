#include "os/linux/descendants.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>

#include "os/linux/forked_process.h"

namespace ctn::os {
namespace {

TEST(Descendants, ReadsWhatTheKernelSays) {
  const auto found = parse_parentage("42 (cat) S 7 42 1 0 -1");
  ASSERT_TRUE(found);
  EXPECT_EQ(found->parent, ProcessId{7});
  EXPECT_EQ(found->state, 'S');
  EXPECT_FALSE(found->guardian);
  EXPECT_EQ(parse_parentage("42 (a) R 1 (b) Z 8 1")->parent, ProcessId{8}) << "names hold anything";
  EXPECT_TRUE(parse_parentage("42 (catan-guard) S 7 42 1")->guardian);
  for (const char* const odd :
       {"", "42", "42 (cat)", "42 (cat) S", "42 (cat) S x 1", "42 )cat( S 7 1", "42 (cat) S 7"}) {
    EXPECT_FALSE(parse_parentage(odd)) << odd;
  }
}

TEST(Descendants, OrphansAreAdoptedFoundAndCollected) {
  ASSERT_TRUE(adopt_orphans());
  const SyncPipe told;
  ForkedProcess child([&] {
    const pid_t grandchild = ::fork();
    if (grandchild == 0) {
      ::setsid();
      ::pause();
    }
    told.send(grandchild);
    return 0;
  });
  const auto number = told.receive();
  ASSERT_TRUE(number);
  const ProcessId orphan{*number};
  EXPECT_EQ(child.join(), 0);
  const auto is_there = [&] {
    const std::vector<ProcessId> all = descendants();
    return std::find(all.begin(), all.end(), orphan) != all.end();
  };
  EXPECT_TRUE(is_there());
  ::kill(*number, SIGKILL);
  for (int millisecond = 0; is_there() && millisecond < 5000; ++millisecond) ::usleep(1000);
  EXPECT_FALSE(is_there());
  // Its first thread may have ended before others have that a sanitizer gave it; it can be reaped when all have.
  siginfo_t ended{};
  ASSERT_EQ(::waitid(P_PID, static_cast<id_t>(*number), &ended, WEXITED | WNOWAIT), 0);
  reap_orphans({orphan});
  EXPECT_EQ(::kill(*number, 0), 0) << "left to its owner";
  reap_orphans({});
  EXPECT_NE(::kill(*number, 0), 0);
}

}  // namespace
}  // namespace ctn::os
