// The app's nodes: what each does in a run, and the channels between them. The only file that knows both the session
// and the parts.
//
// Thread safety: construct and attach from one thread; the session then runs each node in a thread of its own.
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <string>

#include <opencv2/core.hpp>

#include "catan/session.h"
#include "detector.h"
#include "outcome.h"
#include "preprocess.h"
#include "tracker.h"
#include "view.h"
#include "world.h"

namespace ctn::face_tracking {

// Seconds on the monotonic clock since it was made.
class Stopwatch {
 public:
  double now() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

class Nodes {
 public:
  // `world`, `view` and `clock` must outlive the session's threads, as must this object.
  Nodes(World& world, const View& view, const Stopwatch& clock, Detector detector, std::uint64_t seed);

  // Gives the session all four functions. Each run burns `slowdown` - 1 times its own CPU time more.
  void attach(Session& session, double slowdown);

  // From any thread. Only pictures seen since the last restart count.
  void restart_sightings();
  Sightings sightings() const;

 private:
  struct Frame {
    double time = 0.0;
    Sight sight;  // of it the app uses the pan alone; the rest is the truth, for Sightings
    cv::Mat picture;
  };

  Frame take_picture(std::uint64_t number);
  Observation find_face(const Frame& frame);
  void judge(const Frame& frame, const Observation& observation);

  World& world_;
  const View& view_;
  const Stopwatch& clock_;
  cv::Mat raw_;  // the camera's
  Preprocess preprocess_;
  Detector detector_;
  Tracker tracker_;
  std::atomic<std::uint64_t> pictures_ = 0;
  std::atomic<std::uint64_t> in_view_ = 0;
  std::atomic<std::uint64_t> found_ = 0;
  std::atomic<std::uint64_t> wrong_ = 0;
};

}  // namespace ctn::face_tracking
