// How an app is scheduled: each policy turns a situation into a decision, for the runtime and for the simulator alike.
//
//   "auto"          plans rates, cores, priorities or shares of cores, and levels, by what schedules come to in virtual
//                   time; made again as costs change (search_policy.h)
//   "catan"         what sessions use if nothing is said: the planner that the app file names, "auto" if none is
//   "paper"         the paper's Catan (paper.h)
//   "default"       nodes at their fallback_rate, under ordinary scheduling; those without one in a subchain are
//                   triggered by the node before
//   "rate:HZ"       whole subchains at the fallback_rate of their heads, but at a given rate where these are sources
//   "fifo"          as "default", but at fixed real-time priorities in the order of stealing (by weight)
// and StaticPolicy (planned.h), which follows a plan that it is given and never revises it. Policies of others are in
// baselines/; api/policies.h knows all names, and reads the files that some name.
//
// Another policy is another class (hand_set.h is the shortest example) and a name in make_policy(). What a subchain is
// paced by, where its threads run and at which levels, node by node if need be, is in the decision's assignment
// (assignment.h).
//
// Units: in the types. Thread safety: policies never change once made; decide() from any thread.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "base/result.h"
#include "base/ticks.h"
#include "base/time.h"
#include "graph/app.h"
#include "model/cost.h"
#include "os/cpu_set.h"
#include "os/level.h"
#include "plan/plan.h"
#include "policy/assignment.h"
#include "policy/plan_reason.h"
#include "trial/samples.h"

namespace ctn::policy {

// What a policy remembers from one decision to the next. Its caller keeps that, one for each app and set of cores.
class Memory {
 public:
  virtual ~Memory() = default;
  Memory(const Memory&) = delete;
  Memory& operator=(const Memory&) = delete;

  // Whether it is worth asking again although nothing has changed. `min_runs`: see Situation.
  virtual bool more_to_do(std::size_t min_runs) const = 0;
  // The CPU time of all decisions so far, as reckoned for an ordinary machine. Never falls.
  virtual Nanos work() const = 0;

 protected:
  Memory() = default;
};

// What is decided upon. References are good for the call.
struct Situation {
  const graph::App& app;                     // as the policy runs it; its cores, where it lists them, are `cpus`
  const os::CpuSet& cpus;                    // that nodes may use; not empty. Core k of a plan is the k-th of them
  const model::CostTable& costs;             // to plan with
  const model::CostTable& typical;           // what runs typically cost
  double slack = 0.0;                        // fraction of a core that ordinary threads are to have
  bool stealing = true;                      // false: no subchain steals, whatever the app says
  std::optional<graph::FrameMode> frames{};  // in place of those of a plan that is given
  std::span<const NodeId> assumed{};         // whose costs were not measured: scheduled nodes that have not run
  PlanReason why = PlanReason::kBootstrap;
  const trial::MeasuredRuns* runs = nullptr;  // as measured; null: none were
  std::size_t min_runs = 0;                   // the smallest number of runs that any node that has run has had
  double step_factor = 1.0;                   // of controllers' steps, as measured (step_cost.h)
  std::span<const Ticks> clocks{};            // by NodeId; without a period, or beyond the end: not known
  Memory* memory = nullptr;                   // of the policy's make_memory(); null: none
  int periodic = 0;                           // decided again as time has passed: the how many-th time in a row, from 1
};

struct Decision {
  Assignment assignment;
  std::optional<plan::Plan> plan;  // that it follows
  // Of nodes that run by themselves, and of controllers.
  os::Level unscheduled_level = os::Level::kOrdinary;
  os::Level dispatcher_level = os::Level::kOrdinary;
};

class Policy {
 public:
  virtual ~Policy() = default;
  Policy(const Policy&) = delete;
  Policy& operator=(const Policy&) = delete;

  const std::string& name() const { return name_; }  // as written

  // Its decisions have a plan.
  virtual bool follows_plan() const = 0;
  // Is asked again as costs and cores change.
  virtual bool adapts() const { return false; }
  // How often, if nothing has changed.
  virtual Nanos replan_every(const graph::SchedulerOptions& options) const { return options.replan; }
  // Needs real-time levels.
  virtual bool raises() const = 0;
  // What it decides upon is the app with its subchains cut where nodes have rates of their own (graph/cut.h); who runs
  // an app by it cuts them.
  virtual bool cuts_subchains() const { return false; }
  // Decides itself whether what is in force is to be replaced.
  virtual bool judges() const { return false; }
  // Null: it remembers nothing.
  virtual std::unique_ptr<Memory> make_memory() const { return nullptr; }
  // Decides once, by the situation's costs: they must be real ones, not a guess for the beginning.
  virtual bool needs_costs() const { return false; }

  // Errors: what the app does not say (rates set by hand) or cannot have (a plan). kCaller.
  virtual Result<Decision> decide(const Situation& situation) const = 0;

  // Decides again, with `in_force` under way, which may be of other cores. None: nothing better was found, and what is
  // in force stays.
  virtual Result<std::optional<Decision>> decide_again(const Situation& situation, const Decision& in_force) const;

 protected:
  explicit Policy(std::string name) : name_(std::move(name)) {}

 private:
  std::string name_;
};

// The app as it runs by the policy.
graph::App as_run_by(const Policy& policy, graph::App app);

// Of a policy that needs costs where there are none (kCaller).
Error costs_missing(const Policy& policy);

// "catan", "auto", "paper", "default", "fifo", "rate:30", "rate:12.5Hz". kCaller: it is none of these.
Result<std::shared_ptr<const Policy>> make_policy(std::string_view text);

}  // namespace ctn::policy
