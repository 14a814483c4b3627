// The program's command line.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "program/calibration.h"
#include "program/leave.h"
#include "run/clock.h"

namespace ctn::vr::run {

// Camera and VIO cost so many times what they do here: as much as the paper's, which take 3.5 and 19.3 ms.
inline constexpr double kPaperTracking = 7.0;

struct Options {
  std::string scheduler = "catan";
  std::string policy = "catan";  // of the session, which the scheduler stands for
  std::string costs;             // file with compute times, for schedulers that decide by them; empty: measured
  bool stealing = true;
  std::vector<int> cpus;  // empty: all that the process may use
  bool virtual_time = false;
  int cores = 1;    // in virtual time
  int width = 320;  // of what the wearer sees
  int height = 240;
  double hz = 120.0;                // the display's
  std::optional<double> camera_hz;  // none: the camera takes a picture when it is triggered
  bool translational = false;       // Timewarp moves what is in the picture, too
  double seconds = 30.0;
  std::uint64_t seed = 1;
  double drift_ppm = 0.0;  // clocks are up to so much fast or slow
  double slowdown = 1.0;
  double tracking_slowdown = kPaperTracking;
  std::string calibration_file;      // or folder, of runs in life; empty: none
  program::Calibration calibration;  // that of the file, once it is read
  std::string dataset;               // folder; empty: the simulated headset
  std::optional<Clock> recorded;     // that its pictures keep to, since the first inertial sample, once they are read
  std::optional<std::chrono::nanoseconds> recorded_samples;  // period of its inertial samples, likewise
  std::string record;                                        // empty: none
  std::string app_file;                                      // empty: made for these options
  std::string pictures;                                      // folder; empty: none
  int runs = 1;
  std::string out;  // folder of a batch's outcomes; empty: they are not kept
  bool json = false;
  bool in_common = false;  // only tells what the runs of a batch with these options have in common
  // What the files hold that a run depends on, told apart by fingerprints: "app", "costs", "dataset".
  std::map<std::string, std::string> inputs;

  std::chrono::nanoseconds display_period() const;
};

// What a record of the run says of it.
std::string note_of(const Options& options);

std::variant<Options, program::Leave> parse_options(int argc, const char* const* argv);

}  // namespace ctn::vr::run
