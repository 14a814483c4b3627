#include "program/figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace ctn::program {
namespace {

double deviation_of(const std::vector<double>& values, double mean) {
  if (values.size() < 2) return 0.0;
  double squares = 0.0;
  for (const double value : values) squares += (value - mean) * (value - mean);
  return std::sqrt(squares / static_cast<double>(values.size() - 1));
}

}  // namespace

std::optional<double> figure_of(const std::vector<Figure>& figures, const std::string& name) {
  const auto found = std::ranges::find(figures, name, &Figure::name);
  return found == figures.end() ? std::nullopt : found->value;
}

std::optional<double> mean_of(const std::vector<double>& values) {
  if (values.empty()) return std::nullopt;
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

std::optional<double> percentile_of(std::vector<double> values, double percent) {
  if (values.empty()) return std::nullopt;
  const double share = std::ceil(static_cast<double>(values.size()) * percent / 100.0);
  const auto rank = std::clamp<std::size_t>(static_cast<std::size_t>(share), 1, values.size()) - 1;
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(rank);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

Spread spread_of(const std::vector<double>& values) {
  Spread spread;
  spread.count = values.size();
  if (values.empty()) return spread;
  spread.mean = *mean_of(values);
  spread.deviation = deviation_of(values, spread.mean);
  spread.min = *std::ranges::min_element(values);
  spread.lower_quartile = *percentile_of(values, 25.0);
  spread.median = *percentile_of(values, 50.0);
  spread.upper_quartile = *percentile_of(values, 75.0);
  spread.max = *std::ranges::max_element(values);
  return spread;
}

std::vector<FigureSpread> spreads_of(const std::vector<std::vector<Figure>>& runs) {
  std::vector<std::string> names;
  for (const std::vector<Figure>& run : runs) {
    for (const Figure& figure : run) {
      if (std::ranges::find(names, figure.name) == names.end()) names.push_back(figure.name);
    }
  }
  std::vector<FigureSpread> spreads;
  for (const std::string& name : names) {
    std::vector<double> values;
    for (const std::vector<Figure>& run : runs) {
      if (const auto value = figure_of(run, name)) values.push_back(*value);
    }
    spreads.push_back({name, spread_of(values)});
  }
  return spreads;
}

std::string table_of(const std::vector<FigureSpread>& spreads) {
  std::string text = fmt::format("  {:<46} {:>5} {:>10} {:>10} {:>10} {:>10} {:>10}\n", "figure", "runs", "mean",
                                 "dev.", "lower q.", "median", "upper q.");
  for (const auto& [figure, spread] : spreads) {
    if (spread.count == 0) {
      text += fmt::format("  {:<46} {:>5} {:>10}\n", figure, 0, "-");
      continue;
    }
    text += fmt::format("  {:<46} {:>5} {:>10.5g} {:>10.3g} {:>10.5g} {:>10.5g} {:>10.5g}\n", figure, spread.count,
                        spread.mean, spread.deviation, spread.lower_quartile, spread.median, spread.upper_quartile);
  }
  return text;
}

ByTime medians_by_time(const std::vector<ByTime>& runs, std::size_t min_runs) {
  ByTime medians;
  for (std::size_t stretch = 0;; ++stretch) {
    std::size_t reached = 0;
    std::vector<double> values;
    for (const ByTime& run : runs) {
      if (stretch >= run.size()) continue;
      ++reached;
      if (run[stretch]) values.push_back(*run[stretch]);
    }
    if (reached < std::max<std::size_t>(min_runs, 1)) return medians;
    medians.push_back(percentile_of(std::move(values), 50.0));
  }
}

}  // namespace ctn::program
