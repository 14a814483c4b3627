// The demonstration's experiments: which trials, in which order, for how long. Pure.
//
// A trial is one run of the face_tracking program. For one core, and for two where there are two, it runs the default
// scheduler, Catan and a sweep of hand-set source rates at a medium speed of the face, and default and Catan once more
// at a high speed. Trials are interleaved: a round has each of them once, so that what the machine does meanwhile hits
// all alike; each round starts at another place. All trials of a round give the face the same walk.
//
// Units: milliseconds, seconds, Hz, rad/s.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace ctn::demo {

inline constexpr double kDefaultRate = 30.0;  // Hz, the app file's fallback_rate

struct Trial {
  int round = 1;
  std::vector<int> cpus;
  std::string scheduler;  // as face_tracking takes it
  double speed = 0.0;
  std::uint64_t seed = 1;
  double seconds = 0.0;  // measured
  std::string record{};  // the file to record it in; empty: none
};

struct Compute {
  double camera = 0.0;
  double detect = 0.0;
  double plan = 0.0;

  double sum() const { return camera + detect + plan; }
  double slowest() const;
};

struct Setting {
  std::vector<std::vector<int>> cpu_sets;  // e.g. {{1}, {0, 1}}
  double medium_speed = 1.0;
  double high_speed = 1.5;
  double slowdown = 1.0;
  std::uint64_t seed = 1;
  double budget = 170.0;  // seconds for all trials together
  double overhead = 1.2;  // of a trial, in seconds: loading pictures, warming up, stopping
  bool quick = false;     // one short round, one rate, medium speed alone
};

// Source rates to try by hand with so many cores, ascending, all below the default's: around the rate that the cores
// can just keep up with, which the sum of the nodes' compute times sets for one core, the slowest node for more.
std::vector<double> sweep_rates(const Compute& compute, std::size_t cores, bool quick);

std::string rate_scheduler(double hertz);

// Fewer rounds than usual where the budget would leave too little to measure in each.
std::vector<Trial> make_trials(const Setting& setting, const Compute& compute);

}  // namespace ctn::demo
