// From the trials to what they say: medians over the rounds, and whether each claim held. Pure.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "results.h"

namespace ctn::demo {

// Over the rounds.
struct Spread {
  double median = 0.0;
  double min = 0.0;
  double max = 0.0;
};
Spread spread_of(std::vector<double> values);  // precondition: not empty

// All rounds of one configuration.
struct Row {
  std::size_t cores = 1;
  std::string scheduler;
  double speed = 0.0;
  std::size_t rounds = 0;
  Spread source_hz;
  Spread response_ms;
  Spread response_p95_ms;
  std::optional<Spread> predicted_ms;
  Spread angle_deg;
  Spread lost_fraction;
};

// One claim for one number of cores (and one speed), with the numbers that decide it.
struct Claim {
  std::size_t cores = 1;
  std::string text;      // what is claimed
  std::string measured;  // the numbers
  bool held = false;
};

struct Summary {
  std::vector<Row> rows;  // by cores, speed, then default, catan, rates ascending
  std::vector<Claim> claims;
};

Summary summarise(const Results& results);

const Row* find_row(const Summary& summary, std::size_t cores, const std::string& scheduler, double speed);

// Median over the trials of what others used of the machine; more than kDisturbed, and ordinary scheduling suffered.
double median_others(const Results& results);
inline constexpr double kDisturbed = 0.1;

// Median compute times over all trials under Catan, or over all where there is none.
Compute median_compute(const Results& results);

}  // namespace ctn::demo
