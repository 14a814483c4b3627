#include "comparison.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

namespace ctn::case_studies {
namespace {

const std::vector<StoredRun>& runs_of(const Runs& runs, const std::string& batch) {
  static const std::vector<StoredRun> kNone;
  const auto found = runs.find(batch);
  return found == runs.end() ? kNone : found->second;
}

std::optional<double> value_of(const Metric& metric, const StoredRun& run) {
  const auto value = metric.value(run);
  return value ? value : metric.missing;
}

Share share_of(const std::vector<double>& values) {
  return {static_cast<std::size_t>(std::ranges::count_if(values, [](double value) { return value != 0.0; })),
          values.size()};
}

int sign_of(double difference) { return difference > 0.0 ? 1 : difference < 0.0 ? -1 : 0; }

// Of runs of equal seeds, where both have a value.
std::vector<double> differences_of(const Metric& metric, const std::vector<StoredRun>& ours,
                                   const std::vector<StoredRun>& theirs) {
  std::vector<double> differences;
  for (const StoredRun& run : ours) {
    const auto other = std::ranges::find(theirs, run.seed, &StoredRun::seed);
    if (other == theirs.end()) continue;
    const auto value = value_of(metric, run);
    const auto reference = value_of(metric, *other);
    if (value && reference) differences.push_back(*value - *reference);
  }
  return differences;
}

// How far more pairs of values are ordered one way than the other.
int sign_of_ranks(const std::vector<double>& a, const std::vector<double>& b) {
  long balance = 0;
  for (const double one : a) {
    for (const double other : b) balance += one > other ? 1 : one < other ? -1 : 0;
  }
  return sign_of(static_cast<double>(balance));
}

void test(Row& row, const std::vector<StoredRun>& ours, const std::vector<StoredRun>& reference) {
  const std::vector<double> values = values_of(*row.metric, ours);
  const std::vector<double> others = values_of(*row.metric, reference);
  if (values.empty() || others.empty()) return;
  switch (row.metric->method) {
    case Method::kShares: {
      const Share theirs = share_of(others);
      row.probability = fisher_exact(row.share, theirs);
      row.sign = sign_of(static_cast<double>(row.share.count * theirs.total) -
                         static_cast<double>(theirs.count * row.share.total));
      return;
    }
    case Method::kRanks:
      row.probability = mann_whitney(values, others);
      row.sign = sign_of_ranks(values, others);
      return;
    case Method::kPairs: {
      const std::vector<double> differences = differences_of(*row.metric, ours, reference);
      row.probability = signed_rank(differences);
      row.sign = sign_of_signed_ranks(differences);
      return;
    }
  }
}

// Not compared with anything.
Row row_alone(const Metric& metric, const Batch& batch, const std::vector<StoredRun>& runs) {
  std::vector<double> values = values_of(metric, runs);
  Row row{.metric = &metric, .batch = &batch, .runs = values.size(), .share = {}, .spread = {}};
  if (metric.method == Method::kShares) {
    row.share = share_of(values);
  } else if (!values.empty()) {
    std::ranges::sort(values);  // means are the same to the last digit, whatever the order of the runs
    row.spread = program::spread_of(values);
  }
  return row;
}

}  // namespace

bool is_complete_enough(const Study& study, const Runs& runs) {
  return std::ranges::all_of(study.batches, [&](const Batch& batch) { return runs_of(runs, batch.name).size() >= 2; });
}

std::vector<double> values_of(const Metric& metric, const std::vector<StoredRun>& runs) {
  std::vector<double> values;
  for (const StoredRun& run : runs) {
    if (const auto value = value_of(metric, run)) values.push_back(*value);
  }
  return values;
}

std::vector<Row> compare(const Study& study, const Runs& runs) {
  std::vector<Row> rows;
  for (const Metric& metric : study.metrics) {
    const std::size_t first = rows.size();
    std::vector<std::size_t> tested;
    std::vector<double> probabilities;
    for (const Batch& batch : study.batches) {
      const std::vector<StoredRun>& ours = runs_of(runs, batch.name);
      Row row = row_alone(metric, batch, ours);
      const auto reference = std::ranges::find_if(
          study.batches, [&](const Batch& other) { return other.reference && other.group == batch.group; });
      if (!batch.reference && reference != study.batches.end()) test(row, ours, runs_of(runs, reference->name));
      if (row.probability) {
        tested.push_back(rows.size() - first);
        probabilities.push_back(*row.probability);
      }
      rows.push_back(std::move(row));
    }
    const std::vector<double> adjusted = holm(probabilities);
    for (std::size_t i = 0; i < tested.size(); ++i) rows[first + tested[i]].probability = adjusted[i];
  }
  return rows;
}

Row compare_two(const Metric& metric, const Batch& batch, const Batch& reference, const Runs& runs) {
  const std::vector<StoredRun>& ours = runs_of(runs, batch.name);
  Row row = row_alone(metric, batch, ours);
  test(row, ours, runs_of(runs, reference.name));
  return row;
}

const Row& row_of(const std::vector<Row>& rows, const std::string& metric, const std::string& batch) {
  const auto found = std::ranges::find_if(
      rows, [&](const Row& row) { return row.metric->name == metric && row.batch->name == batch; });
  assert(found != rows.end());
  return *found;
}

Share lowest_by_time(const Runs& runs, const std::string& batch, const std::vector<std::string>& others,
                     const std::string& list) {
  const ByTime ours = medians_with_never(runs_of(runs, batch), list);
  std::vector<ByTime> theirs;
  std::size_t reached = ours.size();
  for (const std::string& other : others) {
    theirs.push_back(medians_with_never(runs_of(runs, other), list));
    reached = std::min(reached, theirs.back().size());
  }
  Share share;
  for (std::size_t stretch = 0; stretch < reached; ++stretch) {
    const double our = *ours[stretch];
    const auto compared = [&](const ByTime& medians) { return our < *medians[stretch]; };
    const auto has_one = [&](const ByTime& medians) { return !std::isinf(*medians[stretch]); };
    // Such as before plans are made for the first time.
    if (std::isinf(our) && std::ranges::none_of(theirs, has_one)) continue;
    ++share.total;
    if (std::ranges::all_of(theirs, compared)) ++share.count;
  }
  return share;
}

std::string probability_text(double probability) {
  return probability < 0.001 ? "< 0.001" : fmt::format("{:.{}f}", probability, probability < 0.1 ? 3 : 2);
}

}  // namespace ctn::case_studies
