#include "runner.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <cstdio>
#include <cstdlib>

#include "experiments/shell.h"
#include "load.h"

namespace ctn::demo {
namespace {

using experiments::quoted;

constexpr double kLonger = 4.0;    // how much, where a trial brought nothing
constexpr double kTimeout = 60.0;  // seconds beyond what a trial measures, at slowdown 1

Result<Measured> run_once(const FaceTracking& app, const Trial& trial) {
  const double limit = trial.seconds + app.slowdown * kTimeout;
  const std::string by_hand = command_line(app, trial);
  const std::string command =
      fmt::format("exec timeout --foreground -k 5 {:.0f} {} 2>>{}", limit, by_hand, quoted(app.log));
  const auto before = read_cpu_times();
  std::FILE* pipe = popen(command.c_str(), "re");
  if (pipe == nullptr) return Error::environment("cannot start a program", "are there too many already?");
  std::string printed;
  std::array<char, 4096> chunk{};
  while (const std::size_t length = std::fread(chunk.data(), 1, chunk.size(), pipe))
    printed.append(chunk.data(), length);
  const int status = pclose(pipe);
  if (status == -1 || !WIFEXITED(status) || WEXITSTATUS(status) != 0) {
    const std::string code = WIFEXITED(status) ? fmt::format(" with exit code {}", WEXITSTATUS(status)) : "";
    return Error::environment("face_tracking failed" + code, "read " + app.log + "; try it by itself: " + by_hand);
  }
  Result<Measured> run = parse_measured(trial, printed);
  if (run) run->others = others_share(before, read_cpu_times());
  return run;
}

}  // namespace

std::string command_line(const FaceTracking& app, const Trial& trial) {
  return fmt::format("{} --json --scheduler {} --cpus {} --seconds {} --speed {} --seed {} --slowdown {} --faces {}{}",
                     quoted(app.program), quoted(trial.scheduler), fmt::join(trial.cpus, ","), trial.seconds,
                     trial.speed, trial.seed, app.slowdown, quoted(app.faces),
                     trial.record.empty() ? "" : " --record " + quoted(trial.record));
}

Result<Measured> run_trial(const FaceTracking& app, const Trial& trial) {
  const Result<Measured> run = run_once(app, trial);
  if (!run || run->response_ms > 0.0) return run;
  Trial longer = trial;
  if (!longer.record.empty()) std::remove(longer.record.c_str());
  longer.seconds *= kLonger;
  Result<Measured> again = run_once(app, longer);
  if (again && again->response_ms == 0.0) {
    return Error::environment(
        fmt::format("'{}' brought no picture to the motor in {} s", trial.scheduler, longer.seconds),
        "is the machine too busy, or the slowdown too large?");
  }
  return again;
}

}  // namespace ctn::demo
