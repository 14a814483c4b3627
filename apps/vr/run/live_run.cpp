#include "run/live_run.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>
#include <utility>
#include <vector>

#include "catan/session.h"
#include "program/run_options.h"
#include "run/album.h"
#include "run/headset_app.h"
#include "run/live_headset.h"
#include "run/nodes.h"

namespace ctn::vr::run {
namespace {

using std::chrono::nanoseconds;

constexpr std::chrono::seconds kMayBeginLate(10);

}  // namespace

Result<Outcome> run_live(const Options& options, const Watch& watch) {
  const DrawnClocks clocks = clocks_of(options);
  // Runs of IMU, by the session's timer: each takes a sample that is there already.
  const Clock samples{kSampleLead, sample_period(options)};
  const auto surroundings = Surroundings::make(options, samples.period);
  if (!surroundings) return surroundings.error();
  const nanoseconds asked(std::llround(options.seconds * 1e9));
  const nanoseconds end = std::min(asked, (*surroundings)->end());
  const Clock ready =
      options.camera_hz ? clocks.exposures : Clock{nanoseconds(0), nanoseconds(std::llround(1e9 / kReadyHz))};
  const auto exposures = ready_exposures(**surroundings, ready, end, watch.ends());
  if (!exposures) return exposures.error();
  Outcome outcome;
  outcome.options = options;
  if (watch.signal) outcome.signal = watch.signal();
  if (outcome.signal != 0) return outcome;
  auto drawing = DrawingParts::open(**surroundings, options);
  if (!drawing) return drawing.error();

  auto session = Session::open(options.app_file, program::session_options(options, watch.notice));
  if (!session) return session.error();
  std::vector<nanoseconds> exposed_at;
  if (has_camera_clock(options)) exposed_at = exposure_times(**surroundings, ready, end);
  LiveHeadset headset(**surroundings, clocks.display, std::move(exposed_at), **exposures);
  Nodes nodes(headset, **surroundings, options, std::move(drawing).value());
  program::CostMeter meter(options.slowdown, counted_from(end));
  nodes.attach(*session, meter);

  headset.start([&session](const char* node, std::chrono::steady_clock::time_point tick) {
    static_cast<void>(session->tick(node, tick));  // an app file without this clock has none
  });
  if (Status started = session->start(); !started) return started.error();
  const auto at_last = std::chrono::steady_clock::now() + end + kMayBeginLate;
  while (headset.now() < end && outcome.signal == 0 && std::chrono::steady_clock::now() < at_last) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    if (nodes.failure()) break;
    if (watch.signal) outcome.signal = watch.signal();
    if (watch.show) watch.show(headset.now());
  }
  outcome.snapshot = session->snapshot();
  // Before the nodes, whose end would be counted as ticks that they missed.
  headset.stop();
  Status stopped = session->stop();
  if (!stopped) return stopped.error();
  if (const auto failure = nodes.failure()) return *failure;
  outcome.cost_ratios = meter.ratios();
  const Happened happened = headset.happened();
  outcome.figures = figures_of(happened, **surroundings, options.translational);
  add_responses(outcome, {samples, clocks.display, options.camera_hz ? std::optional(ready) : std::nullopt},
                costs_of_tracking(happened));
  outcome.display_thread = headset.use();
  outcome.took_seconds = in_seconds(headset.now());
  if (!options.pictures.empty() && outcome.signal == 0) {
    if (Status drawn = draw_album(options, **surroundings, happened.photons, watch.ends()); !drawn)
      return drawn.error();
  }
  return outcome;
}

}  // namespace ctn::vr::run
