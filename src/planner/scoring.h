// What a trial says of a schedule: how full its cores are, and the score by which the search compares schedules
// (schedule_search.h).
//
// A score is the weighted sum of means; more where bounds are not kept as promised, for each part by which they would
// have to be relaxed; more for a tail far from the mean; and a core that is used beyond what the slack leaves is worse
// than anything. A little more, too, where a core is nearly full and its lowest subchain keeps to a grid of the
// system's clock: what the kernel holds up there (for ordinary threads, which it does not let starve) is made up for
// without a gap, in which ordinary threads starve again. A pause after each run ends that, and no trial shows it.
//
// Units: times in ms. Thread safety: a Scoring is immutable once made; bounded() is as safe as its surrogate.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "graph/app.h"
#include "planner/surrogate.h"
#include "trial/schedule.h"
#include "trial/trial.h"

namespace ctn::planner {

// What a term's 95th percentile counts, as a part of what its mean does: a mean of many good runs hides the ones that
// take ten times as long, which a robot does not forgive. It counts most in the response time that weighs most.
constexpr double kTailWeight = 0.05;
constexpr double kHeaviestTailWeight = 0.7;
std::vector<double> tail_weights(const graph::App& app);  // by term

// A core may be used for so much more than what the slack leaves before it counts: luck of the draws.
constexpr double kLoadTolerance = 0.005;

// What it adds to a score that a whole core is used too much; and more than the score of any schedule that can be had:
// as much as if each term of the objective took 10^9 ms, eleven days.
double overload_score(const graph::App& app);

// What a bound that has to be relaxed by all of itself adds to the score, as a multiple of the objective.
constexpr double kBoundWeight = 5.0;
inline double relaxed_score(double score, double relax) { return score * (1.0 + kBoundWeight * (relax - 1.0)); }

// How full the cores of a schedule are.
struct CoreUse {
  std::vector<double> by_core;  // the part of its time that is used
  double fullest = 0.0;         // the most of these, as a part of what a core may be used for: above 1 is too much
  double overload = 0.0;        // what is too much, of all cores together
};

class Scoring {
 public:
  // `app` outlives it. Precondition: slack in [0, 1).
  Scoring(const graph::App& app, double slack);

  // Precondition here and below: `figures` are a trial's of `schedule`, with p95.
  CoreUse use(const trial::Schedule& schedule, const trial::Figures& figures) const;
  // Without bounds. `used`: as use() says.
  double unbounded(const trial::Schedule& schedule, const trial::Figures& figures, const CoreUse& used) const;
  // The same of a trial so short that it is luck whether a core is full: as if all were slower by its overload.
  double at_a_glance(const trial::Schedule& schedule, const trial::Figures& figures) const;
  double overload() const { return overload_; }
  // What bounds make of a schedule's score: twice overload() where it is no schedule that can be had. The surrogate is
  // asked about the schedule; but of frames it knows nothing: for those `relax` counts, by how much bounds are relaxed
  // under it, where that is known.
  double bounded(Surrogate& surrogate, const trial::Schedule& schedule, std::optional<double> relax,
                 double score) const;
  // What counts of a term, its own weight apart: its mean, and something for its tail.
  double of_term(const trial::Figures& figures, std::size_t term) const {
    return figures.terms[term].mean_ms + tail_weights_[term] * figures.terms[term].p95_ms;
  }

  // A score, and more by the part of all cores that are nearly full and have no gap of their own. `used`: by core, as a
  // part of what the slack leaves.
  static double with_gaps(double score, const trial::Schedule& schedule, const std::vector<double>& used);

 private:
  double weighted(const trial::Figures& figures) const;

  const graph::App& app_;
  double slack_;
  double overload_;                   // overload_score()
  std::vector<double> tail_weights_;  // by term
  bool limits_input_ = false;         // how often some subchain has something to do, since its runs need input
};

}  // namespace ctn::planner
