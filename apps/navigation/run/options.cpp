#include "run/options.h"

#include <fmt/format.h>

#include <optional>
#include <utility>

#include <CLI/CLI.hpp>

#include "program/command_line.h"
#include "program/known_costs.h"

namespace ctn::navigation::run {
namespace {

using program::file_of_the_app;
using program::within;

const char* const kExamples = R"(
examples:
  navigation --virtual --cores 1 --seed 3             simulated: the same bytes each time, on any machine
  navigation --virtual --scheduler default --runs 20 --out runs/default
                                                      seeds 1 to 20; run again, it goes on where it stopped
  navigation --map 2 --seconds 300 --cpus 0           explores an office floor, in real time
  navigation --map my_world.yaml --pictures out       a picture a second
  navigation --virtual --replay drive.html            an animation, to be opened in a browser

exit codes: 0 done (collisions included), 1 it could not run, 2 a mistake on the command line or in a file,
128 + signal number when interrupted (what was measured until then is printed all the same)
)";

std::string world_file_of(const std::string& map) {
  if (map == "crowd") return "";
  return map == "1" || map == "2" ? file_of_the_app("map" + map + ".yaml") : map;
}

std::string app_of(const Options& options) {
  if (options.detector != "none") return "robot_with_detector.yaml";
  return options.scheduler == "fast-local" ? "robot_fast_local.yaml" : "robot.yaml";
}

std::optional<std::string> mistake_about_detector(const Options& options) {
  const bool network = options.detector == "yolo";
  if (network && options.model.empty()) {
    return "--detector yolo needs a network: add --model FILE.cfg FILE.weights, of the YOLO family in Darknet's format "
           "(docs/navigation-detector.md), or use --detector hog, which needs none";
  }
  if (!network && !options.model.empty()) return "--model is of --detector yolo: add that, or leave out --model";
  if (options.detector == "none") {
    if (!options.film.empty()) return "--film is what a detector sees: add --detector hog, or leave out --film";
    return std::nullopt;
  }
  if (options.scheduler == "fast-local" && options.app_file.empty()) {
    return "fast-local has no app file with a detector: give one with --app, or use another --scheduler";
  }
  return std::nullopt;
}

void add_options(CLI::App& app, Options& options, std::string& cpus) {
  app.add_option("--map", options.map,
                 "the world: 1 (two rooms, to a goal), 2 (an office floor, to be explored), crowd (another one for "
                 "each seed), or a file (docs/navigation-worlds.md)")
      ->capture_default_str();
  app.add_option(
         "--scheduler", options.scheduler,
         "catan; paper (the paper's Catan); default (rates set by hand); fast-local (as default, but LM and LP at 50 "
         "Hz); static-full-run, static-20s (a plan made once, of a whole run's compute times or of its first 20 s; on "
         "several cores its rates under ordinary scheduling); davare, verucchi, picas (by compute times); or another "
         "policy of a session")
      ->capture_default_str();
  CLI::Option* const real_cpus = app.add_option(
      "--cpus", cpus, "CPUs for the nodes, as 0 or 0,1 or 0-3; else all, though the world needs one, too");
  app.add_option(
         "--costs", options.costs,
         "a cost file or a record, for schedulers that decide once by compute times; else they are measured by a "
         "run of its own before each run")
      ->type_name("FILE");
  app.add_flag("!--no-stealing", options.stealing, "no subchain goes on in the slot of another that does not need it");
  app.add_option("--seconds", options.seconds, "how long a run lasts at most: it ends when the goal is reached")
      ->check(within(0.5, 86400.0))
      ->capture_default_str();
  app.add_option("--seed", options.seed, "of noise, drift and what moves: equal seeds, equal worlds")
      ->capture_default_str();
  CLI::Option* const record =
      app.add_option("--record", options.record, "write a record of the run to this file (read it with catan report)");
  app.add_option("--slowdown", options.slowdown, "each run costs X times as much, as on a slower board")
      ->check(within(1.0, 100.0))
      ->capture_default_str();
  app.add_option("--mover-speed", options.mover_speed, "what moves in the world moves X times as fast")
      ->check(within(0.01, 100.0))
      ->capture_default_str();
  app.add_option("--app", options.app_file, "the app file")
      ->default_str("robot.yaml beside the program, robot_fast_local.yaml or robot_with_detector.yaml");
  CLI::Option* const in_virtual_time =
      app.add_flag("--virtual", options.virtual_time,
                   "simulate: the real code in virtual time, in which runs cost what their work was worth")
          ->excludes(real_cpus);
  app.add_option("--cores", options.cores, "with --virtual: how many cores the nodes have")
      ->needs(in_virtual_time)
      ->check(CLI::Range(1, 127))
      ->capture_default_str();
  program::add_calibration(app, options.calibration_file, in_virtual_time);
  app.add_option(
         "--detector", options.detector,
         "what looks at the camera's pictures beside navigation: none, hog (people, by OpenCV alone) or yolo (a "
         "network of yours, with --model)")
      ->check(CLI::IsMember({"none", "hog", "yolo"}))
      ->capture_default_str();
  app.add_option(
         "--model", options.model,
         "with --detector yolo: the network's FILE.cfg and FILE.weights, and a file with the names of its classes "
         "if you like")
      ->type_name("FILE")
      ->expected(2, 3);
  app.add_option("--film", options.film,
                 "with a detector: what the camera sees, over and over; else Debian's vtest.avi")
      ->type_name("FILE");
  CLI::Option* const runs = app.add_option("--runs", options.runs, "how many runs, with seeds from --seed on")
                                ->check(CLI::Range(1, 100000))
                                ->excludes(record)
                                ->capture_default_str();
  app.add_option("--out", options.out, "keep each run's outcome in this folder, and go on with what is there")
      ->needs(runs);
  app.add_option("--pictures", options.pictures, "draw a picture a second into this folder")->excludes(runs);
  app.add_option("--replay", options.replay, "write the drive as an animation into this page, which any browser shows")
      ->type_name("FILE.html")
      ->excludes(runs);
  app.add_flag("--json", options.json, "print one JSON document on stdout and nothing else there");
  app.add_flag(
      "--in-common", options.in_common,
      "print, as JSON, what runs of one batch (--out) with these options must have in common, and run nothing");
}

}  // namespace

std::variant<Options, program::Leave> parse_options(int argc, const char* const* argv) {
  Options options;
  std::string cpus;
  CLI::App app("A robot that finds its way: real mapping, localisation and planning in a simulated world.",
               "navigation");
  app.footer(kExamples);
  add_options(app, options, cpus);
  if (auto leave = program::parse(app, argc, argv)) return *std::move(leave);
  auto mistake = program::take_cpus(cpus, options.cpus);
  if (!mistake) mistake = mistake_about_detector(options);
  if (!mistake) mistake = program::mistake_about_costs(options, "davare, verucchi or picas");
  if (mistake) return program::leave_over("navigation", *mistake);
  options.world_file = world_file_of(options.map);
  options.policy = options.scheduler == "fast-local" ? "default" : options.scheduler;
  if (options.app_file.empty()) options.app_file = file_of_the_app(app_of(options));
  return options;
}

std::string note_of(const Options& options) {
  return fmt::format("navigation map {}, seed {}, slowdown {}{}", options.map, options.seed, options.slowdown,
                     options.virtual_time ? ", in virtual time" : "");
}

}  // namespace ctn::navigation::run
