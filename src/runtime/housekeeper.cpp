#include "runtime/housekeeper.h"

#include <fmt/format.h>

#include <utility>

#include "plan/json.h"

namespace ctn::runtime {
namespace {

// Short enough that rings of 4096 reports hold what even a 10 kHz node says in between.
constexpr Nanos kTick = std::chrono::milliseconds{50};
constexpr Nanos kFlushEvery = std::chrono::seconds{1};
// For the snapshot; the record has all.
constexpr std::size_t kKeptNotices = 1000;

}  // namespace

Housekeeper::Housekeeper(const graph::App& app, os::Os& os, Links& links, Dropped dropped, TimePoint warm_from,
                         std::unique_ptr<record::Writer> writer, Notify notify, policy::CpuKinds kinds)
    : app_(app),
      os_(os),
      links_(links),
      dropped_(std::move(dropped)),
      warm_from_(warm_from),
      writer_(std::move(writer)),
      notify_(std::move(notify)),
      measurements_(app, warm_from, std::move(kinds)),
      check_(app.graph),
      gathered_(app.graph.nodes().size()),
      hung_runs_(app.graph) {}

void Housekeeper::run(const Controllers& controllers, const Errand& errand) {
  TimePoint next_flush = os_.now() + kFlushEvery;
  while (!stopping_.load(std::memory_order_acquire)) {
    const std::uint32_t seen = attention_.load(std::memory_order_acquire);
    if (stopping_.load(std::memory_order_acquire)) break;
    os_.wait(attention_, seen, os_.now() + kTick);
    gather(controllers);
    const TimePoint now = os_.now();
    if (errand) errand(now);
    const bool time_to_flush = now >= next_flush;
    if (time_to_flush || starvation_.waits()) judge_starvation();
    if (!time_to_flush) continue;
    next_flush = now + kFlushEvery;
    note_losses(controllers);
    note_floods(controllers);
    flush();
  }
}

void Housekeeper::stop() {
  stopping_.store(true, std::memory_order_release);
  nudge();
}

void Housekeeper::nudge() {
  attention_.fetch_add(1, std::memory_order_release);
  os_.wake(attention_);
}

Status Housekeeper::finish(const Controllers& controllers) {
  gather(controllers);
  note_losses(controllers);
  judge_starvation();
  if (!writer_) return Done{};
  write_notices();
  writer_->set_totals(totals_);
  Status closed = writer_->close(os_.now(), os_.host_facts());
  writer_.reset();
  return closed;
}

void Housekeeper::gather(const Controllers& controllers) {
  const std::span<const NodeId> order = app_.graph.topological_order();
  for (std::size_t position = order.size(); position-- > 0;) {
    gathered_[position].clear();
    NodeLink* link = links_[order[position].index()].get();
    if (link == nullptr) continue;
    link->drain([&](record::Run run) { gathered_[position].push_back(std::move(run)); });
  }
  for (const auto& controller : controllers) controller->drain(*this);
  const std::lock_guard lock(mutex_);
  const TimePoint now = os_.now();
  for (std::vector<record::Run>& runs : gathered_) {
    for (record::Run& run : runs) {
      if (!check_.believe(run, now)) continue;
      const std::optional<record::CostChange> change = measurements_.add(run, hung_runs_.counts(run));
      if (writer_) writer_->add(run);
      if (!change) continue;
      cost_changed_ = true;
      ++cost_changes_;
      if (writer_) writer_->add(*change);
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

void Housekeeper::hang_changed(SubchainId subchain, bool began, TimePoint at) {
  if (began) hung_runs_.began(subchain, at);
  const record::Notice of_hang = policy::notice_of_hang(app_.graph.subchain(subchain).name, began, at);
  notice(of_hang.kind, of_hang.detail);
}

void Housekeeper::note_floods(const Controllers& controllers) {
  std::uint64_t floods = 0;
  for (const auto& controller : controllers) floods += controller->floods();
  if (std::exchange(floods_noted_, floods) == floods) return;
  notice("flood",
         fmt::format("dispatchers were woken more often than runs can end, and did not listen {} times; one of "
                     "the app's programs misbehaves",
                     floods));
}

void Housekeeper::woke_late(int cpu, TimePoint due, TimePoint woke) { starvation_.woke_late(cpu, due, woke); }

void Housekeeper::judge_starvation() {
  starvation_.stolen_until_now(os_.stolen_time());
  {
    const std::lock_guard lock(mutex_);
    totals_.starved = starvation_.times();
    totals_.starved_for = starvation_.total();
  }
  if (const std::optional<std::string> news = starvation_.news(os_.now())) notice("starved", *news);
}

bool Housekeeper::take_cost_change() { return std::exchange(cost_changed_, false); }

void Housekeeper::power_changed(const driver::PowerChange& change) {
  {
    const std::lock_guard lock(mutex_);
    for (std::size_t kind = 0; kind < change.factors.size(); ++kind) {
      const std::optional<double> factor = change.factors[kind];
      factor ? measurements_.measured().rescale(kind, *factor) : measurements_.measured().doubt(kind);
    }
  }
  notice("power", change.what);
}

void Housekeeper::planned(const policy::PlanningBudget& budget) {
  const std::lock_guard lock(mutex_);
  totals_.plans_made = budget.plans();
  totals_.planning_cpu = budget.spent();
}

void Housekeeper::note_losses(const Controllers& controllers) {
  std::uint64_t losses = 0;
  for (const auto& link : links_) {
    if (link) losses += link->lost_reports() + link->broken_rings();
  }
  for (const auto& controller : controllers) losses += controller->lost_reports();
  {
    const std::lock_guard lock(mutex_);
    losses += check_.disbelieved();
  }
  std::string edges;
  for (const auto& [edge, count] : dropped_ ? dropped_() : std::vector<std::pair<std::string, std::uint64_t>>{}) {
    losses += count;
    edges += fmt::format("; {} values on {}", count, edge);
  }
  if (losses == losses_noted_) return;
  losses_noted_ = losses;
  notice("lost-reports",
         fmt::format("{} reports or values were lost: their reader did not keep up, or they could not be true{}",
                     losses, edges));
}

void Housekeeper::notice(const std::string& kind, const std::string& detail) {
  {
    const std::lock_guard lock(mutex_);
    notices_.push_back({os_.now(), kind, detail});
    if (writer_) unwritten_notices_.push_back(notices_.back());
    if (notices_.size() > kKeptNotices) notices_.pop_front();
  }
  if (notify_) notify_(kind + ": " + detail);
}

void Housekeeper::plan_in_force(const plan::Plan& plan, Rate source_rate, const std::string& reason) {
  const std::lock_guard lock(mutex_);
  const TimePoint now = os_.now();
  measurements_.plan_in_force(now, plan, source_rate);
  ++plans_;
  if (writer_) unwritten_plans_.push_back({now, reason, plan::to_json(plan, app_)});
}

void Housekeeper::write_notices() {
  const std::lock_guard lock(mutex_);
  for (const record::Notice& notice : unwritten_notices_) writer_->add(notice);
  for (const record::PlanChange& plan : unwritten_plans_) writer_->add(plan);
  unwritten_notices_.clear();
  unwritten_plans_.clear();
}

void Housekeeper::flush() {
  if (!writer_) return;
  write_notices();
  const Status flushed = writer_->flush();
  if (flushed || record_failed_) return;
  record_failed_ = true;
  notice("record-failed", flushed.error().message());
}

void Housekeeper::begins_anew(NodeId node) {
  const std::lock_guard lock(mutex_);
  check_.begin_anew(node);
}

bool Housekeeper::warmed_up() const { return os_.now() >= warm_from_; }

bool Housekeeper::all_measured() const {
  const std::lock_guard lock(mutex_);
  return measurements_.measured().all_measured();
}

model::CostTable Housekeeper::costs(Millis unmeasured) const {
  const std::lock_guard lock(mutex_);
  return measurements_.measured().costs(unmeasured);
}

model::CostTable Housekeeper::typical_costs(Millis unmeasured) const {
  const std::lock_guard lock(mutex_);
  return measurements_.measured().typical_costs(unmeasured);
}

void Housekeeper::fill(Snapshot& snapshot, std::optional<double> hand_set_hz) const {
  const std::lock_guard lock(mutex_);
  measurements_.fill(snapshot, os_.now(), hand_set_hz);
  snapshot.plans = plans_;
  snapshot.cost_changes = cost_changes_;
  snapshot.planning_ms = to_millis(totals_.planning_cpu).count();
  snapshot.starved = totals_.starved;
  snapshot.starved_ms = to_millis(totals_.starved_for).count();
  for (const record::Notice& notice : notices_) snapshot.notices.push_back(notice.kind + ": " + notice.detail);
}

}  // namespace ctn::runtime
