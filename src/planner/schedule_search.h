// The search for the schedule of the least expected objective: local search over cores, priorities, periods, pauses,
// phases, which subchain triggers which, and which have several cores of their own. It goes on as long as one lets it,
// and keeps what it has found when costs change, so that it serves a planner with seconds of time as well as one with
// milliseconds now and then.
//
// How it goes:
//   guess()     From several beginnings, thousands of steps by formulas of means (surrogate.h), half a microsecond
//               each. The best become candidates.
//   improve()   The candidates are tried (trial/trial.h), some milliseconds each. Then each is changed, again and
//               again, in one of two ways: by many steps of the formulas, corrected term by term by what its trial
//               found; or by one step at random, which finds what no formula knows (order, phase). A change that a
//               trial confirms replaces its parent; a candidate that does not get better any more gives way to a new
//               beginning. Both ways get the same share of the work.
//   confirm()   The best is tried for longer, where there is time; if it is worse there, the next takes its place.
//   best()      What was found. expected() tries one once more.
// Schedules with frames can be put beside those that it finds; it tries them and leaves them as they are.
//
// What is compared is what trials say of a schedule (scoring.h). All candidates are tried with the same cost draws, so
// that two differ by what they do and not by luck; in two trials with different draws, hours apart, so that none is
// made for one sequence of them or for phases that do not last; and what is expected of the best comes from a third, or
// it would always look better than it is. Where it is known when clocks tick, and they keep their phases for long, the
// second trial is of the phases that they have, and the first of all.
//
// Nothing is proven of the result but its promises, which plan/promise.h computes. The same calls give the same answers
// on every machine: work is counted in steps and events, and said as the CPU time that these take on an ordinary one.
//
// Units: in the types. Thread safety: none; one owner.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "base/ticks.h"
#include "graph/app.h"
#include "model/cost.h"
#include "planner/moves.h"
#include "planner/scoring.h"
#include "planner/surrogate.h"
#include "trial/samples.h"
#include "trial/schedule.h"
#include "trial/trial.h"

namespace ctn::planner {

struct Found {
  trial::Schedule schedule;
  double score = 0.0;             // what it would be if all bounds were kept
  bool tried = false;             // or a guess by formulas
  std::optional<double> relax{};  // of one that was put there, as it was told
};

// What a trial says of a schedule that was found: with draws that no search has seen.
struct Expected {
  trial::Figures figures;  // with p95
  Nanos horizon{0};
};

// By how much periods may be longer so that a schedule holds at new costs, as promised; the first that helps.
inline constexpr std::array kSlowedBy{1.0, 1.05, 1.1, 1.2, 1.35, 1.5, 2.0};

class ScheduleSearch {
 public:
  struct Setting {
    int cores = 1;
    double slack = graph::kDefaultSlack;
    std::uint64_t seed = 1;
    Freedom freedom{};
  };

  // `app` outlives it. Preconditions: cores >= 1, and the app lists as many if it lists any; slack in [0, 1); the app
  // has a subchain.
  ScheduleSearch(const graph::App& app, const Setting& setting);

  // What runs cost from now on; `planned`: the percentiles that promises go by. What is known of candidates by trials
  // is forgotten. To be called before all below.
  void set_costs(trial::Samples samples, model::CostTable planned, const trial::Overheads& machine = {});

  // Phases may be chosen against the clocks of these nodes, of which it is known when they tick. None at first.
  void know_clocks(std::vector<NodeId> clocks);
  // When clocks tick, by NodeId; without a period it is not known. True: their phases are not those that candidates
  // were tried at, and what is known by trials is forgotten.
  bool know_phases(const std::vector<Ticks>& clocks);

  // To be tried, before any guess, and improved; with frames, to be tried alone: valid for the app and the cores.
  // `relax`: by how much bounds are relaxed under it, where that is known. One with frames replaces the one before. One
  // that does not trigger by arrival what the app says is passed over.
  void add(trial::Schedule schedule, std::optional<double> relax);

  // The same, with periods and pauses so many times as long where they may be: what costs more than before may so hold
  // again.
  trial::Schedule slowed(trial::Schedule schedule, double factor) const;

  // So many steps by formulas alone, from several beginnings; `after_each` is called after each of these.
  void guess(std::size_t steps, const std::function<void()>& after_each = {});
  // At least one step, and until that much work is done. Precondition: there is a candidate.
  void improve(Nanos work);
  // All work so far.
  Nanos work() const { return work_; }
  // How many steps of improve() have been in vain since the last that made the best one better.
  std::size_t steps_in_vain() const { return steps_in_vain_; }
  // Whether some candidate is but a guess.
  bool has_untried() const;
  // Makes all candidates tried, and the first of them one that a trial of this horizon (or the usual one, if that is
  // longer) finds as good as those before did: what slides so slowly that these saw but the beginning shows there.
  // Precondition: there is a candidate.
  void confirm(Nanos horizon);

  // All candidates, the best first; that order is with bounds as formulas guess them.
  std::vector<Found> best() const;
  // The schedule as it would be found now, with longer periods where it would overload a core, if that helps; it does
  // not become a candidate.
  Found tried(const trial::Schedule& schedule, std::optional<double> relax);
  // By a trial that is at least so long.
  Expected expected(const trial::Schedule& schedule, Nanos at_least = Nanos{0});

  const trial::Samples& samples() const { return costs_->samples; }
  const model::CostTable& planned() const { return costs_->planned; }

 private:
  struct Costs {
    Costs(const graph::App& app, trial::Samples drawn, model::CostTable percentiles, double slack,
          const trial::Overheads& of_machine)
        : samples(std::move(drawn)),
          planned(std::move(percentiles)),
          machine(of_machine),
          surrogate(app, samples, planned, slack, machine),
          pipelines(app, samples, planned, slack),
          trial(app, samples) {}
    trial::Samples samples;
    model::CostTable planned;
    trial::Overheads machine;
    Surrogate surrogate;
    Pipelines pipelines;
    trial::Trial trial;
  };
  struct Candidate {
    trial::Schedule schedule;
    double score = 0.0;        // with bounds, of two trials or by formulas alone
    double unbounded = 0.0;    // without
    double first_score = 0.0;  // with bounds, of the first trial
    bool tried = false;
    bool given = false;             // by add()
    std::vector<double> factors{};  // from formulas to what the first trial found, by term
    double load_factor = 1.0;       // the same of how full the fullest core is
    std::optional<double> relax{};  // where it is known; else by the surrogate
    double glance = 0.0;            // its score in a short trial; 0: there was none
    std::size_t in_vain = 0;        // changes since it got better
  };
  static bool better(const Candidate& a, const Candidate& b) { return a.score < b.score; }
  static bool fixed(const Candidate& candidate) { return !candidate.schedule.frames.empty(); }

  void forget_trials();
  bool renew_pipelines(trial::Schedule& schedule) const;
  void make_hold(trial::Schedule& schedule);
  bool keeps_asked_triggers(const trial::Schedule& schedule) const;
  trial::Schedule beginning(bool even);
  void arrange(trial::Schedule& schedule, std::size_t sort, bool by_chance);
  // Where it is above the limit, any number above it. Where a core is used for more than there is, and others on it may
  // come less often, they do.
  double guessed_score(trial::Schedule& schedule, double limit = kInfinity);
  std::vector<double> guessed_load(const trial::Schedule& schedule) const;
  bool make_room(trial::Schedule& schedule) const;
  Candidate anneal(trial::Schedule schedule, std::size_t steps, double temperature);
  void keep(Candidate candidate);

  double bounded(const Candidate& candidate, double score);
  trial::Figures run_trial(const trial::Schedule& schedule, trial::Options options);
  trial::Figures try_out(const trial::Schedule& schedule, trial::Options options, Nanos at_least = Nanos{0});
  double glance(const Candidate& candidate);
  bool is_hopeless(const Candidate& candidate) const;
  // How full the fullest core is (CoreUse::fullest).
  double try_first(Candidate& candidate);
  double try_again(Candidate& candidate);
  void try_whole(Candidate& candidate);
  void set_horizon(const trial::Schedule& schedule);
  void step();
  Candidate changed_by_formulas(const Candidate& candidate);
  Candidate changed_by_chance(const Candidate& candidate);
  void replace_by_new(Candidate& candidate);

  const graph::App& app_;
  Setting setting_;
  Random random_;
  std::unique_ptr<Costs> costs_;
  Scoring scoring_;
  std::optional<Moves> moves_;
  std::vector<NodeId> clocks_;
  std::vector<Ticks> phases_;          // that are tried; none: all of them
  std::vector<Candidate> candidates_;  // the best first
  Nanos horizon_{0};                   // of a trial; 0: not known yet
  Nanos work_{0};
  Nanos work_by_formulas_{0};  // of changes of candidates
  Nanos work_by_chance_{0};    // the same
  std::size_t steps_in_vain_ = 0;
};

}  // namespace ctn::planner
