// The navigation app: reads the command line, lets the session (or, in virtual time, the simulation) run, prints what
// was measured.

#include <fmt/format.h>

#include <chrono>
#include <cstdio>
#include <memory>
#include <optional>
#include <utility>

#include "program/terminal.h"
#include "run/batch.h"
#include "run/detector_chain.h"
#include "run/inputs.h"
#include "run/live_run.h"
#include "run/options.h"
#include "run/outcome.h"
#include "run/scheme.h"
#include "run/virtual_run.h"
#include "world/crowd.h"
#include "world/world_file.h"

namespace ctn::navigation::run {
namespace {

using program::StatusLine;

constexpr const char* kProgram = "navigation";

Result<world::WorldFile> world_of(const Options& options) {
  auto world = options.world_file.empty() ? Result<world::WorldFile>(world::make_crowd({.seed = options.seed}))
                                          : world::read_world(options.world_file);
  if (!world) return world;
  for (world::MoverSpec& mover : world->movers) mover.speed *= options.mover_speed;
  return world;
}

Result<Outcome> drive_once(const Options& options, const std::shared_ptr<DetectorChain>& detector, StatusLine& status) {
  auto world = world_of(options);
  if (!world) return world.error();
  const auto show = [&status](const Progress& progress) { status.show(status_line(progress)); };
  if (options.virtual_time) {
    return run_virtually(options, *world, detector, {.signal = program::signal_so_far, .show = show});
  }
  const auto notice = [](const std::string& text) { program::note(kProgram, text); };
  return run_live(options, *world, detector, {program::signal_so_far, show, notice});
}

Result<Outcome> run_once(const Options& options, const std::shared_ptr<DetectorChain>& detector, StatusLine& status) {
  const auto scheme = Scheme::prepare(options, [&](const Options& measuring) {
    status.clear();
    fmt::print(stderr, "navigation: first measures what runs cost, for {:.0f} s at most\n", measuring.seconds);
    return drive_once(measuring, detector, status);
  });
  if (!scheme) return scheme.error();
  if (scheme->interrupted()) return *scheme->interrupted();
  return drive_once(scheme->options(), detector, status);
}

int run_single(const Options& options, const std::shared_ptr<DetectorChain>& detector) {
  StatusLine status;
  const auto outcome = run_once(options, detector, status);
  status.clear();
  if (!outcome) return program::fail(kProgram, outcome.error());
  if (options.virtual_time) {
    const double lasted = std::chrono::duration<double>(outcome->findings.lasted).count();
    fmt::print(stderr, "navigation: {:.1f} s of virtual time in {:.1f} s, {:.2g} times as fast as real time\n", lasted,
               outcome->took_seconds, lasted / outcome->took_seconds);
  }
  return program::print(options.json ? to_json(*outcome) : to_text(*outcome), outcome->signal);
}

int run_many(const Options& options, const std::shared_ptr<DetectorChain>& detector) {
  StatusLine status;
  // What follows from given compute times is the same for all runs, and made for the first.
  std::optional<Scheme> shared;
  const auto run_next = [&](const Options& one) -> Result<Outcome> {
    if (options.costs.empty()) return run_once(one, detector, status);
    if (!shared) {
      auto scheme = Scheme::prepare(one, {});
      if (!scheme) return scheme.error();
      shared = std::move(scheme).value();
    }
    Options meant = one;
    meant.policy = shared->options().policy;
    return drive_once(meant, detector, status);
  };
  const auto batch = run_batch(options, run_next, [&status](const std::string& line) {
    status.clear();
    fmt::print(stderr, "navigation: {}\n", line);
  });
  if (!batch) return program::fail(kProgram, batch.error());
  return program::print(options.json ? to_json(*batch) : to_text(*batch), batch->signal);
}

int run(Options options) {
  auto detector = DetectorChain::open(options);
  if (!detector) return program::fail(kProgram, detector.error());
  if (const Status read = program::read_calibration(options); !read) return program::fail(kProgram, read.error());
  options.inputs = inputs_of(options, detector->get());
  if (options.in_common) return program::print(common_of(options), 0);
  return options.runs > 1 || !options.out.empty() ? run_many(options, *detector) : run_single(options, *detector);
}

}  // namespace
}  // namespace ctn::navigation::run

int main(int argc, char** argv) {
  using namespace ctn::navigation::run;
  return ctn::program::run_program(parse_options(argc, argv), run);
}
