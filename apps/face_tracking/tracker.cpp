#include "tracker.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "lens.h"
#include "path.h"
#include "world.h"

namespace ctn::face_tracking {
namespace {

constexpr double kTurnsPerSecond = 0.5;  // how often a face turns round
constexpr double kRateNoise = 1.0;       // rad/s per square root of a second
constexpr double kBearingSigma = 0.02;   // of a detection
constexpr double kOutlier = 1e-3;        // weight that a detection leaves to guesses far from it
constexpr double kUnseen = 0.1;          // weight of a guess inside a picture that shows no face
constexpr double kGain = 5.0;            // pan rate per angle, 1/s
constexpr double kTimeout = 0.6;         // seconds without a face before the search begins
constexpr double kSweepRate = 2.2;

}  // namespace

Tracker::Tracker(std::uint64_t seed, std::size_t particles) : random_(seed), weights_(particles) {
  for (Particles* all : {&particles_, &spare_}) {
    all->bearing.resize(particles);
    all->rate.resize(particles);
  }
}

// The sum of the eight bytes of one draw: near enough to a normal deviate, and many times cheaper.
double Tracker::normal() {
  std::uint64_t bits = random_();
  int sum = 0;
  for (int i = 0; i < 8; ++i, bits >>= 8U) sum += static_cast<int>(bits & 0xFFU);
  constexpr double kMean = 8 * 127.5;
  constexpr double kSigma = 209.0;  // sqrt(8 (256^2 - 1) / 12)
  return (sum - kMean) / kSigma;
}

void Tracker::scatter(double bearing) {
  for (std::size_t i = 0; i < count(); ++i) {
    particles_.bearing[i] = bearing + kBearingSigma * normal();
    particles_.rate[i] = 0.5 * kTurnRateMax * normal();
  }
}

void Tracker::move(double duration) {
  const double noise = kRateNoise * std::sqrt(duration);
  const double turn = 1.0 - std::exp(-kTurnsPerSecond * duration);
  const auto turn_below = static_cast<std::uint32_t>(turn * 4294967295.0);
  for (std::size_t i = 0; i < count(); ++i) {
    double& rate = particles_.rate[i];
    const auto draw = random_();
    if (static_cast<std::uint32_t>(draw) < turn_below) {
      // It turned at some moment since; until then it went on.
      const double until = duration * static_cast<double>(draw >> 32U) * 0x1.0p-32;
      particles_.bearing[i] += rate * (2.0 * until - duration);
      rate = -rate;
    } else {
      particles_.bearing[i] += rate * duration;
    }
    rate = std::clamp(rate + noise * normal(), -kTurnRateMax, kTurnRateMax);
  }
}

void Tracker::weigh(const Observation& observation) {
  for (std::size_t i = 0; i < count(); ++i) {
    const double angle = wrapped(particles_.bearing[i] - observation.pan);
    if (observation.face) {
      const double miss = wrapped(angle - *observation.face) / kBearingSigma;
      weights_[i] = std::exp(-0.5 * miss * miss) + kOutlier;
    } else {
      weights_[i] = std::abs(angle) < kHalfView ? kUnseen : 1.0;
    }
  }
}

// Systematic: one draw, equal steps through the summed weights.
void Tracker::resample() {
  double sum = 0.0;
  for (const double weight : weights_) sum += weight;
  const double step = sum / static_cast<double>(count());
  double at = step * static_cast<double>(random_() >> 11U) * 0x1.0p-53;
  double upto = weights_[0];
  std::size_t from = 0;
  for (std::size_t i = 0; i < count(); ++i, at += step) {
    while (upto < at && from + 1 < count()) upto += weights_[++from];
    spare_.bearing[i] = particles_.bearing[from];
    spare_.rate[i] = particles_.rate[from];
  }
  std::swap(particles_, spare_);
}

void Tracker::estimate() {
  double bearing = 0.0;
  double rate = 0.0;
  for (std::size_t i = 0; i < count(); ++i) {
    bearing += particles_.bearing[i];
    rate += particles_.rate[i];
  }
  bearing_ = bearing / static_cast<double>(count());
  rate_ = rate / static_cast<double>(count());
}

void Tracker::observe(const Observation& observation) {
  if (!started_ || (searching_ && observation.face)) {
    scatter(observation.pan + observation.face.value_or(0.0));
    started_ = true;
    seen_at_ = observation.time;
  } else {
    move(observation.time - time_);
    weigh(observation);
    resample();
  }
  time_ = observation.time;
  estimate();
  if (observation.face) {
    seen_at_ = observation.time;
    searching_ = false;
  }
}

double Tracker::pan_rate(double time, double pan) {
  if (!started_) return 0.0;
  if (!searching_ && time_ - seen_at_ > kTimeout) {
    searching_ = true;
    sweep_from_ = pan;
    sweep_rate_ = std::copysign(kSweepRate, rate_);
  }
  if (searching_) {
    // All round one way, then all round the other.
    constexpr double kRound = 2.0 * std::numbers::pi;
    if (std::abs(pan - sweep_from_) > kRound) {
      sweep_from_ = pan;
      sweep_rate_ = -sweep_rate_;
    }
    return sweep_rate_;
  }
  const double expected = bearing_ + rate_ * (time - time_);
  return std::clamp(rate_ + kGain * wrapped(expected - pan), -kTurnRateMax, kTurnRateMax);
}

}  // namespace ctn::face_tracking
