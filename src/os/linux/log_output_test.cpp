// A pipe with nobody behind it is the file that takes nothing.
#include "os/linux/log_output.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <csignal>
#include <string>

#include "os/linux/descriptor.h"

namespace ctn::os {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

class LogOutputTest : public ::testing::Test {
 protected:
  LogOutputTest() {
    std::array<int, 2> ends{};
    EXPECT_EQ(::pipe2(ends.data(), O_CLOEXEC), 0);
    reader = Descriptor(ends[0]);
    writer = Descriptor(ends[1]);
  }
  static std::string tell_lost(std::uint64_t texts) { return fmt::format("[{} lost]\n", texts); }

  // What was written before nobody was there to read it.
  void fill() {
    const std::string page(4096, '.');
    const int flags = ::fcntl(writer.number(), F_GETFL);
    ::fcntl(writer.number(), F_SETFL, flags | O_NONBLOCK);
    while (::write(writer.number(), page.data(), page.size()) > 0) {
    }
    ::fcntl(writer.number(), F_SETFL, flags);
  }
  // All up to, and with, this text.
  std::string read_until(const std::string& last) const {
    std::string all;
    std::array<char, 4096> buffer{};
    while (all.find(last) == std::string::npos) {
      const ssize_t count = ::read(reader.number(), buffer.data(), buffer.size());
      if (count <= 0) break;
      all.append(buffer.data(), static_cast<std::size_t>(count));
    }
    return all.substr(all.find_first_not_of('.') == std::string::npos ? all.size() : all.find_first_not_of('.'));
  }

  Descriptor reader;
  Descriptor writer;
};

TEST_F(LogOutputTest, WritesAllInOrder) {
  LogOutput log(writer.number(), tell_lost);
  std::string expected;
  for (int count = 0; count < 100; ++count) {
    expected += fmt::format("{}\n", count);
    log.write(fmt::format("{}\n", count));
  }
  EXPECT_TRUE(log.finish(seconds{20}));
  EXPECT_EQ(read_until("99\n"), expected);
}

TEST_F(LogOutputTest, NobodyWaitsForAFileThatTakesNothing) {
  fill();
  LogOutput log(writer.number(), tell_lost);
  for (int count = 0; count < 2000; ++count) log.write("more\n");
  EXPECT_FALSE(log.finish(milliseconds{20}));
  static_cast<void>(writer.release());  // the thread that is left to itself has it, which nobody else may get
}  // nor does the destructor wait

TEST_F(LogOutputTest, WhatWasLostIsToldInItsPlace) {
  fill();
  LogOutput log(writer.number(), tell_lost);
  log.write("first\n");
  // The thread has taken one by now, or will: one more or less is lost.
  for (std::size_t count = 0; count < LogOutput::kKept; ++count) log.write("kept\n");
  for (int count = 0; count < 5; ++count) log.write("lost\n");
  const std::string read = read_until(" lost]\n");
  EXPECT_TRUE(read.starts_with("first\nkept\n")) << read.substr(0, 100);
  EXPECT_TRUE(read.ends_with("[5 lost]\n") || read.ends_with("[6 lost]\n") || read.ends_with("[4 lost]\n"))
      << read.substr(read.size() - 40);
  log.write("later\n");
  EXPECT_EQ(read_until("later\n"), "later\n");
  EXPECT_TRUE(log.finish(seconds{20}));
}

// The thread is there for as long as something is not written; a signal for the process is none of its business.
TEST_F(LogOutputTest, AReaderThatIsGoneEndsNothing) {
  reader = {};
  struct sigaction before {};
  struct sigaction by_default {};
  by_default.sa_handler = SIG_DFL;
  ::sigaction(SIGPIPE, &by_default, &before);
  LogOutput log(writer.number(), tell_lost);
  log.write("nobody\n");
  log.write("reads this\n");
  EXPECT_TRUE(log.finish(seconds{20}));
  ::sigaction(SIGPIPE, &before, nullptr);
}

}  // namespace
}  // namespace ctn::os
