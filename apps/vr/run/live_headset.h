// The headset in real time: a thread that is the display. At each tick of its clock it tells the session so, and takes
// what the nodes finished since. Exposures of a camera that has a clock it tells at the tick after each.
//
//   Timewarp, VIO --what they did, with its time--> [events] --> display's thread: shows, keeps
//
// It stands for hardware, which does not wait for the scheduler: but it is an ordinary thread, so nodes should not be
// given all CPUs. That changes little: what is shown at a tick follows from times, not from when the thread looks.
// What it takes of a CPU and how late it was is told (use()). Time begins when the node IMU looks for the first time,
// so that a sample is there a moment before it looks each time after, as if the sample had woken its driver.
//
// Thread safety: as Headset says; start(), stop() and the rest from one thread.
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <thread>
#include <vector>

#include "program/exchange.h"
#include "run/display.h"
#include "run/findings.h"
#include "run/headset.h"
#include "run/outcome.h"
#include "run/surroundings.h"

namespace ctn::vr::run {

class LiveHeadset final : public Headset {
 public:
  // Of which node's clock it is a tick. Called by the display's thread.
  using Tell = std::function<void(const char* node, std::chrono::steady_clock::time_point tick)>;

  // In time since the first inertial sample: the display's clock, and when the camera's own ticks (in order; none: it
  // has no clock). The rest must outlive this.
  LiveHeadset(const Surroundings& surroundings, const Clock& display, std::vector<std::chrono::nanoseconds> exposed_at,
              Exposures& exposures);
  ~LiveHeadset() override;

  void start(Tell tell);
  // The display has shown its last picture; what nodes do from then on does not count. May be called twice.
  void stop();
  // After stop().
  Happened happened() const { return {display_.photons(), tracked_, ended_}; }
  program::ThreadUse use() const { return use_; }

  std::chrono::nanoseconds now() const override;
  std::size_t samples() const override;
  ImuSample sample(std::size_t index) const override { return surroundings_.sample(index); }
  Result<Exposure> exposure() override { return exposures_.newest(now()); }
  const Clock& display() const override { return clock_; }
  void finished(Picture picture) override;
  void tracked(Tracked tracked) override;

 private:
  void run(const std::stop_token& stop, const Tell& tell);
  void take_events();

  const Surroundings& surroundings_;
  Clock clock_;
  std::vector<std::chrono::nanoseconds> exposed_at_;
  Exposures& exposures_;
  static constexpr std::chrono::nanoseconds kNotBegun{-1};
  mutable std::atomic<std::chrono::nanoseconds> begin_ = kNotBegun;  // of time, on the steady clock
  program::Events<Picture> pictures_;
  program::Events<Tracked> states_;
  // The thread's own.
  Display display_;
  std::vector<Tracked> tracked_;
  program::ThreadUse use_;
  std::chrono::nanoseconds ended_{};
  std::jthread thread_;  // last: it uses the others
};

}  // namespace ctn::vr::run
