// Figures of runs, and what they come to in several runs: means and spread.
//
// Thread safety: values, pure functions.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace ctn::program {

// One number of a run, by name; none where there was nothing to measure.
struct Figure {
  std::string name;
  std::optional<double> value;
};
std::optional<double> figure_of(const std::vector<Figure>& figures, const std::string& name);

// Nothing where there are no values.
std::optional<double> mean_of(const std::vector<double>& values);
// The smallest value such that at least `percent` of all are no larger.
std::optional<double> percentile_of(std::vector<double> values, double percent);

// What a figure comes to in several runs. Quartiles are the smallest values such that a quarter (half, three quarters)
// of all are no larger; `deviation`: the standard deviation, of one run 0; `count`: the runs in which there was
// something to measure.
struct Spread {
  std::string figure;
  std::size_t count = 0;
  double mean = 0.0;
  double deviation = 0.0;
  double min = 0.0;
  double lower_quartile = 0.0;
  double median = 0.0;
  double upper_quartile = 0.0;
  double max = 0.0;
};
// In the order in which the figures first occur.
std::vector<Spread> spreads_of(const std::vector<std::vector<Figure>>& runs);

// Text: a table of them.
std::string table_of(const std::vector<Spread>& spreads);

}  // namespace ctn::program
