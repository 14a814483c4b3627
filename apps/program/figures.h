// Figures of runs, and what they come to in several runs: means, medians and spread.
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

// Quartiles are the smallest values such that a quarter (half, three quarters) of all are no larger; `deviation`: the
// standard deviation, of one value 0.
struct Spread {
  std::size_t count = 0;
  double mean = 0.0;
  double deviation = 0.0;
  double min = 0.0;
  double lower_quartile = 0.0;
  double median = 0.0;
  double upper_quartile = 0.0;
  double max = 0.0;
};
Spread spread_of(const std::vector<double>& values);

// What a figure comes to in the runs in which there was something to measure.
struct FigureSpread {
  std::string figure;
  Spread spread;
};
// In the order in which the figures first occur.
std::vector<FigureSpread> spreads_of(const std::vector<std::vector<Figure>>& runs);
// The same of runs that have `figures`.
template <class Run>
std::vector<FigureSpread> spreads_of(const std::vector<Run>& runs) {
  std::vector<std::vector<Figure>> figures;
  for (const Run& run : runs) figures.push_back(run.figures);
  return spreads_of(figures);
}

// Text: a table of them.
std::string table_of(const std::vector<FigureSpread>& spreads);

// A number for each stretch of a run's time, from its begin on; none where there was nothing to measure.
using ByTime = std::vector<std::optional<double>>;
// Of several runs: for each stretch the median of those that had something to measure then. It ends before the first
// stretch that fewer than `min_runs` reached.
ByTime medians_by_time(const std::vector<ByTime>& runs, std::size_t min_runs = 1);

}  // namespace ctn::program
