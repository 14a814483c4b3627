// The app's nodes: what each does in a run, and the channels between them. The only file that knows both whoever runs
// them (a session, or a simulation) and the algorithms.
//
//   IMU        reads the inertial samples that are new
//   Int        the newest state, by all samples since VIO's
//   Camera     a picture, without the lens's distortion, as a pyramid; no picture twice
//   VIO        the state at the picture's time
//   Render     the room, from where the eye will be when the frame is shown
//   Timewarp   the frame, turned to where the eye will be at the next tick
//   pace_...   where a pacer is to wake Timewarp and Render (pacer.h): gives an output when it is time
//
// Who predicts where the eye will be has to know when its picture is shown. Timewarp takes that to be the first tick
// after it will have ended, if it takes as long as it lately did; Render, as long after its begin as it lately was.
//
// Values never change once they are written. In a virtual run each run charges what its work was worth, and nothing is
// drawn.
//
// Thread safety: construct and attach from one thread; a session then runs each node in a thread of its own.
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "catan/session.h"
#include "catan/simulation.h"
#include "drawing/frame.h"
#include "program/calibration.h"
#include "run/drawing_parts.h"
#include "run/headset.h"
#include "run/options.h"
#include "run/pacer.h"
#include "run/surroundings.h"
#include "vio/camera_frame.h"
#include "vio/integrator.h"
#include "vio/vio.h"

namespace ctn::vr::run {

class Nodes {
 public:
  // `headset` and `surroundings` must outlive the session's threads (or the simulation), as must this object.
  // `drawing`: none in virtual time.
  Nodes(Headset& headset, const Surroundings& surroundings, const Options& options,
        std::optional<DrawingParts> drawing);

  // Gives the session all functions. Each run burns as much CPU time more as the options' slowdowns say. `meter`: of
  // what runs cost; must outlive the session's threads.
  void attach(Session& session, program::CostMeter& meter);
  // The same in virtual time, where what a run shows is shown when the run ends.
  void attach(Simulation& simulation);

  // What went wrong first in a node; none: nothing did.
  std::optional<Error> failure() const;

 private:
  // What Int gives, and what that goes back to.
  struct Moving {
    MovingState state;
    std::chrono::nanoseconds stamp{};
    std::optional<std::chrono::nanoseconds> exposure;
  };
  struct Filtered {
    State state;
    std::chrono::nanoseconds exposure{};
  };
  struct Rendered {
    std::uint64_t number = 0;
    std::chrono::nanoseconds begun{};
    Pose pose;
    std::chrono::nanoseconds stamp{};
    std::optional<std::chrono::nanoseconds> exposure;
    std::shared_ptr<const drawing::Frame> frame;  // null: nothing is drawn
  };
  struct Grabbed {
    std::chrono::nanoseconds exposure{};
    CameraFrame frame;
    std::chrono::nanoseconds cost{};  // of the run
  };
  using Body = std::function<void(Run&)>;
  struct Functions {
    const char* node;
    Body body;
    Body effect;  // when the run ends; may be none
  };
  // What was told by another node's thread and not looked at yet.
  class Spare {
   public:
    void tell(std::chrono::nanoseconds spare) { value_.store(spare.count(), std::memory_order_relaxed); }
    std::optional<std::chrono::nanoseconds> take();

   private:
    static constexpr std::chrono::nanoseconds::rep kNothing = std::chrono::nanoseconds::min().count();
    std::atomic<std::chrono::nanoseconds::rep> value_{kNothing};
  };

  template <class Host>
  std::vector<Functions> functions(Host& host);
  template <class Host>
  void add_sensors(Host& host, std::vector<Functions>& functions);
  template <class Host>
  void add_tracking(Host& host, std::vector<Functions>& functions);
  template <class Host>
  void add_pictures(Host& host, std::vector<Functions>& functions);
  template <class Host>
  void add_pacers(Host& host, std::vector<Functions>& functions);

  Rendered render(Run& run, const Moving& moving);
  // Whether the frame is a new one.
  bool warp(Run& run, const Moving& moving, const Rendered& rendered);
  // A frame that no other node uses any more.
  std::shared_ptr<drawing::Frame> free_frame();
  Pose eye_at(const Moving& moving, std::chrono::nanoseconds at) const;
  double slowdown_of(const char* node) const;
  // CPU time that a run takes which is about to end, with what the options' slowdowns add. `begin`: the thread's CPU
  // time at its begin; `charged`: what it takes in virtual time.
  std::chrono::nanoseconds cost_of_run(const char* node, std::chrono::nanoseconds begin,
                                       std::chrono::nanoseconds charged) const;
  void fail(const Error& error);

  Headset& headset_;
  const Surroundings& surroundings_;
  const Options& options_;
  std::optional<DrawingParts> drawing_;

  std::vector<ImuSample> samples_;  // in full; each is written before its number is handed on
  std::size_t read_ = 0;            // IMU's, as the rest are each their node's own
  Integrator integrator_;
  std::size_t integrated_ = 0;
  std::optional<std::chrono::nanoseconds> based_on_;  // VIO's state
  Camera camera_;
  std::chrono::nanoseconds grabbed_{-1};
  Vio vio_;
  std::size_t filtered_ = 0;
  std::chrono::nanoseconds tracked_exposure_{-1};
  std::optional<Tracked> tracked_;
  std::uint64_t rendered_ = 0;
  std::vector<std::shared_ptr<drawing::Frame>> frames_;
  std::optional<Picture> picture_;
  std::uint64_t warped_frame_ = 0;
  std::chrono::nanoseconds warp_begun_{};
  std::optional<std::chrono::nanoseconds> fresh_frame_begun_;
  std::chrono::nanoseconds warp_takes_ = std::chrono::milliseconds(1);

  std::atomic<std::chrono::nanoseconds::rep> shown_after_;  // how long after Render's begin its frames are shown
  std::atomic<std::chrono::nanoseconds::rep> render_ended_{0};
  // Of the pacers.
  Pacer timewarp_pacer_;
  Pacer render_pacer_;
  std::atomic<std::chrono::nanoseconds::rep> paced_tick_{0};  // that Timewarp was woken for
  Spare timewarp_spare_;
  Spare render_spare_;

  mutable std::mutex failed_mutex_;
  std::optional<Error> failed_;
};

}  // namespace ctn::vr::run
