// The robot in real time: a thread that lets the world's time pass, and gives the laser's and the wheels' data to the
// nodes when they exist, every 20 ms.
//
//   LP, NC, GP, detect --what they did, with its time--> [events] --> world's thread: advance, observe
//   scan, odometry <--the newest reading--------------------- every 20 ms
//
// It stands for hardware, which does not wait for the scheduler. But it is an ordinary thread, whose readings come late
// where nodes keep all CPUs busy, so nodes should not be given all of them. What it takes of a CPU and how late its
// readings came is told (use()). Time begins when the node `laser` looks for the first time, so that a scan is there a
// moment before it looks each time after, as if the laser had woken its driver. A reading that comes late has the stamp
// of its instant all the same. A command that comes after the world has passed its time counts from then on.
//
// Thread safety: as Hardware says; start(), stop() and the rest from one thread.
#pragma once

#include <atomic>
#include <chrono>
#include <memory>
#include <optional>
#include <thread>
#include <vector>

#include "program/exchange.h"
#include "run/album.h"
#include "run/drive.h"
#include "run/hardware.h"
#include "run/outcome.h"
#include "run/replay.h"

namespace ctn::navigation::run {

class WorldThread final : public Hardware {
 public:
  // `drive` must outlive this; it is used by the thread alone between start() and stop().
  explicit WorldThread(Drive& drive);
  ~WorldThread() override;

  // Before start(): a moment a second will be kept for take_moment(), from one thread.
  void keep_moments() { keeps_moments_ = true; }
  std::optional<Moment> take_moment() { return moments_.take(); }

  // The same for frames of a replay.
  void keep_frames() { keeps_frames_ = true; }
  std::optional<Frame> take_frame() { return frames_.take(); }

  // Time stays at 0 until laser() is called.
  void start();
  // After the nodes have ended: takes what they did last, and lets time pass until now. May be called twice.
  void stop();
  // Of what the thread did since start(). After stop().
  program::ThreadUse use() const { return use_; }
  // The newest, while it runs.
  Progress progress() { return progress_.read(); }

  std::chrono::nanoseconds now() const override;
  std::shared_ptr<const Reading> laser() override;
  Odometry odometry() override;
  void move(Motion motion) override;
  void guided(Guidance guidance) override;
  void planned(Planned planned) override;
  void detected(Detected detected) override;

 private:
  void run(const std::stop_token& stop);
  void take_events();
  // Does what was to be done by then, in the order of time.
  void pass(std::chrono::nanoseconds until);
  void publish(std::chrono::nanoseconds instant);

  Drive& drive_;
  static constexpr std::chrono::nanoseconds kNotBegun{-1};
  std::atomic<std::chrono::nanoseconds> begin_ = kNotBegun;  // of time, on the steady clock
  program::Newest<std::shared_ptr<const Reading>> readings_;
  program::Newest<Odometry> odometry_;
  program::Newest<Progress> progress_;
  program::Events<Motion> motions_;
  program::Events<Guidance> guidances_;
  program::Events<Planned> plans_;
  program::Events<Detected> detections_;
  program::Events<Moment> moments_;
  program::Events<Frame> frames_;
  bool keeps_moments_ = false;
  bool keeps_frames_ = false;
  // The thread's own: events that were taken and are not done yet.
  std::vector<Motion> due_motions_;
  std::vector<Guidance> due_guidances_;
  std::vector<Planned> due_plans_;
  std::vector<Detected> due_detections_;
  program::ThreadUse use_;
  std::jthread thread_;  // last: it uses the others
};

}  // namespace ctn::navigation::run
