#include "run/live_headset.h"

#include <algorithm>
#include <utility>

#include "program/slowed.h"
#include "run/headset_app.h"

namespace ctn::vr::run {
namespace {

using std::chrono::nanoseconds;
using std::chrono::steady_clock;

constexpr nanoseconds kLook = std::chrono::microseconds(200);  // whether time has begun

}  // namespace

LiveHeadset::LiveHeadset(const Surroundings& surroundings, const Clock& display, std::vector<nanoseconds> exposed_at,
                         Exposures& exposures)
    : surroundings_(surroundings),
      clock_(display),
      exposed_at_(std::move(exposed_at)),
      exposures_(exposures),
      display_(display) {}

LiveHeadset::~LiveHeadset() { stop(); }

void LiveHeadset::start(Tell tell) {
  thread_ = std::jthread([this, tell = std::move(tell)](const std::stop_token& stop) { run(stop, tell); });
}

void LiveHeadset::stop() {
  if (!thread_.joinable()) return;
  thread_.request_stop();
  thread_.join();
}

nanoseconds LiveHeadset::now() const {
  const nanoseconds begin = begin_.load();
  return begin == kNotBegun ? nanoseconds(0) : steady_clock::now().time_since_epoch() - begin;
}

std::size_t LiveHeadset::samples() const {
  if (begin_.load() == kNotBegun) begin_.store(steady_clock::now().time_since_epoch() - kSampleLead);
  return surroundings_.samples_by(now());
}

void LiveHeadset::finished(Picture picture) {
  picture.finished = now();
  pictures_.write(picture);
}

void LiveHeadset::tracked(Tracked tracked) {
  tracked.at = now();
  states_.write(tracked);
}

void LiveHeadset::run(const std::stop_token& stop, const Tell& tell) {
  while (begin_.load() == kNotBegun && !stop.stop_requested()) std::this_thread::sleep_for(kLook);
  const steady_clock::time_point begin(begin_.load());
  nanoseconds late{};
  auto exposed = exposed_at_.begin();
  for (nanoseconds tick = clock_.next(nanoseconds(0)); !stop.stop_requested(); tick += clock_.period) {
    std::this_thread::sleep_until(begin + tick);
    tell(kDisplayNode, begin + tick);
    for (; exposed != exposed_at_.end() && *exposed <= tick; ++exposed) tell(kExposure, begin + *exposed);
    take_events();
    display_.advance(tick);
    late = std::max(late, now() - tick);
  }
  take_events();
  if (begin_.load() == kNotBegun) return;
  ended_ = now();
  use_.cpu_share = in_seconds(program::thread_cpu_time()) / in_seconds(ended_);
  use_.lost = pictures_.lost() + states_.lost();
  use_.late_ms_max = in_ms(late);
}

void LiveHeadset::take_events() {
  while (const auto picture = pictures_.take()) display_.finished(*picture);
  while (const auto state = states_.take()) tracked_.push_back(*state);
}

}  // namespace ctn::vr::run
