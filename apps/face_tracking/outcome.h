// What one run of the program measured, and how it is printed.
#pragma once

#include <cstdint>
#include <string>

#include "catan/snapshot.h"
#include "options.h"
#include "world.h"

namespace ctn::face_tracking {

// How the detector did on the pictures since the warm-up; the world knows the truth.
struct Sightings {
  std::uint64_t pictures = 0;
  std::uint64_t in_view = 0;  // the face was wholly in the picture
  std::uint64_t found = 0;    // of those in view: it was found where it was
  std::uint64_t wrong = 0;    // something else was taken for the face
};

struct Outcome {
  Options options;
  Snapshot snapshot;
  Tracking tracking;
  Sightings sightings;
  double seconds = 0.0;          // measured
  double virtual_seconds = 0.0;  // that passed in virtual time, the warm-up included; 0: it ran in real time
  double took_seconds = 0.0;     // that they took in real time
  int signal = 0;                // that ended it early; 0: none
};

std::string to_json(const Outcome& outcome);
std::string to_text(const Outcome& outcome);

// One line for a terminal while it runs.
std::string status_line(double seconds, const Snapshot& snapshot, const Tracking& tracking);

}  // namespace ctn::face_tracking
