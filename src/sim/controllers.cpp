#include "sim/controllers.h"

#include <algorithm>
#include <utility>

namespace ctn::sim {

Controllers::Controllers(const graph::App& app, const Machine& machine, int cores, Nodes& nodes, Cpus& cpus,
                         Cpus::Thread first, EventLog& event_log)
    : costs_(machine.costs),
      nodes_(nodes),
      cpus_(cpus),
      first_(first),
      event_log_(event_log),
      real_time_(machine.real_time) {
  driver::Actuator& actuator = *this;
  const std::size_t subchains = app.graph.subchains().size();
  for (std::size_t index = 0; index < subchains; ++index) pacers_.emplace_back(actuator, SubchainId(index));
  for (int core = 0; core < cores; ++core) cores_.emplace_back(actuator, core, subchains);
  sleeping_.resize(pacers_.size() + cores_.size());
  handed_over_.assign(subchains, dispatch::RunState{});
  used_before_.resize(subchains);
}

void Controllers::start(policy::Assignment assignment, const os::CpuSet& cpus, os::Level level,
                        const std::vector<Nanos>& first) {
  take_over(std::move(assignment));
  set_level(level);
  for (std::size_t controller = 0; controller < count(); ++controller) {
    const Cpus::Thread thread = first_ + static_cast<Cpus::Thread>(controller);
    const bool pinned = controller >= pacers_.size();
    cpus_.set_cpus(thread, pinned ? CpuMask::only(cpus.cpus()[controller - pacers_.size()]) : CpuMask(cpus));
    const Nanos begin = first_of(controller, first);
    begin > Nanos{0} ? cpus_.wake_at(thread, cpus_.now() + begin) : wake(controller, -1);
  }
}

Nanos Controllers::first_of(std::size_t controller, const std::vector<Nanos>& first) const {
  if (first.empty()) return Nanos{0};
  if (controller < pacers_.size()) return first[controller];
  Nanos earliest = Nanos::max();
  for (const dispatch::SharedCoreSlot& slot : assignment_.cores[controller - pacers_.size()].slots) {
    earliest = std::min(earliest, first[slot.subchain.index()]);
  }
  return earliest == Nanos::max() ? Nanos{0} : earliest;
}

void Controllers::publish(policy::Assignment assignment) {
  take_over(std::move(assignment));
  for (std::size_t controller = 0; controller < count(); ++controller) wake(controller, -1);
}

void Controllers::set_level(os::Level level) {
  for (std::size_t controller = 0; controller < count(); ++controller) {
    cpus_.set_level(first_ + static_cast<Cpus::Thread>(controller),
                    real_time_ ? static_cast<Cpus::LevelNumber>(level) : 0);
  }
}

void Controllers::take_over(policy::Assignment assignment) {
  assignment.number = assignment_.number + 1;
  assignment_ = std::move(assignment);
  for (std::size_t index = 0; index < assignment_.places.size(); ++index) {
    nodes_.signal(SubchainId(index)).threads = assignment_.places[index].threads;
  }
}

void Controllers::wake(std::size_t controller, int from_cpu) {
  sleeping_[controller].woken = true;
  cpus_.wake(first_ + static_cast<Cpus::Thread>(controller), from_cpu);
}

Nanos Controllers::begin(Cpus::Thread thread, int cpu) {
  acting_ = thread - first_;
  cpu_ = cpu;
  Sleeping& sleeping = sleeping_[acting_];
  const bool by_timer = !std::exchange(sleeping.woken, false);
  sleeping.until = acting_ < pacers_.size() ? pacers_[acting_].step(cpus_.now())
                                            : cores_[acting_ - pacers_.size()].step(cpus_.now());
  const Nanos step = by_timer ? costs_.dispatch_timer : costs_.dispatch_event;
  work_.cpu += step + costs_.context_switch;
  ++(by_timer ? work_.by_timer : work_.by_event);
  return step;
}

bool Controllers::done(Cpus::Thread thread) {
  const Sleeping& sleeping = sleeping_[thread - first_];
  if (sleeping.woken || sleeping.until <= cpus_.now()) return true;
  cpus_.wake_at(thread, sleeping.until);
  return false;
}

// --- What drivers ask for ---

std::optional<dispatch::RunState> Controllers::take(SubchainId subchain) {
  std::optional<dispatch::RunState> state = std::exchange(handed_over_[subchain.index()], std::nullopt);
  if (state) nodes_.signal(subchain).holder = acting_;
  return state;
}

void Controllers::hand_over(SubchainId subchain, const dispatch::RunState& state) {
  nodes_.signal(subchain).wants_completions = false;
  nodes_.signal(subchain).holder.reset();
  handed_over_[subchain.index()] = state;
  wake(driver::holder_of(subchain, assignment_.places[subchain.index()], pacers_.size()), -1);
}

bool Controllers::await_outputs(const plan::Leader& leader, std::uint64_t count) {
  ignore_outputs(leader);
  nodes_.outputs(leader).subscribers.push_back({acting_, count});
  return true;
}

void Controllers::ignore_outputs(const plan::Leader& leader) {
  std::erase_if(nodes_.outputs(leader).subscribers,
                [this](const sim::Outputs::Subscriber& each) { return each.controller == acting_; });
}

void Controllers::trigger(SubchainId subchain, std::uint64_t number, TimePoint due) {
  nodes_.trigger(subchain, number, cpu_);
  event_log_.triggered({subchain, number, due, cpus_.now()});
}

}  // namespace ctn::sim
