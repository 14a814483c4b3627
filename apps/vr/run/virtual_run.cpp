#include "run/virtual_run.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "catan/simulation.h"
#include "program/random.h"
#include "program/run_options.h"
#include "run/album.h"
#include "run/headset_app.h"
#include "run/nodes.h"

namespace ctn::vr::run {
namespace {

using std::chrono::nanoseconds;

constexpr std::uint64_t kClockDraws = 71;  // stream of random numbers

// Times of a simulation begin before the first inertial sample, by `begin`.
class VirtualHeadset final : public Headset {
 public:
  VirtualHeadset(const Simulation& simulation, const Surroundings& surroundings, nanoseconds begin,
                 const Clock& display_clock, Exposures& exposures)
      : simulation_(simulation),
        surroundings_(surroundings),
        begin_(begin),
        clock_(display_clock),
        exposures_(exposures),
        display_(display_clock) {}

  nanoseconds now() const override { return simulation_.now() - begin_; }
  std::size_t samples() const override { return surroundings_.samples_by(now()); }
  ImuSample sample(std::size_t index) const override { return surroundings_.sample(index); }
  Result<Exposure> exposure() override { return exposures_.newest(now()); }
  const Clock& display() const override { return clock_; }
  void finished(Picture picture) override {
    picture.finished = now();
    display_.finished(picture);
  }
  void tracked(Tracked tracked) override {
    tracked.at = now();
    tracked_.push_back(tracked);
  }

  Happened happened() {
    display_.advance(now());
    return {display_.photons(), tracked_, now()};
  }

 private:
  const Simulation& simulation_;
  const Surroundings& surroundings_;
  nanoseconds begin_;
  Clock clock_;
  Exposures& exposures_;
  Display display_;
  std::vector<Tracked> tracked_;
};

Clock drawn(program::Draws& draws, nanoseconds period, double drift_ppm) {
  const double phase = draws.between(0.0, 1.0);
  const double off = draws.between(-1.0, 1.0);
  const auto longer = static_cast<double>(period.count()) * off * drift_ppm * 1e-6;
  const nanoseconds drifting = period + nanoseconds(std::llround(longer));
  return {nanoseconds(static_cast<nanoseconds::rep>(phase * static_cast<double>(drifting.count()))), drifting};
}

// As seen from a time that begins at `begin`.
Clock since(const Clock& clock, nanoseconds begin) { return {clock.first - begin, clock.period}; }

// In a time in which the first inertial sample is at `first_sample`.
Clock in_time_of(const Clock& recorded, nanoseconds first_sample) {
  const Clock clock = since(recorded, -first_sample);
  return {clock.next(nanoseconds(0)), clock.period};
}

std::vector<SimulatedClock> ticking(const DrawnClocks& clocks, const Options& options) {
  std::vector<SimulatedClock> result{{"IMU", clocks.samples.first, clocks.samples.period},
                                     {"display", clocks.display.first, clocks.display.period}};
  if (has_camera_clock(options)) result.push_back({kExposure, clocks.exposures.first, clocks.exposures.period});
  return result;
}

Result<std::unique_ptr<Exposures>> exposures_of(const Options& options, const Surroundings& surroundings,
                                                const Clock& clock) {
  if (!options.dataset.empty()) return recorded_exposures(surroundings);
  return drawn_exposures(surroundings, options.camera_hz ? std::optional(clock) : std::nullopt);
}

}  // namespace

DrawnClocks clocks_of(const Options& options) {
  program::Draws draws(options.seed, kClockDraws);
  DrawnClocks clocks;
  const bool recorded = !options.dataset.empty();
  clocks.samples = drawn(draws, sample_period(options), recorded ? 0.0 : options.drift_ppm);
  clocks.display = drawn(draws, options.display_period(), options.drift_ppm);
  clocks.exposures = options.recorded ? in_time_of(*options.recorded, clocks.samples.first)
                                      : drawn(draws, camera_period(options), options.drift_ppm);
  return clocks;
}

DrawnClocks clocks_as_in_life(const Options& options) {
  DrawnClocks clocks = clocks_of(options);
  const nanoseconds period = sample_period(options);
  clocks.samples = {period, period};
  clocks.display.first += period - kSampleLead;
  if (options.recorded) {
    clocks.exposures = in_time_of(*options.recorded, clocks.samples.first);
  } else {
    clocks.exposures.first += period - kSampleLead;
  }
  return clocks;
}

Result<Outcome> run_virtually(const Options& options, const Watch& watch) {
  const auto started = std::chrono::steady_clock::now();
  const DrawnClocks clocks = options.calibration.empty() ? clocks_of(options) : clocks_as_in_life(options);
  const nanoseconds begin = clocks.samples.first;
  const auto surroundings = Surroundings::make(options, clocks.samples.period);
  if (!surroundings) return surroundings.error();
  const auto exposures = exposures_of(options, **surroundings, since(clocks.exposures, begin));
  if (!exposures) return exposures.error();
  SimulationOptions simulated = program::simulation_options(options);
  simulated.clocks = ticking(clocks, options);
  auto simulation = Simulation::open(options.app_file, simulated);
  if (!simulation) return simulation.error();
  VirtualHeadset headset(*simulation, **surroundings, begin, since(clocks.display, begin), **exposures);
  Nodes nodes(headset, **surroundings, options, std::nullopt);
  nodes.attach(*simulation);

  Outcome outcome;
  outcome.options = options;
  const nanoseconds asked(std::llround(options.seconds * 1e9));
  const nanoseconds end = std::min(asked, begin + (*surroundings)->end());
  while (simulation->now() < end && outcome.signal == 0) {
    const nanoseconds step = std::min(watch.step, end - simulation->now());
    if (Status ran = simulation->run_for(step); !ran) return ran.error();
    if (const auto failure = nodes.failure()) return *failure;
    if (watch.signal) outcome.signal = watch.signal();
    if (watch.show) watch.show(simulation->now());
  }
  if (Status finished = simulation->finish(); !finished) return finished.error();
  outcome.snapshot = simulation->snapshot();
  const Happened happened = headset.happened();
  outcome.figures = figures_of(happened, **surroundings, options.translational);
  Clocks sources{since(clocks.samples, begin), since(clocks.display, begin)};
  if (options.camera_hz) sources.exposures = since(clocks.exposures, begin);
  add_responses(outcome, sources, costs_of_tracking(happened));
  if (!options.pictures.empty() && outcome.signal == 0) {
    if (Status drawn_all = draw_album(options, **surroundings, happened.photons, watch.ends()); !drawn_all) {
      return drawn_all.error();
    }
  }
  outcome.took_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - started).count();
  return outcome;
}

}  // namespace ctn::vr::run
