#include "experiment.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

namespace ctn::demo {
namespace {

constexpr int kRounds = 3;
constexpr int kSweepRounds = 2;      // hand-set rates are in so many of them
constexpr double kMeasureMin = 2.0;  // seconds of a trial, at slowdown 1

std::vector<Trial> one_round(const Setting& setting, const Compute& compute, int round) {
  std::vector<Trial> trials;
  const auto add = [&](const std::vector<int>& cpus, const std::string& scheduler, double speed) {
    trials.push_back({round, cpus, scheduler, speed, setting.seed + static_cast<std::uint64_t>(round) - 1, 0.0});
  };
  for (const std::vector<int>& cpus : setting.cpu_sets) {
    add(cpus, "default", setting.medium_speed);
    add(cpus, "catan", setting.medium_speed);
    const std::vector<double> rates =
        round <= kSweepRounds ? sweep_rates(compute, cpus.size(), setting.quick) : std::vector<double>();
    for (const double rate : rates) add(cpus, rate_scheduler(rate), setting.medium_speed);
    if (setting.quick) continue;
    add(cpus, "default", setting.high_speed);
    add(cpus, "catan", setting.high_speed);
  }
  return trials;
}

bool of_the_sweep(const Trial& trial) { return trial.scheduler.starts_with("rate:"); }

// A hand-set rate's response time shows in a few seconds, and in two rounds; how well a face that turns round at random
// moments is kept in view takes many turns.
void share_time(const Setting& setting, std::vector<Trial>& trials) {
  const double min = kMeasureMin * setting.slowdown;  // a slower board takes longer for as many pictures
  const auto sweep = static_cast<double>(std::count_if(trials.begin(), trials.end(), of_the_sweep));
  const double others = static_cast<double>(trials.size()) - sweep;
  const double left = setting.budget - setting.overhead * (sweep + others) - min * sweep;
  const double measured = std::clamp(left / std::max(1.0, others), min, 5.0 * min);
  for (Trial& trial : trials) {
    trial.seconds = setting.quick ? setting.slowdown : of_the_sweep(trial) ? min : std::floor(measured * 10.0) / 10.0;
  }
}

}  // namespace

double Compute::slowest() const { return std::max({camera, detect, plan}); }

std::vector<double> sweep_rates(const Compute& compute, std::size_t cores, bool quick) {
  const double bottleneck = std::max(compute.sum() / static_cast<double>(cores), compute.slowest());
  const double keeps_up = 1000.0 / bottleneck;
  std::vector<double> rates;
  for (const double factor : {0.5, 0.75, 0.95, 1.25}) {
    if (quick && factor != 0.95) continue;
    const double rate = std::round(factor * keeps_up * 10.0) / 10.0;
    if (rate < kDefaultRate) rates.push_back(rate);
  }
  return rates;
}

std::string rate_scheduler(double hertz) { return fmt::format("rate:{:.1f}Hz", hertz); }

std::vector<Trial> make_trials(const Setting& setting, const Compute& compute) {
  const auto in_a_round = static_cast<double>(one_round(setting, compute, 1).size());
  int rounds = setting.quick ? 1 : kRounds;
  while (rounds > 1 && in_a_round * rounds * (setting.overhead + kMeasureMin * setting.slowdown) > setting.budget)
    --rounds;

  std::vector<Trial> trials;
  for (int round = 1; round <= rounds; ++round) {
    std::vector<Trial> next = one_round(setting, compute, round);
    const auto shift = static_cast<std::ptrdiff_t>(next.size()) * (round - 1) / rounds;
    std::rotate(next.begin(), next.begin() + shift, next.end());
    std::copy(next.begin(), next.end(), std::back_inserter(trials));
  }
  share_time(setting, trials);
  return trials;
}

}  // namespace ctn::demo
