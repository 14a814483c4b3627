#include "figures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace ctn::case_studies {
namespace {

const Metric& metric_of(const Study& study, const std::string& name) {
  return *std::ranges::find(study.metrics, name, &Metric::name);
}

const Batch& batch_of(const Study& study, const std::string& name) {
  return *std::ranges::find(study.batches, name, &Batch::name);
}

report::Point point_of(double x, const Row& row, const std::vector<double>& values) {
  if (row.metric->method == Method::kShares) {
    const Interval interval = wilson(row.share);
    const double percent = 100.0 * static_cast<double>(row.share.count) / static_cast<double>(row.share.total);
    return {.x = x, .y = percent, .low = 100.0 * interval.low, .high = 100.0 * interval.high};
  }
  const double mean = row.spread->mean;
  double squares = 0.0;
  for (const double value : values) squares += (value - mean) * (value - mean);
  const auto count = static_cast<double>(values.size());
  const double half = count > 1.0 ? 1.96 * std::sqrt(squares / (count - 1.0) / count) : 0.0;
  return {.x = x, .y = mean, .low = mean - half, .high = mean + half};
}

}  // namespace

report::Figure by_batch(const Study& study, const Runs& runs, const std::string& metric) {
  const std::vector<Row> rows = compare(study, runs);
  const bool shares = metric_of(study, metric).method == Method::kShares;
  report::Panel panel{.title = metric, .y = {.label = shares ? "% of the runs" : "mean", .min = 0.0}};
  report::Series series{.line = report::Line::kNone, .colour = report::Colour::kOrange};
  report::Series reference{.line = report::Line::kNone, .colour = report::Colour::kBlue};
  double x = 0.0;
  for (const Batch& batch : study.batches) {
    x += 1.0;
    panel.x.ticks.push_back({x, batch.label});
    const Row& row = row_of(rows, metric, batch.name);
    if (row.runs == 0) continue;
    (batch.reference ? reference : series)
        .points.push_back(point_of(x, row, values_of(*row.metric, runs.at(batch.name))));
  }
  panel.x.min = 0.5;
  panel.x.max = x + 0.5;
  panel.series = {std::move(series), std::move(reference)};
  const bool many = study.batches.size() > 5;
  return {.title = metric, .panels = {std::move(panel)}, .width = many ? 1000 : 640, .panel_height = many ? 360 : 320};
}

report::Figure over_time(const Study& study, const Runs& runs, const Timeline& timeline) {
  report::Panel panel{
      .title = timeline.title, .x = {.label = "Time (s)", .min = 0.0}, .y = {.label = timeline.unit, .min = 0.0}};
  for (const std::string& name : timeline.batches) {
    const Batch& batch = batch_of(study, name);
    report::Series series{.label = batch.label, .marks = false, .colour = colour_of(name)};
    const ByTime medians = medians_by_time(runs.at(name), timeline.list);
    for (std::size_t stretch = 0; stretch < medians.size(); ++stretch) {
      const double middle = (static_cast<double>(stretch) + 0.5) * timeline.stretch;
      series.points.push_back({.x = middle, .y = medians[stretch].value_or(std::nan(""))});
    }
    panel.series.push_back(std::move(series));
  }
  return {.title = timeline.title, .panels = {std::move(panel)}, .width = 1000, .panel_height = 360};
}

report::Colour colour_of(const std::string& name) {
  using report::Colour;
  static constexpr std::array kColours{std::pair{"catan", Colour::kBlue},
                                       std::pair{"catan-without-stealing", Colour::kSky},
                                       std::pair{"default", Colour::kOrange},
                                       std::pair{"fast-local", Colour::kPurple},
                                       std::pair{"paper", Colour::kGreen},
                                       std::pair{"paper-without-stealing", Colour::kYellow},
                                       std::pair{"static-full-run", Colour::kOrange},
                                       std::pair{"static-20s", Colour::kPurple}};
  const std::string last = name.substr(name.rfind('/') + 1);
  const auto found = std::ranges::find_if(kColours, [&](const auto& entry) { return last == entry.first; });
  return found == kColours.end() ? Colour::kInk : found->second;
}

}  // namespace ctn::case_studies
