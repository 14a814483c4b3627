// The simulated world: the face that walks, and the camera that turns.
//
//   motor node --turn--> log of commands --> world thread: advance(), samples the angle every 2 ms
//                             |
//   camera node <--- sight ---+              (the face's bearing is a pure function of time)
//
// Where the camera points at any time follows exactly from the commands in the log, so that a world thread which the
// scheduler keeps waiting samples late, never wrongly. There is no lock: a node at a real-time level never waits for
// the world's ordinary thread.
//
// Units: seconds since the start of the world, radians, rad/s.
// Thread safety: one thread calls turn, one advance, begin_measuring and tracking; sight any.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <optional>

#include "path.h"

namespace ctn::face_tracking {

inline constexpr double kTurnRateMax = 3.2;
inline constexpr double kSamplePeriod = 0.002;

// Which way the camera points from `at` on: pan + rate * (time - at).
struct Pan {
  double at = 0.0;
  double pan = 0.0;
  double rate = 0.0;

  double angle(double time) const { return pan + rate * (time - at); }
};

// The commands that the motor was given. One writer, any number of readers, no waiting: a reader copies an entry and
// looks afterwards whether it was overwritten meanwhile, which takes kSize further commands.
class PanLog {
 public:
  explicit PanLog(Pan first);

  void append(const Pan& pan);
  std::uint64_t size() const { return size_.load(std::memory_order_acquire); }
  Pan latest() const;
  // Nothing where that entry was overwritten. Precondition: index < size().
  std::optional<Pan> entry(std::uint64_t index) const;

 private:
  static constexpr std::uint64_t kSize = 1024;
  struct Entry {
    std::atomic<std::uint64_t> index = 0;
    std::atomic<double> at = 0.0;
    std::atomic<double> pan = 0.0;
    std::atomic<double> rate = 0.0;
  };
  std::array<Entry, kSize> entries_;
  std::atomic<std::uint64_t> size_ = 0;
};

struct Sight {
  double bearing = 0.0;  // of the face; not wrapped
  double pan = 0.0;      // of the camera; not wrapped
  double angle = 0.0;    // from the camera's axis to the face, in [-pi, pi)
};

struct Tracking {
  std::uint64_t samples = 0;
  double angle_mean = 0.0;     // of |angle|, over time
  double lost_fraction = 0.0;  // of the time: the face's centre was outside the picture
};

class World {
 public:
  // The camera starts looking at the face. `half_view` is half the horizontal field of view.
  World(Path path, double half_view);

  // From `time` on the camera turns at `rate`, or as fast as it can. Times must not decrease.
  void turn(double time, double rate);
  // At a time not before the last command.
  Sight sight(double time) const;

  // Samples up to `time`; call it again and again.
  void advance(double time);
  // Forgets what was sampled; from `time` on it counts.
  void begin_measuring(double time);
  Tracking tracking() const;

 private:
  Sight sight(const Pan& pan, double time) const;

  Path path_;
  double half_view_;
  PanLog log_;
  // The world thread's own.
  std::uint64_t command_ = 0;  // the entry in force at the last sample
  Pan pan_;                    // and what it said
  std::uint64_t tick_ = 0;     // samples are at multiples of kSamplePeriod
  std::uint64_t samples_ = 0;
  std::uint64_t lost_ = 0;
  double angle_sum_ = 0.0;
};

}  // namespace ctn::face_tracking
