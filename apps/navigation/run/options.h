// The program's command line.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <variant>
#include <vector>

#include "program/calibration.h"
#include "program/leave.h"

namespace ctn::navigation::run {

struct Options {
  std::string map = "1";   // 1, 2, crowd, or a file
  std::string world_file;  // of the map; empty: a crowd, made from the run's seed
  std::string scheduler = "catan";
  std::string policy = "catan";  // of the session, which the scheduler stands for
  std::string costs;             // file with compute times, for schedulers that decide by them; empty: measured
  bool stealing = true;
  std::vector<int> cpus;  // empty: all that the process may use
  double seconds = 60.0;  // at most; it ends when the goal is reached
  std::uint64_t seed = 1;
  std::string record;  // empty: none
  std::string app_file;
  double slowdown = 1.0;
  double mover_speed = 1.0;  // what the speeds of all movers are multiplied by
  bool virtual_time = false;
  int cores = 1;                     // in virtual time
  std::string calibration_file;      // or folder, of runs in life; empty: none
  program::Calibration calibration;  // that of the file, once it is read
  std::string detector = "none";     // none, hog, yolo
  std::vector<std::string> model;    // of yolo: FILE.cfg, FILE.weights and, if given, the names of its classes
  std::string film;                  // that the camera plays; empty: Debian's
  int runs = 1;
  std::string out;       // folder of a batch's outcomes; empty: they are not kept
  std::string pictures;  // folder; empty: none
  std::string replay;    // page to write; empty: none
  bool json = false;
  bool in_common = false;  // only tells what the runs of a batch with these options have in common
  // What the files hold that a run depends on, told apart by fingerprints: "app", "world", ... (inputs.h).
  std::map<std::string, std::string> inputs;
};

// What a record of the run says of it.
std::string note_of(const Options& options);

std::variant<Options, program::Leave> parse_options(int argc, const char* const* argv);

}  // namespace ctn::navigation::run
