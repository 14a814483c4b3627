// The VR app: reads the command line, lets the session (or, in virtual time, the simulation) run, prints what was
// measured.

#include <fmt/format.h>

#include <chrono>
#include <cstdio>
#include <fstream>
#include <memory>
#include <sstream>
#include <utility>
#include <variant>

#include "program/terminal.h"
#include "run/batch.h"
#include "run/live_run.h"
#include "run/options.h"
#include "run/outcome.h"
#include "run/prepared.h"
#include "run/virtual_run.h"

namespace ctn::vr::run {
namespace {

using program::StatusLine;

constexpr const char* kProgram = "vr";

Result<Outcome> run_once(const Options& options, StatusLine& status) {
  Watch watch;
  watch.signal = program::signal_so_far;
  watch.show = [&status](std::chrono::nanoseconds at) { status.show(fmt::format("{:6.1f} s", in_seconds(at))); };
  watch.notice = [](const std::string& text) { program::note(kProgram, text); };
  return options.virtual_time ? run_virtually(options, watch) : run_live(options, watch);
}

// With what has to be there before, which is kept in `prepared` for later runs where it is the same for all.
Result<Outcome> run_prepared(Prepared& prepared, const Options& options, StatusLine& status) {
  const auto measure = [&](const Options& measuring) {
    status.clear();
    fmt::print(stderr, "vr: first measures what runs cost, for {:.0f} s\n", measuring.seconds);
    return run_once(measuring, status);
  };
  auto ready = prepared.for_run(options, measure);
  if (!ready) return ready.error();
  if (auto* interrupted = std::get_if<Outcome>(&*ready)) return std::move(*interrupted);
  return run_once(std::get<Options>(*ready), status);
}

int run(const Options& asked) {
  auto prepared = Prepared::make(asked);
  if (!prepared) return program::fail(kProgram, prepared.error());
  const Options& options = prepared->options();
  if (options.in_common) return program::print(common_of(options), 0);
  StatusLine status;
  if (options.runs > 1 || !options.out.empty()) {
    const auto batch = run_batch(
        options, [&](const Options& one) { return run_prepared(*prepared, one, status); },
        [&status](const std::string& line) {
          status.clear();
          fmt::print(stderr, "vr: {}\n", line);
        });
    status.clear();
    if (!batch) return program::fail(kProgram, batch.error());
    return program::print(options.json ? to_json(*batch) : to_text(*batch), batch->signal);
  }
  const auto outcome = run_prepared(*prepared, options, status);
  status.clear();
  if (!outcome) return program::fail(kProgram, outcome.error());
  if (options.virtual_time) {
    fmt::print(stderr, "vr: {:.1f} s of virtual time in {:.1f} s\n",
               program::figure_of(outcome->figures, "seconds").value_or(0.0), outcome->took_seconds);
  }
  return program::print(options.json ? to_json(*outcome) : to_text(*outcome), outcome->signal);
}

}  // namespace
}  // namespace ctn::vr::run

int main(int argc, char** argv) {
  using namespace ctn::vr::run;
  return ctn::program::run_program(parse_options(argc, argv), run);
}
