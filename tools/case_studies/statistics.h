// Tests of significance for samples of some tens or hundreds of runs.
//
// The tests are exact: they count, among all ways in which the same values could have fallen to the two groups (or the
// same differences could have had either sign), those that lie at least as far from what chance makes of it. So they
// hold for small samples and for ties, and need no distribution of the values. All are two-sided and give the
// probability of such a difference where there is none.
//
// Units: those of the samples. Thread safety: pure functions.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace ctn::case_studies {

// How many of how many.
struct Share {
  std::size_t count = 0;
  std::size_t total = 0;

  friend bool operator==(const Share&, const Share&) = default;
};

// Fisher's exact test: do two shares differ? 1 where one of them is of nothing.
double fisher_exact(Share a, Share b);
// The smallest that it can be of so many: of none beside all.
double smallest_fisher_exact(std::size_t runs, std::size_t others);

// The test of Mann and Whitney (Wilcoxon's rank sum): does one sample tend to larger values than the other? Values may
// be infinite: what was never reached is later than all that was. 1 where a sample is empty.
double mann_whitney(std::span<const double> a, std::span<const double> b);

// Wilcoxon's signed rank test: do pairs of values differ in one direction? Takes the differences; those of 0 are left
// out. 1 where nothing is left.
double signed_rank(std::span<const double> differences);
// Which direction it finds, if any: 1 where positive differences have the larger sum of ranks, -1 where negative ones
// have; 0 where these are equal. A few large differences may make the mean point the other way.
int sign_of_signed_ranks(std::span<const double> differences);

// By the method of Holm: what the probabilities of several tests come to if they are looked at together, in the same
// order.
std::vector<double> holm(const std::vector<double>& probabilities);

// Between which a share lies with 95 % (Wilson's interval); all that is possible where it is of nothing.
struct Interval {
  double low = 0.0;
  double high = 1.0;
};
Interval wilson(Share share);

}  // namespace ctn::case_studies
