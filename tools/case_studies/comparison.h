// Batches compared with their reference: spread, direction, significance.
//
// Within a study, the probabilities of one metric are adjusted by Holm's method, since several batches are compared
// with the same reference.
//
// Thread safety: pure functions.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "program/figures.h"
#include "statistics.h"
#include "study.h"

namespace ctn::case_studies {

// By which a difference counts as one.
inline constexpr double kSignificant = 0.05;

// One metric of one batch.
struct Row {
  const Metric* metric = nullptr;
  const Batch* batch = nullptr;
  std::size_t runs = 0;
  Share share;                            // of Method::kShares
  std::optional<program::Spread> spread;  // of the others, if there are any values
  std::optional<double> probability{};    // that it differs so from the reference by chance; none: it is the reference
  int sign = 0;                           // by what was tested: 1: larger than the reference's, -1: smaller

  bool significant() const { return probability && *probability < kSignificant && sign != 0; }
  // Whether the batch is better than the reference, or worse; neither where it cannot be told.
  bool better() const { return significant() && sign == (metric->better == Better::kHigher ? 1 : -1) && judged(); }
  bool worse() const { return significant() && !better() && judged(); }

 private:
  bool judged() const { return metric->better != Better::kNeither; }
};

// By metric, then in the order of the batches.
std::vector<Row> compare(const Study& study, const Runs& runs);

// One metric of one batch beside that of another batch, whatever their groups: a test alone, so nothing is adjusted.
Row compare_two(const Metric& metric, const Batch& batch, const Batch& reference, const Runs& runs);

// The row of a metric and a batch. Precondition: there is one.
const Row& row_of(const std::vector<Row>& rows, const std::string& metric, const std::string& batch);

// The values of a metric, with those of runs that have none (Metric::missing).
std::vector<double> values_of(const Metric& metric, const std::vector<StoredRun>& runs);

// In how many stretches of time a batch's median is lower than that of all others; of those that all of them reached
// and any of them came to something in. Runs that came to nothing then count as infinite.
Share lowest_by_time(const Runs& runs, const std::string& batch, const std::vector<std::string>& others,
                     const std::string& list);

// "0.031", "< 0.001".
std::string probability_text(double probability);

}  // namespace ctn::case_studies
