// When a plan is made, what it is made from, and what comes into force: the one loop that the runtime (in a thread) and
// the simulator (in virtual time) both step. What it needs from outside it asks a PlanningHost.
//
// How a run's CPU time becomes a plan, in one direction:
//   ran()     the run goes into the estimate of its node, mode and kind of core; one that hung does not, unless the
//             node's run before it hung too
//   plan()    where a plan is due, makes one at the estimated costs, and decides whether it is worth a change: what
//             came of it is a Planned
//   adopt()   takes that, and brings what was decided into force: PlanningHost::in_force()
//
// A plan is due at the end of the bootstrap, every `replan` (while the policy has more to try, several times a second),
// and at once when a node has run that had not before, when compute times, power, clock limits or CPUs have changed
// (policy/replan.h), or when the user has asked for other weights, bounds or CPUs (change()), within a budget of CPU
// time (policy/planning_budget.h). It is made with what is known: nodes that have not run have an assumed cost, and the
// plan says which. Where no plan can be made and the one in force names a CPU that is gone, what comes into force in
// its place has no plan: rates only (policy/planned.h). docs/decisions/0023-planning-with-what-is-known.md says why.
//
// Units: in the types. Thread safety: none; one owner at a time. It reads no clock.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "base/ticks.h"
#include "driver/plan_news.h"
#include "driver/power_watch.h"
#include "graph/app.h"
#include "model/cost.h"
#include "os/os.h"
#include "policy/cpu_kinds.h"
#include "policy/hung_runs.h"
#include "policy/measured_costs.h"
#include "policy/policy.h"
#include "policy/replan.h"
#include "policy/step_cost.h"
#include "record/events.h"
#include "record/writer.h"

namespace ctn::driver {

// How often the loop is to do a step: often enough that changes are answered at once, and that nothing overflows that
// is collected in between.
constexpr Nanos kPlanningStep = std::chrono::milliseconds{50};

// What making a plan took: CPU time of the thread that made it, and elapsed time.
struct PlanningTime {
  Nanos cpu{0};
  Nanos elapsed{0};
};
// Calls the function that it is given, and returns what that took.
using PlanningTimer = std::function<PlanningTime(const std::function<void()>& plan)>;

struct PlanningOptions {
  std::shared_ptr<const policy::Policy> policy;
  os::CpuSet cpus;                                // that were given; policy::CpuKinds::fits() them
  double slack = 0.0;                             // a fraction of a core
  bool stealing = true;                           // false: no subchain steals, whatever the app says
  bool replan = true;                             // false: the first plan that knows all nodes' costs stays
  std::optional<graph::FrameMode> frames{};       // in place of the app's
  std::optional<model::CostTable> known_costs{};  // for policies that decide once, by such
  PlanningTimer timer;
};

// What controllers have done so far, all of them together: CPU time, and steps that a timer began, or something else.
struct ControllerWork {
  Nanos cpu{0};
  std::uint64_t by_timer = 0;
  std::uint64_t by_event = 0;
};

// Of threads: of nodes in a subchain until a controller holds them, of nodes that run by themselves, and of
// controllers.
struct Levels {
  os::Level scheduled = os::Level::kOrdinary;
  os::Level unscheduled = os::Level::kOrdinary;
  os::Level dispatcher = os::Level::kOrdinary;
};

// What came of an attempt to plan. It changes nothing until it is given to PlanningLoop::adopt().
struct Planned {
  policy::PlanReason reason = policy::PlanReason::kStatic;
  std::optional<policy::Decision> next{};  // to be in force; none: what is in force stays
};

// What the loop needs from outside. Called from within plan() and adopt() only.
class PlanningHost {
 public:
  virtual ~PlanningHost() = default;

  // That are online, and that the app's programs may use. Errors: they are not known; nothing changes then.
  virtual Result<os::CpuSet> usable_cpus() = 0;
  virtual os::PowerState power_state() = 0;
  virtual ControllerWork controller_work() = 0;

  // Controllers, and nodes that run by themselves, are at these levels from now on, before any controller follows what
  // comes into force next: they are no lower than before, and not all the same.
  virtual void raise(const Levels& levels) = 0;
  // `decision` replaces the one before it, and is to be carried out from now on. Its cores are those that were given.
  // It may have no plan although the one before had.
  virtual void in_force(const policy::Decision& decision, policy::PlanReason reason) = 0;
  // Of the CPUs that were given, these are left; what is in force takes account of it.
  virtual void cpus_changed(const os::CpuSet& cpus) = 0;
  // What a user should be told: a plan that could not be made, bounds that it relaxes, costs that it assumes
  // (plan_news.h), power or CPUs that have changed.
  virtual void notice(const std::string& kind, const std::string& detail) = 0;
};

class PlanningLoop {
 public:
  // `app` outlives it.
  PlanningLoop(const graph::App& app, PlanningOptions options);

  // --- before the first step ---
  // Errors: a policy that needs costs and has none; the policy's own.
  Status decide_first();
  // Instead, where the first decision is given.
  void begin_with(policy::Decision decision);
  // The app starts: the first decision is in force.
  void begin(TimePoint start, PlanningHost& host);

  // --- what happened ---
  // A run has ended; runs of a node in their order. Where it shows that the node's compute time has changed
  // permanently: from what to what.
  std::optional<record::CostChange> ran(const record::Run& run);
  // A run of the subchain was taken to hang at that time. To be told before that run is.
  void hang_began(SubchainId subchain, TimePoint at) { hung_runs_.began(subchain, at); }

  // When that node's clock ticks (graph::Node::has_clock()), as known from now on: phases may be planned against it.
  void clock_known(NodeId node, const Ticks& ticks);

  // The app is to have these weights and bounds from now on, and to use these CPUs, of those that were given, not none
  // of them. The next step plans by that.
  void change(graph::App app, os::CpuSet cpus);

  // --- a step ---
  // Looks at what has changed, and plans if that is due; none: nothing is due.
  [[nodiscard]] std::optional<Planned> plan(TimePoint now, PlanningHost& host);
  // What was planned, here or elsewhere, comes into force.
  void adopt(Planned planned, PlanningHost& host);

  // What `decide` returns of the situation that a policy decides on, if nodes cost this much.
  template <class Decide>
  auto in_situation(const model::CostTable& costs, const Decide& decide) const {
    return decide(situation(costs, costs));
  }

  // Where threads begin; then the highest of any decision so far, since those before may still be followed.
  const Levels& levels() const { return levels_; }

  // All but where, when and how the app runs.
  record::Header record_header() const;

  bool adapts() const { return options_.policy->adapts(); }
  const policy::Decision& decision() const { return decision_; }  // in force
  const os::CpuSet& cpus() const { return online_; }              // that are planned for
  const policy::PlanningBudget& budget() const { return clock_.budget(); }
  Nanos planning_cpu() const { return planning_cpu_; }  // that plans have taken, as the timer says
  // Rate of the first subchain's head, where the policy follows no plan.
  std::optional<double> hand_set_hz() const;

 private:
  bool check_cpus(TimePoint now, PlanningHost& host);
  void check_power(TimePoint now, PlanningHost& host);
  std::optional<policy::PlanReason> due(TimePoint now, PlanningHost& host);
  Planned make_new_plan(policy::PlanReason why, PlanningHost& host);
  policy::Situation situation(const model::CostTable& costs, const model::CostTable& typical) const;
  model::CostTable with_assumed(model::CostTable costs, const std::vector<NodeId>& unknown,
                                policy::PlanReason why) const;
  bool names_missing_cpu() const;  // what is in force does
  void in_force(policy::PlanReason reason, PlanningHost& host);
  bool rise();  // to the decision's levels; false: it is there already
  policy::Assignment on_given_cores(policy::Assignment assignment) const;

  const graph::App& app_;
  PlanningOptions options_;
  policy::CpuKinds kinds_;
  graph::App asked_;       // with the weights and bounds that hold
  os::CpuSet chosen_;      // of the CPUs that were given: those that it is to use
  os::CpuSet online_;      // of these: those that can be used
  graph::App app_online_;  // asked_ on these alone
  policy::MeasuredCosts measured_;
  policy::StepCost step_cost_;
  policy::HungRuns hung_runs_;
  policy::ReplanClock clock_;
  std::vector<Ticks> clocks_;               // by NodeId; without a period: not known
  std::unique_ptr<policy::Memory> memory_;  // of app_online_; null: the policy has none
  PowerWatch power_;
  PlanNews news_;
  TimePoint next_cpu_check_{};
  TimePoint next_power_check_{};
  policy::Decision decision_;
  Levels levels_;
  Nanos planning_cpu_{0};
  bool cost_changed_ = false;  // since the last step
  bool asked_changed_ = false;
  bool plan_failed_ = false;  // and that was told
  bool no_cpus_ = false;      // none can be used, and that was told
};

}  // namespace ctn::driver
