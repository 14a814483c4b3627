#include "claims.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "program/figures.h"

namespace ctn::case_studies {
namespace {

// "mean 11.23 beside 12.11 (-7.3 %)"
std::string means_of(const Row& ours, const Row& theirs) {
  if (!ours.spread || !theirs.spread) return "nothing";
  const double mean = ours.spread->mean;
  const double other = theirs.spread->mean;
  const std::string percent = other > 0.0 ? fmt::format(" ({:+.1f} %)", 100.0 * (mean / other - 1.0)) : "";
  return fmt::format("mean {:.{}f} beside {:.{}f}{}", mean, ours.metric->digits, other, ours.metric->digits, percent);
}

}  // namespace

std::string text_of(Share share) { return fmt::format("{} of {}", share.count, share.total); }

std::string text_of(const Row& row) {
  if (row.metric->method == Method::kShares) return text_of(row.share);
  if (!row.spread) return "nothing";
  const double median = row.spread->median;
  return median == kNever ? "never" : fmt::format("{:.{}f}", median, row.metric->digits);
}

double percent_of(Share share) {
  return share.total == 0 ? 0.0 : 100.0 * static_cast<double>(share.count) / static_cast<double>(share.total);
}

double median_of(const Row& row) { return row.spread ? row.spread->median : kNever; }

double mean_of(const Row& row) { return row.spread ? row.spread->mean : kNever; }

Verdict verdict_of(bool held) { return held ? Verdict::kHeld : Verdict::kFailed; }

Claim worse_than_reference(std::string text, const std::vector<Row>& rows, const std::string& name,
                           const std::string& batch, const std::string& reference) {
  const Row& row = row_of(rows, name, batch);
  const bool better = row.sign == (row.metric->better == Better::kHigher ? 1 : -1);
  return {.text = std::move(text),
          .measured = fmt::format("{} beside {}", text_of(row_of(rows, name, reference)), text_of(row)),
          .probability = row.probability,
          .verdict = row.worse() ? Verdict::kHeld
                     : better    ? Verdict::kFailed
                                 : Verdict::kNotShown};
}

Claim no_better_than_reference(std::string text, const std::vector<Row>& rows, const std::string& name,
                               const std::string& batch, const std::string& reference) {
  const double theirs = median_of(row_of(rows, name, batch));
  const double ours = median_of(row_of(rows, name, reference));
  Claim claim = worse_than_reference(std::move(text), rows, name, batch, reference);
  claim.verdict = ours == kNever && theirs == kNever ? Verdict::kNotShown : verdict_of(ours <= theirs);
  return claim;
}

Claim lower_mean(std::string text, const Row& ours, const Row& theirs, double percent) {
  const double limit = (1.0 - percent / 100.0) * mean_of(theirs);
  const bool lower = mean_of(ours) <= limit && mean_of(ours) < mean_of(theirs);
  // The test is of ranks, which may have found the reverse of what a few large differences make of the means.
  const bool shown = theirs.significant() && theirs.sign > 0;
  return {.text = std::move(text),
          .measured = means_of(ours, theirs),
          .probability = theirs.probability,
          .verdict = !lower  ? Verdict::kFailed
                     : shown ? Verdict::kHeld
                             : Verdict::kNotShown};
}

Claim no_higher_mean(std::string text, const Row& ours, const Row& theirs, bool lowest_possible) {
  const bool held = ours.spread && theirs.spread && (lowest_possible || ours.spread->mean <= theirs.spread->mean);
  const bool ranks_disagree = !lowest_possible && theirs.significant() && theirs.sign < 0;
  return {.text = std::move(text),
          .measured = means_of(ours, theirs),
          .probability = theirs.probability,
          .verdict = held && ranks_disagree ? Verdict::kNotShown : verdict_of(held)};
}

Claim no_difference(std::string text, const Row& ours, const Row& theirs) {
  const bool may_show = smallest_fisher_exact(ours.share.total, theirs.share.total) < kSignificant;
  return {.text = std::move(text),
          .measured = fmt::format("{} in life, {} in virtual time", text_of(ours), text_of(theirs)),
          .probability = ours.probability,
          .verdict = ours.significant() ? Verdict::kFailed
                     : may_show         ? Verdict::kHeld
                                        : Verdict::kNotShown};
}

const Row& lowest_mean(const std::vector<Row>& rows, const std::string& name, const std::vector<std::string>& batches) {
  const auto lowest = std::ranges::min_element(
      batches, {}, [&](const std::string& batch) { return mean_of(row_of(rows, name, batch)); });
  return row_of(rows, name, *lowest);
}

Claim lowest_in(double percent, std::string text, Share share) {
  return {.text = std::move(text),
          .measured = fmt::format("in {} stretches of time", text_of(share)),
          .probability = {},
          .verdict = verdict_of(percent_of(share) >= percent)};
}

double median_of_periods(const Runs& runs, const std::string& batch, const std::string& list) {
  std::vector<double> values;
  for (const auto& value : medians_of_periods(runs.at(batch), list)) {
    if (value) values.push_back(*value);
  }
  return program::percentile_of(std::move(values), 50.0).value_or(kNever);
}

Claim best_of_all(const std::string& text, const std::vector<Row>& rows, const std::string& name,
                  const std::string& reference) {
  const Row& ours = row_of(rows, name, reference);
  const bool higher = ours.metric->better == Better::kHigher;
  const Row* next = nullptr;
  bool shown = true;
  for (const Row& row : rows) {
    if (row.metric != ours.metric || &row == &ours || !row.spread) continue;
    shown = shown && row.worse();
    if (next == nullptr || (row.spread->mean > next->spread->mean) == higher) next = &row;
  }
  if (!ours.spread || next == nullptr) return {text, "nothing", {}, Verdict::kFailed};
  const double mean = ours.spread->mean;
  const double other = next->spread->mean;
  const bool best = higher ? mean >= other : mean <= other;
  return {.text = text,
          .measured = fmt::format("mean {:.{}f}; best of the others: {} with {:.{}f}", mean, ours.metric->digits,
                                  next->batch->label, other, ours.metric->digits),
          .probability = next->probability,
          .verdict = !best   ? Verdict::kFailed
                     : shown ? Verdict::kHeld
                             : Verdict::kNotShown};
}

}  // namespace ctn::case_studies
