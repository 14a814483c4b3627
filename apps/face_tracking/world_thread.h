// Lets the world's time pass: an ordinary thread that samples what the camera and the face did. It is no node, costs
// next to nothing, and may be late (world.h).
#pragma once

#include <atomic>
#include <thread>

#include "nodes.h"
#include "world.h"

namespace ctn::face_tracking {

class WorldThread {
 public:
  WorldThread(World& world, const Stopwatch& clock);
  ~WorldThread();

  // From any thread.
  void begin_measuring();
  Tracking tracking() const;
  // Samples up to now, then ends the thread. May be called twice.
  void stop();

 private:
  void run(const std::stop_token& stop);
  void publish();

  World& world_;
  const Stopwatch& clock_;
  std::atomic<double> measure_from_ = -1.0;  // below 0: no such wish
  std::atomic<double> angle_mean_ = 0.0;
  std::atomic<double> lost_fraction_ = 0.0;
  std::atomic<std::uint64_t> samples_ = 0;
  std::jthread thread_;  // last: it uses the others
};

}  // namespace ctn::face_tracking
