// The program's command line.
#pragma once

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "program/leave.h"

namespace ctn::face_tracking {

struct Options {
  std::string scheduler = "catan";
  std::vector<int> cpus;  // empty: all that the process may use
  double seconds = 20.0;  // measured, after the warm-up
  double speed = 1.0;     // rad/s
  std::uint64_t seed = 1;
  std::string record;  // empty: none
  std::string app_file;
  std::string faces;  // a picture of the film's, which saves looking for them; empty: none
  double slowdown = 1.0;
  bool virtual_time = false;
  std::string costs;  // in virtual time: what runs cost
  int cores = 1;      // in virtual time
  bool json = false;
};

// What a record of the run says of it.
std::string note_of(const Options& options);

std::variant<Options, program::Leave> parse_options(int argc, const char* const* argv);

}  // namespace ctn::face_tracking
