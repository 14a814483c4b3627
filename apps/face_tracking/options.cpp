#include "options.h"

#include <fmt/format.h>

#include <utility>

#include <CLI/CLI.hpp>

#include "program/command_line.h"

namespace ctn::face_tracking {
namespace {

using program::file_of_the_app;
using program::within;

const char* const kExamples = R"(
examples:
  face_tracking --scheduler catan --cpus 0 --seconds 10
  face_tracking --scheduler default --cpus 0,1 --speed 1.5 --json
  face_tracking --scheduler rate:11Hz --cpus 0 --record rate11.db
  face_tracking --slowdown 2      as on a board half as fast
  face_tracking --virtual --cores 1 --seed 3     simulated: the same bytes each time, on any machine; see --costs

exit codes: 0 done, 1 it could not run, 2 a mistake on the command line or in the app file,
128 + signal number when interrupted (what was measured until then is printed all the same)
)";

}  // namespace

std::variant<Options, program::Leave> parse_options(int argc, const char* const* argv) {
  Options options;
  options.app_file = file_of_the_app("face_tracking.yaml");
  options.costs = file_of_the_app("face_tracking.costs.yaml");
  std::string cpus;

  CLI::App app("A camera that turns after a face: real pictures, a real detector, a simulated world.", "face_tracking");
  app.footer(kExamples);
  app.add_option(
         "--scheduler", options.scheduler,
         "default (30 Hz source, ordinary scheduling), rate:HZ (that source rate, ordinary scheduling) or catan")
      ->capture_default_str();
  CLI::Option* const real_cpus =
      app.add_option("--cpus", cpus, "CPUs for the nodes, as 0 or 0,1 or 0-3; all that may be used where not given");
  app.add_option("--seconds", options.seconds, "how long to measure, after the warm-up")
      ->check(within(0.5, 86400.0))
      ->capture_default_str();
  app.add_option("--speed", options.speed, "mean rate of the face's bearing in rad/s (the camera turns at 3.2 at most)")
      ->check(within(0.0, 10.0))
      ->capture_default_str();
  app.add_option("--seed", options.seed,
                 "of the face's walk (and, with --virtual, of the costs): equal seeds, equal walks")
      ->capture_default_str();
  app.add_option("--record", options.record, "write a record of the run to this file (read it with catan report)");
  app.add_option("--slowdown", options.slowdown, "each run burns X-1 times its own CPU time more, as on a slower board")
      ->check(within(1.0, 100.0))
      ->capture_default_str();
  app.add_option("--faces", options.faces,
                 "a picture of the film's faces, so that many runs look for them only once: read where it is there, "
                 "else written");
  app.add_option("--app", options.app_file, "the app file")->default_str("face_tracking.yaml beside the program");
  CLI::Option* const in_virtual_time =
      app.add_flag("--virtual", options.virtual_time,
                   "simulate: real pictures and detections in virtual time, in which runs cost what --costs says")
          ->excludes(real_cpus);
  app.add_option("--costs", options.costs, "with --virtual: the cost file; --slowdown multiplies what it says")
      ->needs(in_virtual_time)
      ->default_str("face_tracking.costs.yaml beside the program");
  app.add_option("--cores", options.cores, "with --virtual: how many cores the nodes have")
      ->needs(in_virtual_time)
      ->check(CLI::Range(1, 127))
      ->capture_default_str();
  app.add_flag("--json", options.json, "print one JSON document on stdout and nothing else there");

  if (auto leave = program::parse(app, argc, argv)) return *std::move(leave);
  if (const auto mistake = program::take_cpus(cpus, options.cpus)) {
    return program::leave_over("face_tracking", *mistake);
  }
  return options;
}

std::string note_of(const Options& options) {
  return fmt::format("face_tracking speed {} rad/s, seed {}, slowdown {}{}", options.speed, options.seed,
                     options.slowdown, options.virtual_time ? ", in virtual time" : "");
}

}  // namespace ctn::face_tracking
