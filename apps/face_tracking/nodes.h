// The app's nodes: what each does in a run, and the channels between them. The only file that knows both whoever runs
// them (a session, or a simulation) and the parts.
//
// Thread safety: construct and attach from one thread; a session then runs each node in a thread of its own.
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <optional>
#include <string>

#include <opencv2/core.hpp>

#include "catan/session.h"
#include "catan/simulation.h"
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
  // Seconds since the start of the world.
  using Clock = std::function<double()>;

  // `world` and `view` must outlive the session's threads (or the simulation), as must this object.
  Nodes(World& world, const View& view, Clock clock, Detector detector, std::uint64_t seed);

  // Gives the session all four functions. Each run burns `slowdown` - 1 times its own CPU time more.
  void attach(Session& session, double slowdown);
  // The same in virtual time, where the motor turns the camera when its run ends, and thereby samples the world until
  // then. `clock` is the simulation's.
  void attach(Simulation& simulation);

  // From any thread. Only pictures seen since the last restart count.
  void restart_sightings();
  Sightings sightings() const;

 private:
  struct Frame {
    double time = 0.0;
    Sight sight;  // of it the app uses the pan alone; the rest is the truth, for Sightings
    cv::Mat picture;
  };

  using Body = std::function<void(Run&)>;
  struct Bodies {
    Body camera;
    Body detect;
    Body plan;
    Channel<double>& rates;  // to the motor
  };

  template <class Host>
  Bodies bodies(Host& host);
  Frame take_picture(std::uint64_t number);
  Observation find_face(const Frame& frame);
  void judge(const Frame& frame, const Observation& observation);

  World& world_;
  const View& view_;
  Clock clock_;
  cv::Mat raw_;  // the camera's
  Preprocess preprocess_;
  Detector detector_;
  Tracker tracker_;
  std::optional<double> command_;  // of the motor's run, in virtual time
  std::atomic<std::uint64_t> pictures_ = 0;
  std::atomic<std::uint64_t> in_view_ = 0;
  std::atomic<std::uint64_t> found_ = 0;
  std::atomic<std::uint64_t> wrong_ = 0;
};

}  // namespace ctn::face_tracking
