#include "run/world_thread.h"

#include <algorithm>
#include <utility>

#include "program/slowed.h"

namespace ctn::navigation::run {
namespace {

using std::chrono::nanoseconds;
using std::chrono::steady_clock;

constexpr nanoseconds kLead = std::chrono::milliseconds(1);  // of a reading, before the node `laser` looks
constexpr nanoseconds kProgressPeriod = std::chrono::milliseconds(500);

template <class T>
void take_all(program::Events<T>& events, std::vector<T>& due) {
  while (auto event = events.take()) due.push_back(std::move(*event));
}

// The time of the first; none: later than any.
template <class T>
nanoseconds first_of(const std::vector<T>& due) {
  return due.empty() ? nanoseconds::max() : due.front().at;
}

template <class T, class Do>
void do_first(std::vector<T>& due, Do&& act) {
  act(due.front());
  due.erase(due.begin());
}

}  // namespace

WorldThread::WorldThread(Drive& drive) : drive_(drive) {}

WorldThread::~WorldThread() { stop(); }

void WorldThread::start() {
  publish(nanoseconds(0));
  thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
}

void WorldThread::stop() {
  if (!thread_.joinable()) return;
  thread_.request_stop();
  thread_.join();
}

nanoseconds WorldThread::now() const {
  const nanoseconds begin = begin_.load();
  return begin == kNotBegun ? nanoseconds(0) : steady_clock::now().time_since_epoch() - begin;
}

std::shared_ptr<const Reading> WorldThread::laser() {
  if (begin_.load() == kNotBegun) begin_.store(steady_clock::now().time_since_epoch() - kLead);
  return readings_.read();
}

Odometry WorldThread::odometry() { return odometry_.read(); }

void WorldThread::move(Motion motion) {
  motion.at = now();
  motions_.write(std::move(motion));
}

void WorldThread::guided(Guidance guidance) {
  guidance.at = now();
  guidances_.write(guidance);
}

void WorldThread::planned(Planned planned) {
  planned.at = now();
  plans_.write(std::move(planned));
}

void WorldThread::detected(Detected detected) {
  detected.at = now();
  detections_.write(detected);
}

void WorldThread::run(const std::stop_token& stop) {
  while (begin_.load() == kNotBegun && !stop.stop_requested()) std::this_thread::sleep_for(kLead);
  const steady_clock::time_point begin(begin_.load());
  nanoseconds instant{};
  nanoseconds late{};
  while (!stop.stop_requested()) {
    instant += world::kSensorPeriod;
    std::this_thread::sleep_until(begin + instant);
    take_events();
    pass(instant);
    publish(instant);
    late = std::max(late, now() - instant);
    if (keeps_moments_ && instant % kPicturePeriod == nanoseconds(0)) moments_.write(moment_of(drive_));
    if (keeps_frames_ && instant % kFramePeriod == nanoseconds(0)) frames_.write(frame_of(drive_));
    if (instant % kProgressPeriod == nanoseconds(0)) progress_.write(drive_.progress());
  }
  take_events();
  pass(now());
  if (begin_.load() == kNotBegun) return;
  use_.cpu_share = std::chrono::duration<double>(program::thread_cpu_time()) / std::chrono::duration<double>(now());
  use_.lost = motions_.lost() + guidances_.lost() + plans_.lost() + detections_.lost();
  use_.late_ms_max = std::chrono::duration<double, std::milli>(late).count();
}

void WorldThread::take_events() {
  take_all(motions_, due_motions_);
  take_all(guidances_, due_guidances_);
  take_all(plans_, due_plans_);
  take_all(detections_, due_detections_);
}

void WorldThread::pass(nanoseconds until) {
  while (true) {
    const nanoseconds motion = first_of(due_motions_);
    const nanoseconds guidance = first_of(due_guidances_);
    const nanoseconds plan = first_of(due_plans_);
    const nanoseconds detection = first_of(due_detections_);
    const nanoseconds first_at = std::min({motion, guidance, plan, detection});
    if (first_at > until) break;
    if (motion == first_at) {
      do_first(due_motions_, [this](const Motion& first) { drive_.move(first); });
    } else if (guidance == first_at) {
      do_first(due_guidances_, [this](const Guidance& first) { drive_.guided(first); });
    } else if (plan == first_at) {
      do_first(due_plans_, [this](const Planned& first) { drive_.planned(first); });
    } else {
      do_first(due_detections_, [this](const Detected& first) { drive_.detected(first); });
    }
  }
  drive_.advance(until);
}

void WorldThread::publish(nanoseconds instant) {
  auto reading = drive_.laser(instant);
  odometry_.write(reading->odometry);
  readings_.write(std::move(reading));
}

}  // namespace ctn::navigation::run
