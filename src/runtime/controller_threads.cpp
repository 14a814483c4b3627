#include "runtime/controller_threads.h"

#include <utility>

namespace ctn::runtime {

ControllerThreads::ControllerThreads(const graph::App& app, os::Os& os, Enforcer& enforcer, const Region& region,
                                     const Links& links, os::CpuSet cpus)
    : app_(app),
      os_(os),
      enforcer_(enforcer),
      cpus_(std::move(cpus)),
      subchains_(subchain_links(app.graph, links, region)),
      controls_(os, enforcer, region, app.graph, cpus_.size()) {
  for (Handover& handover : controls_.handovers) handover.put({});
}

void ControllerThreads::spawn(bool shared) {
  const std::size_t subchains = app_.graph.subchains().size();
  // A subchain that is the only one shares no core.
  const std::size_t cores = shared && subchains > 1 ? cpus_.size() : 0;
  for (std::size_t number = 0; number < subchains + cores; ++number) {
    controllers_.push_back(std::make_unique<ControllerThread>(controls_, subchains_, number));
  }
  for (std::size_t number = controllers_.size(); number < subchains + cpus_.size(); ++number) {
    controls_.board.leave_out(number);
  }
  ids_.resize(controllers_.size());
  for (std::size_t index = 0; index < controllers_.size(); ++index) {
    threads_.push_back(os_.spawn(index < subchains ? "catan-trigger" : "catan-core", [this, index] {
      ids_[index] = os_.current_thread();
      ready_.fetch_add(1, std::memory_order_release);
      os_.wake(ready_);
      while (gate_.load(std::memory_order_acquire) == kClosed) os_.wait(gate_, kClosed, kNever);
      if (gate_.load(std::memory_order_acquire) == kOpen) controllers_[index]->run();
    }));
  }
  for (std::uint32_t ready = 0; ready < threads_.size();) {
    os_.wait(ready_, ready, kNever);
    ready = ready_.load(std::memory_order_acquire);
  }
}

Status ControllerThreads::place(os::Level level) {
  for (std::size_t index = 0; index < ids_.size(); ++index) {
    if (Status placed = enforcer_.apply(ids_[index], level, cpus_of(index, cpus_)); !placed) return placed;
  }
  return Done{};
}

void ControllerThreads::raise(os::Level level) {
  for (const os::ThreadId thread : ids_) enforcer_.raise(thread, level);
}

void ControllerThreads::go() {
  gate_.store(kOpen, std::memory_order_release);
  os_.wake(gate_);
}

void ControllerThreads::stop() {
  std::uint32_t closed = kClosed;
  gate_.compare_exchange_strong(closed, kAbandoned, std::memory_order_acq_rel);
  os_.wake(gate_);
  for (const auto& controller : controllers_) controller->stop();
  for (const auto& thread : threads_) thread->join();
  threads_.clear();
}

void ControllerThreads::publish(Assignment assignment) {
  controls_.board.publish(std::move(assignment));
  controls_.wake_all();
}

driver::ControllerWork ControllerThreads::work() const {
  driver::ControllerWork work;
  for (std::size_t index = 0; index < controllers_.size(); ++index) {
    const Result<Nanos> cpu = os_.thread_cpu_time(ids_[index]);
    if (!cpu) continue;
    work.cpu += *cpu;
    const std::uint64_t by_timer = controllers_[index]->steps_by_timer();
    work.by_timer += by_timer;
    work.by_event += controllers_[index]->steps() - by_timer;
  }
  return work;
}

void ControllerThreads::move_to_online_cpus(const os::CpuSet& online) {
  for (std::size_t index = 0; index < ids_.size(); ++index) {
    const os::CpuSet cpus = cpus_of(index, online);
    if (!cpus.empty()) enforcer_.move_now(ids_[index], cpus);
  }
}

void ControllerThreads::keep_on_cpus(const os::CpuSet& online) {
  for (std::size_t index = 0; index < ids_.size(); ++index) {
    const os::CpuSet cpus = cpus_of(index, online);
    if (!cpus.empty()) static_cast<void>(enforcer_.keep_on(ids_[index], cpus));
  }
}

// A core's thread runs on its core; where that is gone, the system says where. A controller of a subchain may run
// anywhere.
os::CpuSet ControllerThreads::cpus_of(std::size_t controller, const os::CpuSet& online) const {
  const std::size_t subchains = app_.graph.subchains().size();
  return controller < subchains ? online : os::common(online, os::CpuSet{cpus_.cpus()[controller - subchains]});
}

}  // namespace ctn::runtime
