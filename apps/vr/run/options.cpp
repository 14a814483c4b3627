#include "run/options.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <optional>
#include <utility>

#include <CLI/CLI.hpp>

#include "program/command_line.h"
#include "program/known_costs.h"

namespace ctn::vr::run {
namespace {

using program::within;

const char* const kExamples = R"(
examples:
  vr --virtual --cores 1 --seed 3                     simulated: the same bytes each time
  vr --virtual --scheduler fifo --runs 20 --out runs/fifo
                                                      seeds 1 to 20; run again, it goes on where it stopped
  vr --virtual --camera 20 --hz 90 --drift 100        a camera with a rate of its own, clocks that drift
  vr --cpus 0 --seconds 20 --size 320x240             in real time: what is drawn is drawn by that CPU
  vr --virtual --seconds 10 --pictures out            what the wearer sees beside what is true, each second

exit codes: 0 done, 1 it could not run, 2 a mistake on the command line or in a file, 128 + signal number when
interrupted (what was measured until then is printed all the same)
)";

// What the command line says in words of its own.
struct Words {
  std::string cpus;
  std::string size = "320x240";
  std::string camera = "triggered";
  std::string warp = "rotational";
};

void add_options(CLI::App& app, Options& options, Words& words) {
  app.add_option(
         "--scheduler", options.scheduler,
         "catan; paper (the paper's Catan); default (rates set by hand, ordinary scheduling); fifo (IMU and Int, "
         "then Timewarp, Render, Camera and VIO); pacer (as compositors do it: Timewarp and Render start just in "
         "time for the display); static-full-run, static-20s, davare, verucchi, picas, deadline (by compute "
         "times); or another policy of a session")
      ->capture_default_str();
  CLI::Option* const real_cpus = app.add_option(
      "--cpus", words.cpus, "CPUs for the nodes, as 0 or 0,1 or 0-3; else all, though the display needs one, too");
  app.add_option("--costs", options.costs,
                 "a cost file or a record, for schedulers that decide once by compute times; else they are measured by "
                 "a run of its own before each run")
      ->type_name("FILE");
  app.add_flag("!--no-stealing", options.stealing, "no subchain goes on in the slot of another that does not need it");
  CLI::Option* const in_virtual_time =
      app.add_flag("--virtual", options.virtual_time,
                   "simulate: the real code in virtual time, in which runs cost what their work was worth")
          ->excludes(real_cpus);
  app.add_option("--cores", options.cores, "with --virtual: how many cores the nodes have")
      ->needs(in_virtual_time)
      ->check(CLI::Range(1, 127))
      ->capture_default_str();
  program::add_calibration(app, options.calibration_file, in_virtual_time);
  app.add_option("--size", words.size, "of the pictures that the wearer sees, in pixels")
      ->type_name("WxH")
      ->capture_default_str();
  app.add_option("--hz", options.hz, "the display's rate, from 30 to 500")
      ->check(within(30.0, 500.0))
      ->capture_default_str();
  app.add_option("--camera", words.camera,
                 "triggered (it takes a picture when the scheduler says so), or a rate from 1 to 60 Hz that is its own")
      ->capture_default_str();
  app.add_option("--warp", words.warp, "what Timewarp corrects: rotational, or translational (also the position)")
      ->check(CLI::IsMember({"rotational", "translational"}))
      ->capture_default_str();
  app.add_option("--seconds", options.seconds,
                 "how long it runs, or as long as the data set has data; the first 4 s are not counted")
      ->check(within(1.0, 3600.0))
      ->capture_default_str();
  app.add_option("--seed", options.seed, "of how the head moves, noise, the room, and when clocks tick")
      ->capture_default_str();
  app.add_option("--drift", options.drift_ppm,
                 "the clocks of display and inertial unit are up to so many millionths fast or slow (in real time, the "
                 "display's)")
      ->check(within(0.0, 1000.0))
      ->capture_default_str();
  app.add_option("--slowdown", options.slowdown, "each run costs X times as much, as on a slower board")
      ->check(within(1.0, 100.0))
      ->capture_default_str();
  app.add_option("--tracking-slowdown", options.tracking_slowdown,
                 "Camera and VIO cost X times as much beyond that: 7 makes them as heavy as the paper's")
      ->check(within(1.0, 100.0))
      ->capture_default_str();
  app.add_option("--dataset", options.dataset, "a data set in EuRoC's format in place of the simulated headset")
      ->type_name("DIR");
  CLI::Option* const record =
      app.add_option("--record", options.record, "write a record of the run to this file (read it with catan report)");
  app.add_option("--app", options.app_file, "the app file; else one is made for these options, as headset.yaml");
  CLI::Option* const runs = app.add_option("--runs", options.runs, "how many runs, with seeds from --seed on")
                                ->check(CLI::Range(1, 100000))
                                ->excludes(record)
                                ->capture_default_str();
  app.add_option("--out", options.out, "keep each run's outcome in this folder, and go on with what is there")
      ->needs(runs);
  app.add_option("--pictures", options.pictures,
                 "each second, what the wearer sees beside what is true, into this folder")
      ->excludes(runs);
  app.add_flag("--json", options.json, "print one JSON document on stdout and nothing else there");
  app.add_flag(
      "--in-common", options.in_common,
      "print, as JSON, what runs of one batch (--out) with these options must have in common, and run nothing");
}

std::optional<std::pair<int, int>> parse_size(const std::string& text) {
  int width = 0;
  int height = 0;
  int read = 0;
  if (std::sscanf(text.c_str(), "%4dx%4d%n", &width, &height, &read) != 2) return std::nullopt;
  if (static_cast<std::size_t>(read) != text.size()) return std::nullopt;
  constexpr int kMinSide = 16;
  constexpr int kMaxSide = 2048;
  if (width < kMinSide || height < kMinSide || width > kMaxSide || height > kMaxSide) return std::nullopt;
  return std::pair(width, height);
}

std::optional<std::string> take(const Words& words, Options& options) {
  if (auto mistake = program::take_cpus(words.cpus, options.cpus)) return mistake;
  const auto size = parse_size(words.size);
  if (!size) return "--size: '" + words.size + "' is no size; write 320x240, each side from 16 to 2048";
  std::tie(options.width, options.height) = *size;
  if (words.camera != "triggered") {
    double rate = 0.0;
    if (!CLI::detail::lexical_cast(words.camera, rate) || !(rate >= 1.0 && rate <= 60.0)) {
      return "--camera: '" + words.camera + "' is neither triggered nor a rate from 1 to 60; write 20";
    }
    options.camera_hz = rate;
  }
  options.translational = words.warp == "translational";
  return std::nullopt;
}

std::optional<std::string> contradiction_in(const Options& options) {
  if (auto mistake = program::mistake_about_costs(options, "davare, verucchi, picas or deadline")) return mistake;
  if (!options.dataset.empty() && options.camera_hz) {
    return "--camera: the pictures of a data set come at its own rate; leave out --camera or --dataset";
  }
  return std::nullopt;
}

}  // namespace

std::chrono::nanoseconds Options::display_period() const { return std::chrono::nanoseconds(std::llround(1e9 / hz)); }

std::variant<Options, program::Leave> parse_options(int argc, const char* const* argv) {
  Options options;
  Words words;
  CLI::App app("A headset: where the head is, what it sees, and how late and how wrong that is.", "vr");
  app.footer(kExamples);
  add_options(app, options, words);
  if (auto leave = program::parse(app, argc, argv)) return *std::move(leave);
  auto mistake = take(words, options);
  if (!mistake) mistake = contradiction_in(options);
  if (mistake) return program::leave_over("vr", *mistake);
  options.policy = options.scheduler == "pacer" ? "fifo" : options.scheduler;
  return options;
}

std::string note_of(const Options& options) {
  return fmt::format("vr {}x{} at {} Hz, camera {}, seed {}, slowdown {}, tracking {}{}", options.width, options.height,
                     options.hz, options.camera_hz ? fmt::format("{} Hz", *options.camera_hz) : "triggered",
                     options.seed, options.slowdown, options.tracking_slowdown,
                     options.virtual_time ? ", in virtual time" : "");
}

}  // namespace ctn::vr::run
