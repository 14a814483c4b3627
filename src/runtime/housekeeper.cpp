#include "runtime/housekeeper.h"

#include <fmt/format.h>

#include <utility>

#include "plan/json.h"

namespace ctn::runtime {
namespace {

// Short enough that rings of 4096 reports hold what even a 10 kHz node says in between.
constexpr Nanos kTick = std::chrono::milliseconds{50};
constexpr Nanos kFlushEvery = std::chrono::seconds{1};

}  // namespace

Housekeeper::Housekeeper(const graph::App& app, os::Os& os, Wiring& wiring, TimePoint warm_from,
                         std::unique_ptr<record::Writer> writer, Notify notify)
    : app_(app),
      os_(os),
      wiring_(wiring),
      writer_(std::move(writer)),
      notify_(std::move(notify)),
      measurements_(app, warm_from),
      gathered_(app.graph.nodes().size()) {}

void Housekeeper::run(const Controllers& controllers, const Errand& errand) {
  TimePoint next_flush = os_.now() + kFlushEvery;
  while (stopping_.load(std::memory_order_acquire) == 0) {
    os_.wait(stopping_, 0, os_.now() + kTick);
    gather(controllers);
    const TimePoint now = os_.now();
    if (errand) errand(now);
    if (now < next_flush) continue;
    next_flush = now + kFlushEvery;
    note_losses(controllers);
    flush();
  }
}

void Housekeeper::stop() {
  stopping_.store(1, std::memory_order_release);
  os_.wake(stopping_);
}

Status Housekeeper::finish(const Controllers& controllers) {
  gather(controllers);
  note_losses(controllers);
  if (!writer_) return Done{};
  write_notices();
  Status closed = writer_->close(os_.now(), os_.host_facts());
  writer_.reset();
  return closed;
}

void Housekeeper::gather(const Controllers& controllers) {
  const std::span<const NodeId> order = app_.graph.topological_order();
  for (std::size_t position = order.size(); position-- > 0;) {
    gathered_[position].clear();
    NodePort* port = wiring_.port(order[position]);
    if (port == nullptr) continue;
    port->drain([&](record::Run run) { gathered_[position].push_back(std::move(run)); });
  }
  for (const auto& controller : controllers) controller->drain(*this);
  const std::lock_guard lock(mutex_);
  for (const std::vector<record::Run>& runs : gathered_) {
    for (const record::Run& run : runs) {
      measurements_.add(run);
      if (writer_) writer_->add(run);
    }
  }
}

void Housekeeper::triggered(const record::Trigger& trigger) {
  if (writer_) writer_->add(trigger);
}

void Housekeeper::slot_over(const record::Slot& slot) {
  if (writer_) writer_->add(slot);
}

void Housekeeper::stole(const record::Steal& steal) {
  if (writer_) writer_->add(steal);
}

void Housekeeper::hang_changed(SubchainId subchain, bool began) {
  const std::string& name = app_.graph.subchain(subchain).name;
  notice("watchdog", began ? fmt::format("a run of subchain {} hangs: it was contained", name)
                           : fmt::format("the run of subchain {} that hung has ended: it is as before", name));
}

void Housekeeper::note_losses(const Controllers& controllers) {
  std::uint64_t losses = 0;
  for (const NodeId node : app_.graph.topological_order()) {
    if (const NodePort* port = wiring_.port(node)) losses += port->lost_reports();
  }
  for (const auto& controller : controllers) losses += controller->lost_reports();
  std::string edges;
  for (const auto& [edge, count] : wiring_.dropped()) {
    losses += count;
    edges += fmt::format("; {} values on {}", count, edge);
  }
  if (losses == losses_noted_) return;
  losses_noted_ = losses;
  notice("lost-reports",
         fmt::format("{} reports or values were lost because their reader did not keep up{}", losses, edges));
}

void Housekeeper::notice(const std::string& kind, const std::string& detail) {
  {
    const std::lock_guard lock(mutex_);
    notices_.push_back({os_.now(), kind, detail});
  }
  if (notify_) notify_(kind + ": " + detail);
}

void Housekeeper::plan_in_force(const plan::Plan& plan, Rate source_rate, const std::string& reason) {
  const std::lock_guard lock(mutex_);
  const TimePoint now = os_.now();
  measurements_.plan_in_force(now, plan, source_rate);
  plan_changes_.push_back({now, reason, plan::to_json(plan, app_)});
}

void Housekeeper::write_notices() {
  const std::lock_guard lock(mutex_);
  for (; notices_written_ < notices_.size(); ++notices_written_) writer_->add(notices_[notices_written_]);
  for (; plans_written_ < plan_changes_.size(); ++plans_written_) {
    writer_->add(plan_changes_[plans_written_]);
    plan_changes_[plans_written_].json = {};
  }
}

void Housekeeper::flush() {
  if (!writer_) return;
  write_notices();
  const Status flushed = writer_->flush();
  if (flushed || record_failed_) return;
  record_failed_ = true;
  notice("record-failed", flushed.error().message());
}

bool Housekeeper::all_measured() const {
  const std::lock_guard lock(mutex_);
  return measurements_.all_measured();
}

model::CostTable Housekeeper::costs(Millis unmeasured) const {
  const std::lock_guard lock(mutex_);
  return measurements_.costs(unmeasured);
}

model::CostTable Housekeeper::typical_costs(Millis unmeasured) const {
  const std::lock_guard lock(mutex_);
  return measurements_.typical_costs(unmeasured);
}

void Housekeeper::fill(Snapshot& snapshot, std::optional<double> hand_set_hz) const {
  const std::lock_guard lock(mutex_);
  measurements_.fill(snapshot, os_.now(), hand_set_hz);
  snapshot.plans = plan_changes_.size();
  for (const record::Notice& notice : notices_) snapshot.notices.push_back(notice.kind + ": " + notice.detail);
}

}  // namespace ctn::runtime
