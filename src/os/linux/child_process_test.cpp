#include "os/linux/child_process.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <string>

#include "os/linux/poller.h"
#include "os/linux/signal_watch.h"

namespace ctn::os {
namespace {

using namespace std::chrono_literals;

Exit ended(ChildProcess& child) {
  const auto poller = Poller::make().value();
  EXPECT_TRUE(poller->add(child.descriptor(), 1).ok());
  poller->wait(kNever);
  const auto found = child.wait();
  EXPECT_TRUE(found.has_value());
  poller->remove(child.descriptor());
  return found.value_or(Exit{-1, -1});
}

Exit run(const std::string& script, const std::vector<std::string>& environment = {}) {
  auto child = ChildProcess::start({"sh", "-c", script}, environment);
  EXPECT_TRUE(child.ok()) << child.error().message();
  return ended(*child);
}

TEST(ChildProcess, TellsHowItEnded) {
  EXPECT_EQ(run("exit 0"), (Exit{0, 0}));
  EXPECT_EQ(run("exit 42"), (Exit{42, 0}));
  EXPECT_EQ(run("kill -9 $$"), (Exit{0, SIGKILL}));
}

TEST(ChildProcess, HasWhatIsAddedToTheEnvironment) {
  ::setenv("CATAN_TEST_KEPT", "kept", 1);
  ::setenv("CATAN_TEST_REPLACED", "old", 1);
  EXPECT_EQ(run("test \"$CATAN_TEST_KEPT-$CATAN_TEST_REPLACED-$CATAN_TEST_ADDED\" = 'kept-new=2-'",
                {"CATAN_TEST_REPLACED=new=2", "CATAN_TEST_ADDED="}),
            (Exit{0, 0}));
}

TEST(ChildProcess, WordsArePassedAsTheyAre) {
  auto child =
      ChildProcess::start({"sh", "-c", "test \"$1\" = 'a  b' && test -z \"$2\" && test $# = 2", "sh", "a  b", ""});
  ASSERT_TRUE(child.ok());
  EXPECT_EQ(ended(*child), (Exit{0, 0}));
}

TEST(ChildProcess, StartsWithNoSignalBlockedOrIgnored) {
  const auto watch = SignalWatch::start({SIGTERM, SIGUSR1});
  ASSERT_TRUE(watch.ok());
  const auto before = std::signal(SIGUSR2, SIG_IGN);
  EXPECT_EQ(run("kill -TERM $$; exit 1"), (Exit{0, SIGTERM}));
  EXPECT_EQ(run("kill -USR2 $$; exit 1"), (Exit{0, SIGUSR2}));
  std::signal(SIGUSR2, before);
}

TEST(ChildProcess, HasNoDescriptorOfOurs) {
  const Descriptor ours(::fcntl(STDIN_FILENO, F_DUPFD_CLOEXEC, 700));
  ASSERT_TRUE(ours.valid());
  EXPECT_EQ(run("test -e /proc/self/fd/0 && test ! -e /proc/self/fd/" + std::to_string(ours.number())), (Exit{0, 0}));
}

TEST(ChildProcess, PrintsToStandardErrorWhereOursIsForData) {
  const std::string path = testing::TempDir() + "catan_child_errors_" + std::to_string(::getpid());
  const Descriptor kept(::fcntl(STDERR_FILENO, F_DUPFD_CLOEXEC, 3));
  const Descriptor file(::open(path.c_str(), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0600));
  ASSERT_TRUE(kept.valid() && file.valid());
  ::dup2(file.number(), STDERR_FILENO);
  auto child = ChildProcess::start({"sh", "-c", "echo printed"}, {}, ChildProcess::Output::kErrors);
  ::dup2(kept.number(), STDERR_FILENO);
  ASSERT_TRUE(child.ok());
  EXPECT_EQ(ended(*child), (Exit{0, 0}));
  std::ifstream written(path);
  std::string line;
  std::getline(written, line);
  EXPECT_EQ(line, "printed");
  ::unlink(path.c_str());
}

TEST(ChildProcess, TakesSignalsWhileItRuns) {
  auto child = ChildProcess::start({"sleep", "60"});
  ASSERT_TRUE(child.ok());
  EXPECT_EQ(child->wait(), std::nullopt);
  EXPECT_EQ(child->signal(-1).error().kind(), ErrorKind::kCaller);
  EXPECT_TRUE(child->signal(SIGINT).ok());
  EXPECT_EQ(ended(*child), (Exit{0, SIGINT}));
  EXPECT_EQ(child->wait(), (Exit{0, SIGINT}));
  EXPECT_TRUE(child->signal(SIGINT).ok());
}

TEST(ChildProcess, NeitherItNorAZombieIsLeftBehind) {
  ProcessId process{};
  {
    auto child = ChildProcess::start({"sleep", "60"});
    ASSERT_TRUE(child.ok());
    const ChildProcess moved = std::move(*child);
    process = moved.process();
  }
  EXPECT_EQ(::kill(static_cast<pid_t>(process), 0), -1);
  EXPECT_EQ(errno, ESRCH);
}

TEST(ChildProcess, OneThatWillNotEndIsMadeTo) {
  ProcessId process{};
  {
    auto child = ChildProcess::start({"sh", "-c", "trap '' TERM; while :; do sleep 0.1; done"});
    ASSERT_TRUE(child.ok());
    process = child->process();
    ::usleep(100'000);
  }
  EXPECT_EQ(::kill(static_cast<pid_t>(process), 0), -1);
}

TEST(ChildProcess, WhatCannotBeStartedIsTheCallersMistake) {
  const auto why = [](const std::vector<std::string>& arguments, const std::vector<std::string>& environment) {
    const auto child = ChildProcess::start(arguments, environment);
    EXPECT_FALSE(child.ok());
    if (child.ok()) return std::string();
    EXPECT_EQ(child.error().kind(), ErrorKind::kCaller);
    return child.error().message();
  };
  EXPECT_THAT(why({"catan-no-such-program"}, {}), testing::HasSubstr("cannot start 'catan-no-such-program'"));
  EXPECT_THAT(why({"/etc/passwd"}, {}), testing::HasSubstr("cannot start '/etc/passwd'"));
  EXPECT_NE(why({}, {}), "");
  EXPECT_NE(why({""}, {}), "");
  EXPECT_THAT(why({"true"}, {"NAME"}), testing::HasSubstr("'NAME'"));
  EXPECT_NE(why({"true"}, {"=value"}), "");
}

// ---- Signals

TEST(SignalWatch, ReadsWhatCameInsteadOfBeingInterrupted) {
  auto watch = SignalWatch::start({SIGINT, SIGTERM});
  ASSERT_TRUE(watch.ok()) << watch.error().message();
  EXPECT_EQ(watch->next(), std::nullopt);
  ::kill(::getpid(), SIGTERM);
  const auto poller = Poller::make().value();
  ASSERT_TRUE(poller->add(watch->descriptor(), 3).ok());
  EXPECT_THAT(poller->wait(kNever), testing::ElementsAre(3));
  EXPECT_EQ(watch->next(), SIGTERM);
  EXPECT_EQ(watch->next(), std::nullopt);
}

volatile std::sig_atomic_t g_handled = 0;

TEST(SignalWatch, GivesSignalsBackAndForgetsWhatWasNotRead) {
  const auto before = std::signal(SIGUSR1, [](int) { g_handled = g_handled + 1; });
  {
    auto watch = SignalWatch::start({SIGUSR1});
    ASSERT_TRUE(watch.ok());
    const SignalWatch moved = std::move(*watch);
    ::raise(SIGUSR1);
  }
  EXPECT_EQ(g_handled, 0);
  ::raise(SIGUSR1);
  EXPECT_EQ(g_handled, 1);
  std::signal(SIGUSR1, before);
}

TEST(SignalWatch, WhatCannotBeBlockedCannotBeWatched) {
  for (const int number : {SIGKILL, SIGSTOP, 0, -1, 1000}) {
    const auto watch = SignalWatch::start({SIGUSR1, number});
    ASSERT_FALSE(watch.ok()) << number;
    EXPECT_EQ(watch.error().kind(), ErrorKind::kCaller);
  }
}

}  // namespace
}  // namespace ctn::os
