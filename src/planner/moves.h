// Small random changes of a schedule of fixed priorities and pipelines: the steps of a local search.
//
// Units: in the types. Thread safety: none; one owner. The same seed gives the same changes everywhere.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/mixed.h"
#include "graph/app.h"
#include "planner/pipelines.h"
#include "trial/schedule.h"

namespace ctn::planner {

class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(mixed_of(seed)) {}

  // In [0, limit). Precondition: limit > 0.
  std::size_t below(std::size_t limit) { return static_cast<std::size_t>(next() % limit); }
  // In [0, 1).
  double fraction() { return fraction_of(next()); }
  bool once_in(std::size_t times) { return below(times) == 0; }

 private:
  std::uint64_t next() { return mixed(state_ += kGolden); }

  std::uint64_t state_;
};

// What a search is free to choose; without one of these it can be seen what that is worth.
struct Freedom {
  bool phases = true;   // false: what is triggered by time is so at phase 0
  bool outputs = true;  // false: no subchain is triggered by another's outputs, unless the app asks for it
};

// An unscheduled node whose outputs may trigger a subchain.
struct Arrival {
  NodeId node;
  Millis apart{0};  // its outputs, at least
};
// Not empty where the app asks for a trigger by arrival.
std::vector<Arrival> arrivals_of(const graph::Graph& graph, SubchainId subchain);

// What a schedule may be changed to.
class Moves {
 public:
  // `cost`: what runs of each subchain cost on average, in ms. The others outlive it.
  Moves(const graph::App& app, std::vector<double> cost, const Pipelines& pipelines, int cores, Freedom freedom = {});

  // From now on phases may be against the clocks of these nodes, where a chain of the subchain's begins or ends with
  // one.
  void know_clocks(const std::vector<NodeId>& clocks);

  // Changes one thing or two. What comes of it is complete and without a cycle of followers; it may be a bad idea.
  void change(trial::Schedule& schedule, Random& random) const;

  // The shortest period that a cap, an exact rate or the dispatcher allows, and that is of use
  // (plan::useful_periods()).
  Nanos shortest_period(std::size_t subchain) const { return limits_[subchain].shortest; }
  bool exact(std::size_t subchain) const { return limits_[subchain].exact; }
  // Gives a subchain the trigger that the app asks for, if it asks for one that is not by time.
  void set_asked_trigger(trial::Place& place, std::size_t subchain) const;

  // Those that exclusive groups join to it.
  const std::vector<SubchainId>& joined(std::size_t subchain) const { return joined_[subchain]; }

  // On each core, those that may be triggered by others take turns and are never pre-empted: the one with the shortest
  // period leads, a pause after its own run and below the others, each of which follows so many of its outputs.
  void take_turns(trial::Schedule& schedule) const;
  // On each core, those that may be triggered by others run one after the other in the order of a chain: the first a
  // pause after its own run and below the others, each other one after an output of one before it. The chain that
  // weighs most, or by chance.
  void fall_in_line(trial::Schedule& schedule, bool by_chance, Random& random) const;

  // No subchain that goes by its own time comes more often than by shortest_period(). Of a schedule from elsewhere.
  void keep_to_useful(trial::Schedule& schedule) const;

  // Whether the subchain goes by its own time, in any period that it may be given.
  bool may_come_less_often(const trial::Place& place, std::size_t subchain) const;
  // So many times less often, if it comes each `period_now`: by a longer period or pause; by more ticks of a clock of
  // others, of which it takes a few more than that; and who follows is held so much further apart. Not at an exact
  // rate.
  void come_less_often(trial::Place& place, std::size_t subchain, double factor, Millis period_now) const;

 private:
  struct Limits {
    Nanos shortest{0};
    Nanos held_apart{0};  // of one that follows outputs: these may come a little early, whatever is of use on average
    bool exact = false;
    graph::TriggerBy trigger = graph::TriggerBy::kAny;
  };
  // Of others.
  struct Clock {
    NodeId node;
    Nanos period{0};
    bool begins = false;  // a chain, rather than ends one
  };

  void change_one(trial::Schedule& schedule, Random& random) const;
  void change_time(trial::Place& place, std::size_t subchain, Random& random) const;
  void change_trigger(trial::Schedule& schedule, std::size_t subchain, Random& random) const;
  void follow_arrivals(trial::Place& place, std::size_t subchain, const Arrival& arrival, int every) const;
  void skip_ticks(trial::Place& place, double factor) const;
  static Nanos some_phase(Nanos period, const Clock& clock, double cost, Random& random);
  void change_clock(trial::Place& place, std::size_t subchain, Random& random) const;
  bool knows(std::size_t subchain, NodeId clock) const;
  void align(trial::Schedule& schedule, std::size_t subchain, Random& random) const;
  void lead(trial::Schedule& schedule, std::size_t leader) const;
  bool may_lead(const trial::Schedule& schedule, std::size_t subchain, int core) const;
  void line_up(trial::Schedule& schedule, const std::vector<std::size_t>& line) const;
  std::size_t some_predecessor(std::size_t subchain, Random& random) const;
  void change_pause(trial::Place& place, std::size_t subchain, Random& random) const;
  void change_core(trial::Schedule& schedule, std::size_t subchain, std::size_t other, Random& random) const;
  void move_joined(trial::Schedule& schedule, std::size_t subchain, int core) const;
  void change_cores(trial::Schedule& schedule, std::size_t subchain, Random& random) const;
  void give_cores(trial::Schedule& schedule, std::size_t subchain, Random& random) const;
  std::vector<int> cores_for_priorities(const trial::Schedule& schedule) const;

  const graph::App& app_;
  const Pipelines& pipelines_;
  std::vector<double> cost_;
  int cores_;
  Freedom freedom_;
  std::vector<Limits> limits_;                          // by subchain
  std::vector<std::vector<std::size_t>> neighbours_;    // by subchain: that give it something, or take it from it
  std::vector<std::vector<std::size_t>> predecessors_;  // by subchain: those neighbours that give it something
  std::vector<std::vector<SubchainId>> joined_;         // by subchain
  std::vector<std::vector<std::size_t>> chains_;        // subchains on the way, the chain that weighs most first
  std::vector<std::vector<Clock>> clocks_;              // by subchain
  std::vector<std::vector<Arrival>> arrivals_;          // by subchain; empty where the app does not let them trigger it
};

}  // namespace ctn::planner
