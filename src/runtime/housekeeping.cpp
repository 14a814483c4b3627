#include "runtime/housekeeping.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string>
#include <utility>

#include "record/app_changes.h"

namespace ctn::runtime {
namespace {

// Rings of 4096 reports hold what even a 10 kHz node says in between.
constexpr Nanos kStep = driver::kPlanningStep;
constexpr Nanos kFlushEvery = std::chrono::seconds{1};
// By then controllers have carried out what was published: a frame has ended, or a run.
constexpr Nanos kSettled = std::chrono::seconds{1};

}  // namespace

Housekeeping::Housekeeping(const graph::App& app, os::Os& os, const Region& region, Enforcer& enforcer,
                           AllowedCpus& allowed, AskedChanges& asked, ControllerThreads& controllers, Reporting from,
                           Measurements& measurements, driver::Notices& notices, std::unique_ptr<record::Writer> writer,
                           flight::Recorder* recorder, driver::PlanningLoop loop)
    : app_(app),
      os_(os),
      region_(region),
      enforcer_(enforcer),
      allowed_(allowed),
      asked_(asked),
      controllers_(controllers),
      links_(from.links),
      registered_(from.registered),
      measurements_(measurements),
      recorder_(recorder),
      cpus_(loop.cpus()),
      carried_out_{app, cpus_},
      loop_(std::move(loop)),
      clocks_(app.graph, region),
      log_(app, loop_, measurements, notices),
      collector_(app, os, std::move(from), clocks_, measurements, log_),
      unscheduled_(app.graph, region, links_, registered_),
      incomplete_(app.graph.subchains().size()),
      paced_(app.graph.subchains().size(), false) {
  log_.record_to(std::move(writer));
  log_.keep_in(recorder_);
}

void Housekeeping::begin(TimePoint start) {
  measurements_.cpus_in_use(cpus_);
  loop_.begin(start, *this);
}

void Housekeeping::pace_registered() {
  for (std::size_t index = 0; index < paced_.size(); ++index) {
    paced_[index] = registered_.has_all_of(app_.graph.subchains()[index]);
  }
  publish(loop_.decision());
}

void Housekeeping::run(const std::function<bool(TimePoint)>& sleep_until) {
  allowed_.watch(os_.current_thread());
  TimePoint next_flush = os_.now() + kFlushEvery;
  while (sleep_until(os_.now() + kStep)) step(next_flush);
}

void Housekeeping::step(TimePoint& next_flush) {
  collector_.collect();
  const TimePoint now = os_.now();
  if (recorder_ != nullptr) recorder_->show_alive(now);
  for (const record::ClockReading& reading : clocks_.look(now)) {
    log_.clock_read(reading);
    controllers_.know_clock(reading.node, reading.ticks);
  }
  registered_.forget_ended_threads();
  if (enforcer_.real_time()) unscheduled_.look([this](const std::string& what) { notice("watchdog", what); });
  update_registered();
  let_go_of_incomplete(now);
  carry_out_changes(now);
  if (std::optional<driver::Planned> planned = loop_.plan(now, *this)) {
    measurements_.planned(loop_.budget().plans(), loop_.planning_cpu());
    loop_.adopt(std::move(*planned), *this);
  }
  const bool time_to_flush = now >= next_flush;
  if (time_to_flush || collector_.has_pending_starvation()) collector_.check_starvation();
  if (time_to_flush) {
    next_flush = now + kFlushEvery;
    collector_.note_losses();
    collector_.note_misuses();
    collector_.note_ignored_wakes();
    log_.flush(now);
    keep_places(now);
    incomplete_.wake_again([this](SubchainId subchain) { wake_nodes(subchain); });
  }
}

void Housekeeping::carry_out_changes(TimePoint now) {
  std::optional<AskedChanges::State> asked = asked_.take();
  if (!asked) return;
  std::string told;
  const auto tell = [&](const std::string& what) { told += (told.empty() ? "" : "; ") + what; };
  for (const record::AppChange& change : record::differences(carried_out_.app, asked->app, now)) {
    log_.app_changed(change);
    tell(record::describe(app_, change));
  }
  if (asked->cpus != carried_out_.cpus) {
    tell(fmt::format("CPUs: {} -> {}", os::to_string(carried_out_.cpus), os::to_string(asked->cpus)));
  }
  carried_out_ = *asked;
  if (told.empty()) return;  // it is so already
  log_.notice({now, "changed", told});
  loop_.change(std::move(asked->app), std::move(asked->cpus));
}

Status Housekeeping::finish() {
  collector_.collect();
  collector_.note_losses();
  collector_.note_misuses();
  collector_.check_starvation();
  Status closed = log_.close(os_.now(), os_.host_facts());
  if (recorder_ != nullptr) recorder_->end();
  return closed;
}

void Housekeeping::raise(const driver::Levels& levels) {
  controllers_.raise(levels.dispatcher);
  registered_.raise_unscheduled(levels.unscheduled);
}

void Housekeeping::in_force(const policy::Decision& decision, policy::PlanReason reason) {
  publish(decision);
  log_.in_force(os_.now(), decision, reason);
}

// Threads that belong to no subchain are placed here. The system moves a thread whose CPUs have all gone, but does not
// move it back when they return.
void Housekeeping::cpus_changed(const os::CpuSet& cpus) {
  registered_.place_on(cpus);
  measurements_.cpus_in_use(cpus);
  for (std::size_t index = 0; index < app_.graph.nodes().size(); ++index) {
    if (!app_.graph.nodes()[index].unscheduled) continue;
    links_[index]->for_each_thread([&](os::ThreadId thread) { enforcer_.move_now(thread, cpus); });
  }
  controllers_.move_to_online_cpus(cpus);
}

// A user who changes the affinity of all threads of a program (`taskset -a`) moves the threads that a plan has placed,
// too. They are moved back, to where the plan wants them on the CPUs that are left.
void Housekeeping::keep_places(TimePoint now) {
  if (!loop_.adapts() || now - published_ < kSettled) return;
  std::size_t moved = 0;
  for (std::size_t index = 0; index < paced_.size(); ++index) {
    if (!paced_[index]) continue;
    for (const NodeId node : app_.graph.subchains()[index].nodes) {
      links_[node.index()]->for_each_thread(
          [&](os::ThreadId thread) { moved += enforcer_.keep_on(thread, places_[index]) ? 1 : 0; });
    }
  }
  controllers_.keep_on_cpus(loop_.cpus());
  if (moved == 0 || std::exchange(moved_told_, true)) return;
  log_.notice(
      {now, "moved",
       fmt::format(
           "another program has pinned {} of the app's threads to other CPUs than planned: they are moved back, "
           "then and whenever it happens again. To have it use fewer CPUs, take them from its programs' "
           "main threads, or from the server or session",
           moved)});
}

// The decision, without the subchains that miss a node. Nodes read from the region at which period they are to go
// on if the scheduler is gone.
void Housekeeping::publish(const policy::Decision& decision) {
  Assignment assignment = decision.assignment;
  remove_absent(assignment, paced_);
  for (std::size_t index = 0; index < assignment.places.size(); ++index) {
    const policy::SubchainPlace& place = assignment.places[index];
    const Nanos period =
        place.core < 0 ? place.pacing.period : to_nanos(plan::usual_timing(*decision.plan, SubchainId(index)).period);
    SignalCell& signal = region_.signal(SubchainId(index));
    signal.period.store(period.count(), std::memory_order_relaxed);
    signal.threads.store(place.threads, std::memory_order_relaxed);
  }
  places_.clear();
  for (const policy::SubchainPlace& place : assignment.places) places_.push_back(place.cpus);
  published_ = os_.now();
  controllers_.publish(std::move(assignment));
}

void Housekeeping::update_registered() {
  RegisteredNodes::Change change = registered_.settle(paced_);
  for (const SubchainId id : change.left) paced_[id.index()] = false;
  std::erase_if(change.back, [&](SubchainId id) { return !prepare_restart(id); });
  for (const SubchainId id : change.back) {
    paced_[id.index()] = true;
    // Before its next trigger.
    if (incomplete_.complete(id)) tell_nodes(id, false);
  }
  if (!change.left.empty() || !change.back.empty()) publish(loop_.decision());
  for (const SubchainId id : change.back) {
    log_.notice({os_.now(), "subchain",
                 fmt::format("subchain {} runs: all of its nodes have registered", app_.graph.subchain(id).name)});
  }
}

// A program that runs one of the nodes may be there without the others, whatever keeps these.
void Housekeeping::let_go_of_incomplete(TimePoint now) {
  for (std::size_t index = 0; index < paced_.size(); ++index) {
    if (paced_[index]) continue;
    const SubchainId id(index);
    const graph::Subchain& subchain = app_.graph.subchain(id);
    const std::vector<NodeId> missing = registered_.missing_of(subchain);
    if (!incomplete_.look(id, !missing.empty() && missing.size() < subchain.nodes.size(), now)) continue;
    tell_nodes(id, true);
    std::vector<std::string> names;
    for (const NodeId node : missing) names.push_back(app_.graph.node(node).name);
    log_.notice({now, "subchain",
                 fmt::format("subchain {} is let go of until {} {} {} there: callbacks that are bound to its other "
                             "nodes are called as without Catan",
                             subchain.name, names.size() == 1 ? "node" : "nodes", fmt::join(names, ", "),
                             names.size() == 1 ? "is" : "are")});
  }
}

void Housekeeping::tell_nodes(SubchainId subchain, bool incomplete) {
  region_.signal(subchain).incomplete.store(incomplete ? 1 : 0, std::memory_order_seq_cst);
  wake_nodes(subchain);
}

void Housekeeping::wake_nodes(SubchainId subchain) {
  for (const NodeId node : app_.graph.subchain(subchain).nodes) links_[node.index()]->wake();
}

// False: the controller that held it has not handed it over yet. Runs that were under way when a node left count as
// ended. While this process was stopped its nodes may have paced themselves, and are at most one trigger ahead of what
// has ended: the next number is beyond that, since a node does not see a trigger of the number that it is at.
bool Housekeeping::prepare_restart(SubchainId subchain) {
  Handover& handover = controllers_.handover(subchain);
  std::optional<dispatch::RunState> state = handover.take();
  if (!state) return false;
  constexpr std::uint64_t kAhead = 8;
  constexpr std::uint64_t kMaxLocalTriggers = 1U << 30;  // no program of ours writes more
  const std::uint64_t ended = region_.signal(subchain).completed.load(std::memory_order_seq_cst);
  if (ended > state->sent && ended - state->sent < kMaxLocalTriggers) state->sent = ended;
  state->sent += kAhead;
  state->completed = state->sent;
  state->hanging = false;
  region_.signal(subchain).completed.store(state->sent, std::memory_order_seq_cst);
  handover.put(*state);
  return true;
}

}  // namespace ctn::runtime
