// What a schedule of fixed priorities would come to on average, by formulas of means: a microsecond where a trial
// (trial/trial.h) takes a millisecond, so that a search can look at thousands of schedules before it tries the best.
//
// On a core, with the subchains above i in use for a fraction U_i of the time, a run of i that costs c_i takes
//   L_i = c_i / (1 - U_i) + w_i
// where w_i is what it waits on average, while others have the core; and it completes every
//   p_i = its period; L_i + its pause; so many times the period of the outputs that trigger it; and no less than L_i.
// A chain's response time is its latency and its period: the first run; then for each next element, half a period until
// its next run begins (none where it is triggered by the element before) and that run; and the longest time
// between two outputs on the way. What a run takes is the newest: where outputs come more often than it, and each
// brings something new, it waited half of what they are apart.
//
// A subchain that keeps a phase to the clock that ends its chain waits for what is left of that until the next tick, on
// average over long and short runs (run_spread.h); one that keeps it to the clock that begins it finds what came by the
// last tick, when it has passed through nodes that follow that.
//
// One whose runs await input completes no more often than the fastest of what feeds it gives some. Where those that
// trigger it, or feed it, wait for it themselves, it gets no time at all.
//
// A batch costs what the items add that come in p_i on average; its period and its cost follow from one another.
//
// What it leaves out is what trials are for: order and other phases, bursts, which runs meet, batches of unscheduled
// nodes.
//
// It also bounds what is promised (plan/promise.h), by the line; and says how full the fullest core would be.
//
// Units: milliseconds. Thread safety: none; one owner.
#pragma once

#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "base/numbers.h"
#include "graph/app.h"
#include "model/batches.h"
#include "model/cost.h"
#include "model/formulas.h"
#include "plan/trigger_line.h"
#include "planner/run_spread.h"
#include "trial/samples.h"
#include "trial/schedule.h"
#include "trial/trial.h"

namespace ctn::planner {

struct Estimate {
  double objective = 0.0;     // the weighted sum of means
  double relax = 1.0;         // by how much bounds would have to be relaxed, at the promised times
  bool exact_missed = false;  // an exact rate is not promised
  bool promised = true;       // each subchain is promised something
  double load = 0.0;          // of the fullest core: CPU time used, as a fraction of what the slack leaves
};

class Surrogate {
 public:
  // `planned`: the percentiles that promises go by. All outlive it.
  Surrogate(const graph::App& app, const trial::Samples& samples, const model::CostTable& planned, double slack,
            const trial::Overheads& machine = {});

  // From now on the objective is of terms so many times as long as the formulas say, one factor a term, and cores are
  // so many times as full: what a trial of a schedule found that is much like those asked about. It goes back to 1 with
  // an empty list.
  void correct(std::vector<double> factors, double load = 1.0) {
    factors_ = std::move(factors);
    load_factor_ = load;
  }

  // None where some subchain gets no time at all. Where the objective alone is above the limit, promises are not looked
  // at, and the estimate says that there are none. Precondition: as Trial::run(), without frames; subchains that follow
  // one another make no cycle.
  std::optional<Estimate> operator()(const trial::Schedule& schedule, double limit = kInfinity);

  // Of the schedule that was asked about last: each term of the objective, in ms, without correction.
  const std::vector<double>& terms() const { return values_; }
  // The same, of the fullest core: CPU time used, as a fraction of what the slack leaves.
  double fullest() const { return load_; }
  // Of a subchain with a fixed priority: its period, and what it uses of its core as a fraction of what the slack
  // leaves, with correction.
  Millis period(SubchainId subchain) const { return Millis{timings_[subchain.index()].period}; }
  double load(SubchainId subchain) const { return timings_[subchain.index()].load * load_factor_ / usable_; }

  // What a run of the subchain costs on average on a core, the machine's part included; one that takes batches, with
  // one item of each predecessor.
  double mean_cost(SubchainId subchain, int core) const;

 private:
  struct Element {
    std::optional<SubchainId> subchain;  // none: an unscheduled node, or an external one that ticks
    NodeId node;                         // that one
    double period = 0.0;                 // its own, if it has one
    double cost = 0.0;
    double planned = 0.0;  // what a run of that node costs and waits, as promised
    double output_period = 0.0;
    double runs_per_output = 1.0;
    model::LeftOut left_out{};       // by output periods
    bool follows = false;            // as graph::ChainElement
    std::optional<NodeId> leader{};  // that it follows, in the chain or not
  };
  struct Term {
    double weight = 0.0;
    double max = 0.0;               // 0: no bound
    std::vector<Element> elements;  // of a response time
    std::optional<SubchainId> of;   // of a period
    double fixed_period = 0.0;      // of a period that no schedule changes
    double output_period = 0.0;     // of a period: of what comes before the node in its subchain
    // Of the period of a node whose runs may be without input, and do not count then; else empty.
    std::vector<model::BatchInput> inputs;
  };
  struct AtTicks {
    double wait = 0.0;       // until the tick that shows it
    double with_news = 1.0;  // part of the ticks
  };
  using Line = plan::TriggerLine;
  struct UsedAbove {  // of a core, by subchains above one
    Line soon{};
    Line on_average{};
    double if_held = 0.0;        // a ms, however early outputs come that trigger them
    double silence = kInfinity;  // ms after which one may come again, in spite of a run
  };
  struct Timing {  // of a subchain
    double cost = 0.0;
    double square = 0.0;  // mean of the squares
    double planned = 0.0;
    double spacing = 0.0;        // of its triggers, as promised
    double waits = 0.0;          // what a run waits under way, on average
    double planned_waits = 0.0;  // the same as planned
    double parts = 1.0;          // that waits cut a run into
    double period = 0.0;
    double execution = 0.0;
    double from_begin = 0.0;  // its part that is not spent before the run begins
    double wait = 0.0;        // from any time to the next trigger
    double promised_period = 0.0;
    double promised_execution = 0.0;
    double promised_stretch = 1.0;  // what each ms of work adds to that
    // How often it is promised to come at most, by what says less of a short time, and of a long one; and how much more
    // a ms, however early outputs come that trigger it.
    Line promised_soon{};
    Line promised_on_average{};
    double held_rate = 0.0;
    double rate = 0.0;     // 1 / period
    double load = 0.0;     // cost / period
    double anytime = 0.0;  // what is left of its run, where one is met at any time, on average
    // Of one that triggers others that are above it on its core: they run after its runs, and never while it does.
    bool leads = false;
    double led_work = 0.0;              // what those cost, after each of its runs
    double late = 0.0;                  // how long they keep it from its next run, on average
    double stretch = 1.0;               // of what it costs, while others pre-empt it
    std::optional<AtTicks> at_ticks{};  // of its clock, once a term has asked
  };
  // Those above a subchain on its core: order_[first, last).
  struct Above {
    std::size_t first = 0;
    std::size_t last = 0;
    double load = 0.0;
    double anytime = 0.0;
    double longest = 0.0;  // cost
  };
  // Those of them that it triggers.
  struct Led {
    double load = 0.0;
    double anytime = 0.0;
    double late = 0.0;  // how long they keep it from its next run
  };
  enum class Basis { kUsual, kPromised };
  // More than this of a core's time above a subchain leaves it none.
  static constexpr double kNothingLeft = 0.999;

  struct Exclusion {  // an exclusive group
    struct Part {
      std::size_t subchain = 0;
      std::vector<double> hold;  // by kind: for how long a run of its node keeps it, as planned
    };
    std::vector<Part> parts;
    bool has_unscheduled = false;
  };
  // What feeds the head of a subchain, where its runs await input.
  struct Fed {
    double apart = 0.0;                  // outputs of others than subchains, the fastest of them
    std::vector<std::size_t> subchains;  // those that feed it
  };
  struct Batches {  // of a node
    std::vector<model::BatchInput> inputs;
    std::vector<double> per_item;  // by kind
  };

  // What no schedule changes.
  void know_costs(const trial::Samples& samples, const std::vector<model::CostTable>& tables,
                  const trial::Overheads& machine);
  void know_outputs_and_waits(const trial::Samples& samples, const model::CostTable& planned,
                              const std::vector<model::CostTable>& tables);
  void know_arrivals(const model::CostTable& planned, const model::CostTable& costs, double slack);
  void know_term(const graph::Term& term, const trial::Samples& samples, const model::CostTable& planned, double run);
  void know_asked_rates();
  void know_inputs(const model::CostTable& planned);
  double fed_apart(std::size_t subchain) const;
  bool waits_for_itself(const trial::Schedule& schedule) const;
  void know_exclusions(const std::vector<model::CostTable>& tables);
  void know_unscheduled(const trial::Schedule& schedule);
  double promised_run(const Element& element) const;
  double promised_wait(const Element& element) const;
  std::optional<double> promised_blocking(const trial::Schedule& schedule, std::size_t subchain) const;

  std::size_t kind_of(int core) const { return app_.kind_of(core); }
  void take_batches(const trial::Place& place, std::size_t subchain);
  void plan_batches(const trial::Place& place, std::size_t subchain);
  double outputs_apart(const trial::Schedule& schedule, std::size_t subchain) const;
  double runs_per_output(const plan::After& after) const;
  double promised_lateness(const plan::After& after) const;
  double promised_gap(const trial::Schedule& schedule, std::size_t subchain) const;
  double outputs_late(std::size_t subchain) const;
  double left_out(const Element& element, bool followed) const;
  // Preconditions of both: it is triggered by outputs.
  bool is_held_back(const trial::Schedule& schedule, std::size_t subchain) const;
  bool may_be_held_back(const trial::Schedule& schedule, std::size_t subchain) const;
  void begin_leaders(const trial::Schedule& schedule);
  bool settles_at_once(const trial::Schedule& schedule) const;
  void time_subchain(const trial::Schedule& schedule, std::size_t i, const Above& above);
  static bool is_led_by(const trial::Schedule& schedule, std::size_t subchain, std::size_t leader);
  Led led_above(const trial::Schedule& schedule, std::size_t leader, const Above& above) const;
  double found_under_way(const trial::Schedule& schedule, std::size_t i, const Above& above, const Led& led) const;
  bool time_cores(const trial::Schedule& schedule);
  void time_pipelines(const trial::Schedule& schedule);
  double parallel_part(std::size_t kind, std::size_t subchain, int threads) const;
  int turns_of(const trial::Schedule& schedule, std::size_t subchain, int priority) const;
  UsedAbove used_above(const trial::Schedule& schedule, std::size_t subchain, std::size_t first, std::size_t last,
                       bool in_turn) const;
  void promise_triggers(const trial::Place& place, std::size_t subchain, double jitter);
  void promise_subchain(const trial::Schedule& schedule, std::size_t i, std::size_t first, std::size_t last);
  static bool may_come_ever_earlier(const trial::Schedule& schedule, std::size_t subchain);
  double promised_apart(const trial::Schedule& schedule, std::size_t subchain);
  void promise_cores(const trial::Schedule& schedule);
  const AtTicks* at_ticks(const trial::Schedule& schedule, const Element& before, const Element& element);
  // What a clock of others has begun: outputs `passed` after its ticks.
  struct Ticked {
    NodeId clock;
    double period = 0.0;
    double passed = 0.0;
  };
  std::optional<double> wait_since_tick(const trial::Schedule& schedule, const Ticked& begun,
                                        const Element& element) const;
  // Of what a run of the one gives, until a run of the other takes it, where that is not one of its followers.
  // `all_new`: each run of the one brings something new.
  double wait_between(const trial::Schedule& schedule, SubchainId one, SubchainId other, bool all_new,
                      Basis basis) const;
  double counted_period(const Term& term, const trial::Place& place) const;
  double total_of(const trial::Schedule& schedule, const Term& term, Basis basis);
  void promise(const trial::Schedule& schedule, Estimate& estimate);

  const graph::App& app_;
  double usable_;                               // of a core
  double in_time_;                              // before a tick, so that what is woken late is there by then
  std::vector<std::vector<double>> mean_;       // by kind, subchain
  std::vector<std::vector<double>> square_;     // by kind, subchain
  std::vector<std::vector<double>> planned_;    // by kind, subchain
  std::vector<std::vector<RunSpread>> spread_;  // by kind, subchain
  // By kind, subchain, threads - 1: as times one thread.
  std::vector<std::vector<std::vector<double>>> parts_on_threads_;
  std::vector<std::vector<Batches>> batches_;  // by subchain; of its nodes whose runs cost more with each item
  std::vector<std::optional<Fed>> fed_;        // by subchain; empty where no run awaits input
  std::vector<Exclusion> exclusions_;
  // What unscheduled nodes are kept waiting (model/unscheduled.h) in the schedule that is asked about, and what they
  // take of the time of each subchain on its core, by subchain; and the costs by which these are reckoned, empty where
  // there are no such nodes.
  std::vector<Millis> unscheduled_waits_;
  std::vector<Line> unscheduled_;
  std::vector<model::CostTable> tables_;
  std::vector<bool> excludes_unscheduled_;  // by subchain: has an exclusive group with one
  // By subchain: from its core, by what has its exclusive group and waits. Empty if the app has no exclusive groups.
  std::vector<bool> kept_away_;
  int rounds_;                            // until periods are good enough for a guess
  std::vector<double> waits_;             // by subchain
  std::vector<double> planned_waits_;     // by subchain
  std::vector<double> parts_;             // by subchain
  std::vector<double> output_period_;     // by subchain: the longest of its nodes'
  std::vector<double> runs_per_output_;   // by subchain: of its tail's
  std::vector<model::LeftOut> left_out_;  // by subchain: of its tail's outputs
  struct Arrivals {                       // of an unscheduled node's outputs
    double apart = 0.0;                   // where each run gives one
    double late = 0.0;                    // as planned, at most
    double runs_per_output = 1.0;
  };
  std::vector<Arrivals> arrivals_;  // by node
  std::vector<Term> terms_;
  struct AskedRate {
    SubchainId subchain;
    double period = 0.0;
  };
  std::vector<AskedRate> min_rates_;
  std::vector<AskedRate> exact_rates_;
  std::vector<double> factors_;  // by term; empty: all 1
  double load_factor_ = 1.0;

  // Reused.
  std::vector<std::size_t> order_;  // subchains with a priority, core by core, the highest first
  std::vector<Timing> timings_;     // by subchain
  std::vector<double> values_;      // by term
  double load_ = 0.0;
  bool promised_ = true;
  bool settled_ = true;  // periods did not change in the last round
};

}  // namespace ctn::planner
