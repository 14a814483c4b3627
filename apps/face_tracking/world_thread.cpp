#include "world_thread.h"

#include <algorithm>
#include <chrono>

namespace ctn::face_tracking {
namespace {

constexpr auto kPeriod = std::chrono::milliseconds(10);
// The world is sampled this far behind the clock: a motor that read its clock may be pre-empted before its command is
// in the log.
constexpr double kBehind = 0.1;

}  // namespace

WorldThread::WorldThread(World& world, const Stopwatch& clock)
    : world_(world), clock_(clock), thread_([this](const std::stop_token& stop) { run(stop); }) {}

WorldThread::~WorldThread() { stop(); }

void WorldThread::begin_measuring() { measure_from_.store(clock_.now()); }

Tracking WorldThread::tracking() const { return {samples_.load(), angle_mean_.load(), lost_fraction_.load()}; }

void WorldThread::stop() {
  if (!thread_.joinable()) return;
  thread_.request_stop();
  thread_.join();
}

void WorldThread::run(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    std::this_thread::sleep_for(kPeriod);
    const double until = clock_.now() - kBehind;
    double from = measure_from_.load();
    if (from >= 0.0 && from <= until) {
      world_.begin_measuring(from);
      measure_from_.compare_exchange_strong(from, -1.0);
    }
    world_.advance(until);
    publish();
  }
  world_.advance(clock_.now());
  publish();
}

void WorldThread::publish() {
  const Tracking tracking = world_.tracking();
  samples_.store(tracking.samples);
  angle_mean_.store(tracking.angle_mean);
  lost_fraction_.store(tracking.lost_fraction);
}

}  // namespace ctn::face_tracking
