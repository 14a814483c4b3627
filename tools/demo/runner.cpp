#include "runner.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <cstdio>
#include <cstdlib>

#include "load.h"

namespace ctn::demo {
namespace {

constexpr double kPatience = 60.0;  // seconds beyond what a trial measures, at slowdown 1

std::string quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) {
    if (c == '\'') {
      out += "'\\''";
    } else {
      out += c;
    }
  }
  return out + "'";
}

}  // namespace

std::string command_line(const std::string& program, const Trial& trial, double slowdown) {
  return fmt::format("{} --json --scheduler {} --cpus {} --seconds {} --speed {} --seed {} --slowdown {}",
                     quoted(program), quoted(trial.scheduler), fmt::join(trial.cpus, ","), trial.seconds, trial.speed,
                     trial.seed, slowdown);
}

Result<Measured> run_trial(const std::string& program, const Trial& trial, double slowdown) {
  const double limit = trial.seconds + slowdown * kPatience;
  const std::string command =
      fmt::format("exec timeout --foreground -k 5 {:.0f} {}", limit, command_line(program, trial, slowdown));
  const auto before = read_ticks();
  std::FILE* pipe = popen(command.c_str(), "re");
  if (pipe == nullptr) return Error::environment("cannot start a program", "are there too many already?");
  std::string printed;
  std::array<char, 4096> chunk{};
  while (const std::size_t length = std::fread(chunk.data(), 1, chunk.size(), pipe))
    printed.append(chunk.data(), length);
  const int status = pclose(pipe);
  if (status == -1 || !WIFEXITED(status) || WEXITSTATUS(status) != 0) {
    return Error::environment(
        fmt::format("face_tracking failed{}",
                    WIFEXITED(status) ? fmt::format(" with exit code {}", WEXITSTATUS(status)) : std::string()),
        "try it by itself: " + command_line(program, trial, slowdown));
  }
  Result<Measured> run = parse_measured(trial, printed);
  if (run) run->others = others_share(before, read_ticks());
  return run;
}

}  // namespace ctn::demo
