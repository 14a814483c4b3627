// A session, on whatever operating system it is given: it starts the threads, gives them their levels and cores, swaps
// plans, and takes everything back. include/catan/session.h is this engine on Linux; the tests run it in virtual time.
//
// Threads of a session:
//   one a scheduled node       on its subchain's cores, active or, where they are shared, as their dispatcher says
//                              (policy catan); ordinary, on all CPUs (hand-set rates)
//   one an unscheduled node    level unscheduled
//   one a subchain             its trigger thread, level dispatcher
//   one a core                 the core's dispatcher, level dispatcher (policy catan)
//   one housekeeper            level ordinary, wherever the system puts it
//
// Units: in the types. Thread safety: as include/catan/session.h says.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <typeindex>
#include <vector>

#include "base/result.h"
#include "catan/snapshot.h"
#include "graph/app.h"
#include "model/cost.h"
#include "os/os.h"
#include "plan/plan.h"
#include "runtime/assignment.h"
#include "runtime/controller.h"
#include "runtime/enforcer.h"
#include "runtime/housekeeper.h"
#include "runtime/policy.h"
#include "runtime/replan.h"
#include "runtime/wiring.h"

namespace ctn::runtime {

struct EngineOptions {
  Policy policy;
  os::CpuSet cpus;     // empty: all that this thread may use
  std::string record;  // path; empty: none
  std::string note;
  bool stealing = true;                      // false: nobody steals, whatever the app says
  bool replan = true;                        // false: the first plan that rests on measurements stays
  std::optional<graph::FrameMode> frames{};  // in place of the app's
  std::function<void(const std::string&)> on_notice;
};

class Engine {
 public:
  static Result<std::unique_ptr<Engine>> create(graph::App app, os::Os& os, EngineOptions options);
  ~Engine();
  Engine(const Engine&) = delete;
  Engine& operator=(const Engine&) = delete;

  const graph::App& app() const { return app_; }
  Wiring& wiring() { return wiring_; }

  Status start();
  Status stop();
  Status adopt_this_thread(std::string_view node);
  Snapshot snapshot() const;

 private:
  Engine(graph::App app, os::Os& os, EngineOptions options, os::CpuSet cpus);

  Status prepare();
  void keep_cpus_ready();
  Status open_record(TimePoint start, TimePoint warm_from, std::unique_ptr<record::Writer>& writer);
  Status make_first_assignment();
  Status place_by_hand();
  os::Level level_of_unscheduled() const;
  os::Level level_of_controllers() const;
  Result<plan::Plan> read_plan() const;
  Assignment on_all_cores(Assignment assignment) const;
  Assignment assignment() const;
  void publish(Assignment assignment);
  Rate source_rate() const;  // of the first subchain's head, as paced
  Result<plan::Plan> make_plan(const model::CostTable& costs, const model::CostTable& typical);
  Status spawn_and_place();
  void spawn_nodes();
  void run_node(NodeId node);
  void run_unscheduled(NodeId node);
  Status place_nodes();
  void spawn_controllers();
  Status place_controllers();
  os::CpuSet cpus_of_controller(std::size_t index) const;
  void wait_until_ready(std::size_t threads);
  void report_ready_and_wait();
  void follow_cpus(TimePoint now);
  void place_anew();
  void replan(TimePoint now);
  void make_plan_anew(TimePoint now, const std::string& reason, bool at_any_rate);
  void adopt(plan::Plan plan, const std::string& reason);
  void end_threads();

  graph::App app_;
  os::Os& os_;
  EngineOptions options_;
  os::CpuSet cpus_;        // that were given
  os::CpuSet there_;       // of these, the ones that are online: what is planned for
  TimePoint next_look_{};  // at which CPUs are online
  double slack_ = 0.0;
  Wiring wiring_;

  // From start() on.
  std::unique_ptr<Enforcer> enforcer_;
  std::unique_ptr<os::ReadyCpus> ready_cpus_;
  std::unique_ptr<Housekeeper> housekeeper_;
  std::optional<plan::Plan> plan_;  // the housekeeper's, once its thread runs
  std::optional<ReplanClock> replan_clock_;
  std::vector<SubchainPlace> places_;  // by subchain; those in force, the housekeeper's as plan_ is
  std::vector<SubchainPorts> subchains_;
  std::unique_ptr<Controls> controls_;
  std::vector<std::unique_ptr<Controller>> controllers_;  // subchains, then cores
  std::vector<os::ThreadId> controller_ids_;
  std::vector<std::unique_ptr<os::Thread>> threads_;
  std::unique_ptr<os::Thread> housekeeper_thread_;
  std::atomic<std::uint32_t> ready_{0};
  std::atomic<std::uint32_t> go_{0};
  std::atomic<bool> abandoned_{false};
  bool started_ = false;
  bool replan_failed_ = false;
  TimePoint stopped_at_{};
  Status stopped_ = Done{};
};

}  // namespace ctn::runtime
