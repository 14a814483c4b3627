#include "status_line.h"

#include <gtest/gtest.h>
#include <pty.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <functional>
#include <string>

namespace ctn::tool {
namespace {

Snapshot measured() {
  Snapshot snapshot;
  snapshot.warmed_up = true;
  snapshot.source_hz = 30.0;
  snapshot.chains.emplace_back().response_ms.mean = 12.5;
  return snapshot;
}

TEST(StatusText, SaysHowFarTheRunIsAndWhatItCameTo) {
  EXPECT_EQ(status_text({}, 0.0, 10.0), "warming up");
  EXPECT_EQ(status_text(measured(), 2.0, 10.0), "2.0 of 10 s  30.0 Hz  response 12.5 ms");
  EXPECT_EQ(status_text(measured(), 2.0, std::nullopt), "2.0 s  30.0 Hz  response 12.5 ms");
}

TEST(StatusText, SaysWhatThePlanRelaxesAndAssumesWhileItDoes) {
  Snapshot snapshot = measured();
  snapshot.relax_factor = 1.25;
  snapshot.relaxed = {{"objective[0].max", 40.0, 50.0}};
  EXPECT_EQ(status_text(snapshot, 2.0, std::nullopt),
            "2.0 s  30.0 Hz  response 12.5 ms  bounds relaxed by 1.25 (objective[0].max)");
  snapshot.relaxed.push_back({"nodes.b.min_rate", 10.0, 12.0});
  snapshot.assumed = {{"b", 5.0}, {"c", 5.0}, {"d", 5.0}};
  EXPECT_EQ(status_text(snapshot, 2.0, std::nullopt),
            "2.0 s  30.0 Hz  response 12.5 ms  bounds relaxed by 1.25 (objective[0].max and 1 more)  cost assumed of b "
            "and 2 more");
}

// Guards: catan serve let no program register while its terminal was stopped.
TEST(StatusLine, DoesNotWaitForATerminalThatDoesNotRead) {
  int terminal = -1;
  int program = -1;
  ASSERT_EQ(openpty(&terminal, &program, nullptr, nullptr, nullptr), 0);
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    alarm(30);  // ends a child that waits
    dup2(program, STDERR_FILENO);
    {
      const StatusLine line;
      // More than a terminal keeps for who does not read.
      for (int count = 0; count < 10'000; ++count) line.show(std::string(100, 'x'));
    }
    _exit(0);
  }
  close(program);
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status)) << "it waited";
  close(terminal);
}

// What a child shows on a terminal by `show`, which is called until something is.
std::string shown_on_a_terminal(const std::function<void()>& show) {
  int terminal = -1;
  int program = -1;
  EXPECT_EQ(openpty(&terminal, &program, nullptr, nullptr, nullptr), 0);
  const pid_t child = fork();
  EXPECT_GE(child, 0);
  if (child == 0) {
    alarm(60);
    dup2(program, STDERR_FILENO);
    show();
    _exit(0);
  }
  close(program);
  std::string text;
  std::array<char, 256> buffer{};
  for (ssize_t count = 0; (count = read(terminal, buffer.data(), buffer.size())) > 0;) {
    text.append(buffer.data(), static_cast<std::size_t>(count));
  }
  close(terminal);
  int status = 0;
  EXPECT_EQ(waitpid(child, &status, 0), child);
  EXPECT_EQ(status, 0);
  return text;
}

TEST(ProgressLine, TellsNothingOfWhatDoesNotTakeLong) {
  EXPECT_EQ(shown_on_a_terminal([] {
              ProgressLine line("exported");
              for (int percent = 0; percent <= 100; ++percent) line.show(percent / 100.0);
            }),
            "\r\033[K");
}

TEST(ProgressLine, TellsHowFarItIsAndIsGoneAtTheEnd) {
  const auto shown = [](const std::function<void(ProgressLine&)>& show) {
    return shown_on_a_terminal([&] {
      ProgressLine line("read");
      const auto until = std::chrono::steady_clock::now() + std::chrono::milliseconds{2100};
      while (std::chrono::steady_clock::now() < until) show(line);
    });
  };
  EXPECT_EQ(shown([](ProgressLine& line) { line.show(0.42); }), "\r\033[Kread: 42 %\r\033[K");
  EXPECT_EQ(shown([](ProgressLine& line) { line.show_count(8192); }), "\r\033[Kread: 8192 events\r\033[K");
}

}  // namespace
}  // namespace ctn::tool
