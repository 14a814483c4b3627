// What studies claim of a comparison (comparison.h): the words, what was measured, and whether it held.
//
// Thread safety: pure functions.
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "comparison.h"

namespace ctn::case_studies {

inline constexpr double kNever = std::numeric_limits<double>::infinity();

// "3 of 40"; the median or "never".
std::string text_of(Share share);
std::string text_of(const Row& row);

double percent_of(Share share);
double median_of(const Row& row);  // kNever where there is none
double mean_of(const Row& row);    // the same
// In milliseconds, of a list of periods over time: the median of the stretches' medians of all runs (run.h,
// medians_of_periods). kNever where there is none.
double median_of_periods(const Runs& runs, const std::string& batch, const std::string& list);

Verdict verdict_of(bool held);

// That a batch is worse than its group's reference by a metric, and not by chance.
Claim worse_than_reference(std::string text, const std::vector<Row>& rows, const std::string& name,
                           const std::string& batch, const std::string& reference);
// That it is not better: the reference's median is no worse.
Claim no_better_than_reference(std::string text, const std::vector<Row>& rows, const std::string& name,
                               const std::string& batch, const std::string& reference);
// That the reference's mean is the best of all, and that this is not by chance.
Claim best_of_all(const std::string& text, const std::vector<Row>& rows, const std::string& name,
                  const std::string& reference);
// Of means, where runs are pairs: that ours is lower than theirs, by so many percent at least, and not by chance.
// Precondition, here and below: `theirs` was compared with ours. Not shown: where that test found the reverse, too.
Claim lower_mean(std::string text, const Row& ours, const Row& theirs, double percent = 0.0);
// That ours is no higher, or, higher or not, is as low as it can be. Not shown: where the test found it higher.
Claim no_higher_mean(std::string text, const Row& ours, const Row& theirs, bool lowest_possible = false);
// That the share of runs in life (`ours`, which was compared with the other, by a test alone: adjusting for several
// would make it easier to hold) differs from that in virtual time by chance alone. Not shown: there are so few runs
// that none beside all of them might be chance.
Claim no_difference(std::string text, const Row& ours, const Row& theirs);
// Of these batches the one with the lowest mean by a metric. Precondition: there is one.
const Row& lowest_mean(const std::vector<Row>& rows, const std::string& name, const std::vector<std::string>& batches);
// That a batch has the lowest median in at least so many percent of the stretches of time.
Claim lowest_in(double percent, std::string text, Share share);

}  // namespace ctn::case_studies
