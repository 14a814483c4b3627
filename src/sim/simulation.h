// An app in virtual time: the policies, controllers and planner that the runtime uses, on a machine that is a model.
// Deterministic to the bit: the same app, costs and options give the same outcome on every machine.
//
//   auto sim = Simulation::create(app, std::make_unique<DrawnCosts>(app, work, seed), {.policy = policy});
//   (*sim)->set_body(camera, [&](Run& run) { frames.write(run, world.picture((*sim)->now())); });   // if at all
//   (*sim)->run_for(std::chrono::seconds{60});
//   const Outcome outcome = (*sim)->outcome();
//
// How it goes:
//   event_queue.h   when what happens next
//   cpus.h          the machine's CPUs, and which thread has them: levels, fair scheduling, limits
//   nodes.h         nodes: triggers, inputs, runs, outputs
//   clocks.h        clocks that are not Catan's: phases and drift
//   controllers.h   controllers: the drivers of `driver` on simulated threads
//   outcome.h       what it came to
// Here they are put together, and the planning loop (driver/planning_loop.h) does its steps as in the runtime.
//
// What is left out: runs do not slow each other down through caches and memory; threads that the app has besides those
// of its nodes; CPUs that come, go or change their speed; nodes that fail. docs/simulation.md says how far it is from
// real runs.
//
// Units: in the types; time begins at 0. Memory: bounded, however long it runs. Thread safety: none; one owner; several
// simulations may run at once.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "catan/channel.h"
#include "catan/snapshot.h"
#include "graph/app.h"
#include "model/cost.h"
#include "plan/plan.h"
#include "policy/policy.h"
#include "sim/clocks.h"
#include "sim/machine.h"
#include "sim/nodes.h"
#include "sim/outcome.h"
#include "sim/reservation.h"
#include "sim/run_costs.h"

namespace ctn::sim {

// One CPU more is for what is not the app's.
constexpr int kMaxCores = 127;

// A plan, in force from so long after the start.
struct TimedPlan {
  Nanos at{0};
  plan::Plan plan;
};

// What begins when, after the start. On a real machine that is chance, and lasts: nodes and subchains of fixed rates
// keep their phases to each other for as long as they run.
struct Phases {
  std::vector<Nanos> nodes;      // by NodeId: an unscheduled node's first run; empty: a period after the start
  std::vector<Nanos> subchains;  // by SubchainId: the first trigger, at the earliest; empty: at once. Of those that
                                 // share a core, the first counts
  std::vector<Ticks> clocks{};   // by NodeId: of external nodes that tick, and of timers of unscheduled ones; empty, or
                                 // without a period: as drawn
};

// A record to write, as a real run would (record/writer.h). As its host it names a simulated machine.
struct Recording {
  std::string path;
  std::string note;
};

struct Options {
  std::shared_ptr<const policy::Policy> policy;
  Reserve reserve{};  // of a policy whose nodes are in reservations, in place of levels
  Machine machine{};
  bool stealing = true;                      // false: no subchain steals, whatever the app says
  bool replan = true;                        // false: the first plan that knows all nodes' costs stays
  std::optional<graph::FrameMode> frames{};  // in place of the app's
  std::optional<double> slack{};             // in place of the app's
  std::vector<TimedPlan> plans{};            // where not empty, these are followed, by time, and none is made
  std::optional<model::CostTable> costs{};   // as measured before, for policies that decide by such
  Phases phases{};
  ClockChance clocks{};  // of what `phases` does not say
  std::optional<Recording> recording{};
};

class Simulation {
 public:
  // Errors (kCaller): another number of cores than the app lists, or more than can be simulated; what the policy cannot
  // decide or reserve; costs that it needs and are not given; those of a record's writer. Precondition: plans that are
  // given are valid for the app on so many cores, and `policy` follows plans and adapts; subchains that `options` has
  // something to say of are those of the app as it runs by the policy (policy::as_run_by()).
  static Result<std::unique_ptr<Simulation>> create(const graph::App& app, std::unique_ptr<RunCosts> costs,
                                                    Options options);
  ~Simulation();
  Simulation(const Simulation&) = delete;
  Simulation& operator=(const Simulation&) = delete;

  // What a node does, called when a run of it begins, at that instant: it reads its channels, and what it writes
  // reaches others when the run ends. What the run costs is not what the function takes, but what it charges
  // (Run::charge()), or else what the costs say. To be called before the first run_for(). Precondition: the node is not
  // external.
  void set_body(NodeId node, Body body);
  // What reaches the world when a run of the node ends, as a motor's command does. The same Run as in the body.
  void set_effect(NodeId node, Body effect);
  // The channel of an edge between two nodes with bodies. Precondition: there is such an edge, its T is always the
  // same, and its kind is that of the input.
  template <class T>
  Channel<T>& channel(NodeId from, NodeId to) {
    return *nodes().channel<Channel<T>>(from, to);
  }
  template <class T>
  QueueChannel<T>& queue(NodeId from, NodeId to) {
    return *nodes().channel<QueueChannel<T>>(from, to);
  }

  // The same edge's channel, where the caller has made it: runs of `consumer` consume over that input what its function
  // reads there.
  void use_channel(NodeId consumer, std::size_t input, ChannelBase& channel);

  TimePoint now() const;
  // When what is measured begins: after the bootstrap and a little more, as in a real run.
  TimePoint warm_from() const;
  // Simulates so much more, unless status() is an error.
  void run_for(Nanos duration);
  // Errors (kCaller): what functions have done wrong: charges that cannot be, a node that charges nothing where no cost
  // is known of it. Time stopped there.
  Status status() const;

  // Closes the record, if one is written; what comes later is not in it. Errors: what could not be written.
  Status finish();

  // Up to now.
  Outcome outcome();
  // As a session shows it; its percentiles are the outcome's.
  Snapshot snapshot();
  const std::optional<plan::Plan>& plan() const;  // in force; none where the policy follows none
  std::uint64_t events() const;

 private:
  class Impl;
  explicit Simulation(std::unique_ptr<Impl> impl);
  Nodes& nodes();

  std::unique_ptr<Impl> impl_;
};

// A whole simulation: the warm-up, and so much after it. Errors: as create() has.
// `on_progress`: is told from time to time which part of it is done, from 0 to 1; empty: nobody is.
Result<Outcome> simulate(const graph::App& app, std::unique_ptr<RunCosts> costs, Options options, Nanos measured,
                         const std::function<void(double)>& on_progress = {});

}  // namespace ctn::sim
