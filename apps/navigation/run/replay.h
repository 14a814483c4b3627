// The drive as an animation: one page, which needs nothing else, with the world, the robot, what moves, what the robot
// knows (local map, map of everything, path, where it is about to drive) and when its detector gave an output.
//
// Ten frames a second are kept, the local map in each second one, the map of everything no more often than kMaxMaps
// times; lengths are in centimetres. A minute comes to about half a megabyte.
//
// Units: as drive.h. Thread safety: one thread.
#pragma once

#include <chrono>
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "catan/result.h"
#include "run/drive.h"
#include "run/outcome.h"
#include "world/mover.h"
#include "world/world_file.h"

namespace ctn::navigation::run {

inline constexpr std::chrono::nanoseconds kFramePeriod = std::chrono::milliseconds(100);

// An instant of a drive.
struct Frame {
  std::chrono::nanoseconds at{};
  Pose robot;         // where it is
  Motion motion;      // LP's newest
  Pose scanned_from;  // where it was when the scan was taken with which its local map ends
  Planned plan;       // GP's newest
};
// At the instant that the drive has come to.
Frame frame_of(Drive& drive);

class Replay {
 public:
  static constexpr std::size_t kMaxMaps = 60;

  // `seconds`: how long the run may last.
  Replay(world::WorldFile file, std::vector<world::Mover> movers, double seconds);

  // In the order of their times.
  void add(const Frame& frame);

  // Errors (kEnvironment): it cannot be written.
  Status write(const Outcome& outcome, const std::string& path) const;
  // The page's data, JSON.
  std::string data(const Outcome& outcome) const;

 private:
  void add_local_map(const Frame& frame);
  void add_plan(const Frame& frame);

  world::WorldFile file_;
  std::vector<world::Mover> movers_;
  std::chrono::nanoseconds map_every_;
  std::vector<double> times_;   // of frames, seconds
  std::vector<int> poses_;      // x, y in cm, heading in mrad, of each frame
  std::vector<int> motions_;    // mm/s, mrad/s, of each frame
  std::vector<int> positions_;  // of each frame, then of each mover: x, y in cm
  std::string local_maps_;      // JSON, elements of a list
  std::string maps_;            // likewise
  std::string paths_;           // likewise
  std::size_t frames_ = 0;
  SharedMap newest_map_;  // that were added
  std::shared_ptr<const Path> newest_path_;
  std::shared_ptr<const LocalMap> newest_local_;
  std::chrono::nanoseconds last_map_{-1};
};

}  // namespace ctn::navigation::run
