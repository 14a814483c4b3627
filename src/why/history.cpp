#include "why/history.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "plan/json.h"
#include "why/durations.h"

namespace ctn::why {
namespace {

template <class Spans>
void sort_by_begin(Spans& spans) {
  std::stable_sort(spans.begin(), spans.end(), [](const auto& a, const auto& b) { return a.begin < b.begin; });
}

bool overlap(const Span& a, const Span& b) { return a.begin < b.end && b.begin < a.end; }

}  // namespace

History::History(graph::App app, std::size_t cpus)
    : app_(std::move(app)),
      cpus_(cpus),
      runs_(app_.graph.nodes().size()),
      triggers_(app_.graph.subchains().size()),
      active_(app_.graph.subchains().size()),
      thefts_(app_.graph.subchains().size()),
      clocks_(app_.graph.nodes().size()),
      usual_cpu_(app_.graph.nodes().size()) {}

void History::add(const record::Run& run) {
  knows_cpus_ = knows_cpus_ || run.on_cpu >= 0;
  runs_[run.node.index()].push_back({.number = run.number,
                                     .begin = run.begin,
                                     .end = run.end,
                                     .cpu = run.cpu,
                                     .wait = run.wait,
                                     .core = run.on_cpu >= 0 ? run.on_cpu : kUnknownCore,
                                     .emitted = run.emitted});
}

void History::add(const record::Trigger& trigger) {
  others_sorted_ = false;
  triggers_[trigger.subchain.index()].push_back({std::min(trigger.due, trigger.sent), trigger.sent});
}

void History::add(const record::SlotUse& slot) {
  others_sorted_ = false;
  if (slot.begin < slot.end) active_[slot.subchain.index()].push_back({slot.begin, slot.end});
}

void History::add(const record::Steal& steal) {
  others_sorted_ = false;
  if (steal.begin >= steal.end) return;
  active_[steal.thief.index()].push_back({steal.begin, steal.end});
  thefts_[steal.victim.index()].push_back({{steal.begin, steal.end}, steal.thief});
}

void History::add(const record::ClockReading& reading) {
  clocks_[reading.node.index()].push_back({reading.at, reading.ticks});
}

Status History::add(const record::PlanChange& change) {
  auto plan = plan::from_json(change.json, app_, fmt::format("plan {} of the record", plans_.size() + 1));
  if (!plan) return plan.error();
  for (const plan::SubchainPlan& subchain : plan->subchains) {
    for (const int core : subchain.cores) {
      if (core >= 0 && static_cast<std::size_t>(core) < plan->cores.size()) continue;
      return Error::caller(fmt::format("plan {} of the record has a subchain on core {}, and {} cores",
                                       plans_.size() + 1, core, plan->cores.size()),
                           "the record is damaged; take a copy that is not");
    }
  }
  others_sorted_ = false;
  plans_.push_back({change.at, std::move(*plan)});
  return Done{};
}

// For records that do not say on which CPU runs ended.
void History::place_by_plans() {
  for (std::size_t node = 0; node < runs_.size(); ++node) {
    const std::optional<SubchainId> subchain = app_.graph.nodes()[node].subchain;
    for (RunTimes& run : runs_[node]) {
      if (cpus_ == 1) {
        run.core = 0;
      } else if (const plan::Plan* plan = subchain ? plan_at(run.begin) : nullptr) {
        const std::vector<int>& cores = plan->subchains[subchain->index()].cores;
        if (cores.size() == 1) run.core = cores.front();
      }
    }
  }
}

void History::sort() {
  if (!others_sorted_) sort_others();
  for (auto& runs : runs_) {
    std::stable_sort(runs.begin(), runs.end(),
                     [](const RunTimes& a, const RunTimes& b) { return a.number < b.number; });
  }
  if (!knows_cpus_) place_by_plans();
  busy_.clear();
  for (std::size_t node = 0; node < runs_.size(); ++node) {
    for (std::size_t index = 0; index < runs_[node].size(); ++index) {
      const RunTimes& run = runs_[node][index];
      busy_[run.core].push_back({run.begin, run.end, run.end, {NodeId(node), index}});
    }
  }
  for (auto& [core, busy] : busy_) {
    sort_by_begin(busy);
    TimePoint latest = TimePoint::min();
    for (Busy& each : busy) each.latest = latest = std::max(latest, each.end);
  }
  if (!knows_usual_) find_usual();
}

void History::sort_others() {
  std::stable_sort(plans_.begin(), plans_.end(), [](const InForce& a, const InForce& b) { return a.at < b.at; });
  for (auto& sent : triggers_) {
    std::stable_sort(sent.begin(), sent.end(),
                     [](const SentTrigger& a, const SentTrigger& b) { return a.sent < b.sent; });
  }
  for (auto& spans : active_) sort_by_begin(spans);
  for (auto& thefts : thefts_) {
    std::stable_sort(thefts.begin(), thefts.end(),
                     [](const Theft& a, const Theft& b) { return a.time.begin < b.time.begin; });
  }
  others_sorted_ = true;
}

void History::find_usual() {
  for (std::size_t node = 0; node < runs_.size(); ++node) {
    if (runs_[node].empty()) continue;
    Durations cpu;
    for (const RunTimes& run : runs_[node]) cpu.add(run.cpu);
    usual_cpu_[node] = cpu.of_rank((cpu.size() - 1) / 2);
  }
}

void History::expect(const std::vector<Nanos>& usual_cpu, bool knows_cpus) {
  usual_cpu_ = usual_cpu;
  knows_usual_ = true;
  knows_cpus_ = knows_cpus;
}

std::vector<std::size_t> History::forget_before(TimePoint time) {
  std::vector<std::size_t> forgotten(runs_.size());
  for (std::size_t node = 0; node < runs_.size(); ++node) {
    std::vector<RunTimes>& runs = runs_[node];
    std::size_t kept = 0;  // the first one after the gap
    std::optional<std::size_t> emitted;
    for (std::size_t index = 0; index < runs.size() && runs[index].end < time; ++index) {
      kept = index;
      if (runs[index].emitted) emitted = index;
    }
    kept = std::min(kept, emitted.value_or(kept));
    if (kept < 2) continue;
    forgotten[node] = kept - 1;
    runs.erase(runs.begin() + 1, runs.begin() + static_cast<std::ptrdiff_t>(kept));
  }
  busy_.clear();
  return forgotten;
}

std::size_t History::size() const {
  std::size_t size = 0;
  for (const std::vector<RunTimes>& runs : runs_) size += runs.size();
  return size;
}

std::optional<RunRef> History::find(NodeId node, std::uint64_t number) const {
  const std::vector<RunTimes>& runs = runs_[node.index()];
  const auto found =
      std::partition_point(runs.begin(), runs.end(), [&](const RunTimes& run) { return run.number < number; });
  if (found == runs.end() || found->number != number) return std::nullopt;
  return RunRef{node, static_cast<std::size_t>(found - runs.begin())};
}

std::optional<RunRef> History::last_ended(NodeId node, TimePoint by, bool emitted) const {
  const std::vector<RunTimes>& runs = runs_[node.index()];
  auto after = std::partition_point(runs.begin(), runs.end(), [&](const RunTimes& run) { return run.end <= by; });
  while (after != runs.begin()) {
    --after;
    if (!emitted || after->emitted) return RunRef{node, static_cast<std::size_t>(after - runs.begin())};
  }
  return std::nullopt;
}

std::optional<TimePoint> History::last_end(SubchainId subchain, TimePoint after, TimePoint by) const {
  std::optional<TimePoint> last;
  for (const NodeId node : app_.graph.subchain(subchain).nodes) {
    const std::optional<RunRef> ended = last_ended(node, by, false);
    if (ended && run(*ended).end > after) last = std::max(last.value_or(run(*ended).end), run(*ended).end);
  }
  return last;
}

const SentTrigger* History::last_sent(SubchainId subchain, TimePoint by) const {
  const std::vector<SentTrigger>& sent = triggers_[subchain.index()];
  const auto after =
      std::partition_point(sent.begin(), sent.end(), [&](const SentTrigger& one) { return one.sent <= by; });
  return after == sent.begin() ? nullptr : &*(after - 1);
}

const plan::Plan* History::plan_at(TimePoint time) const {
  const auto after =
      std::partition_point(plans_.begin(), plans_.end(), [&](const InForce& plan) { return plan.at <= time; });
  return after == plans_.begin() ? nullptr : &(after - 1)->plan;
}

std::optional<TimePoint> History::plan_changed(TimePoint after, TimePoint before) const {
  const auto end =
      std::partition_point(plans_.begin(), plans_.end(), [&](const InForce& plan) { return plan.at < before; });
  if (end - plans_.begin() < 2 || (end - 1)->at <= after) return std::nullopt;  // the first one replaced none
  return (end - 1)->at;
}

bool History::took_turns(SubchainId subchain, TimePoint time) const {
  const plan::Plan* plan = plan_at(time);
  if (plan == nullptr || plan->subchains[subchain.index()].cores.empty()) return false;
  const auto core = static_cast<std::size_t>(plan->subchains[subchain.index()].cores.front());
  return core < plan->cores.size() && plan->cores[core].form == plan::Form::kFrames && !plan->cores[core].slots.empty();
}

std::optional<Ticks> History::ticks(NodeId node, TimePoint time) const {
  const std::vector<Reading>& known = clocks_[node.index()];
  const auto after =
      std::partition_point(known.begin(), known.end(), [&](const Reading& reading) { return reading.at <= time; });
  if (after == known.begin()) return std::nullopt;
  return (after - 1)->ticks;
}

std::vector<Holder> History::holders(int core, Span span, NodeId but) const {
  struct Candidate {
    Span time;
    NodeId node;
    bool sure;
  };
  std::vector<Candidate> candidates;
  each_overlapping(core, span, but, [&](const RunRef& ref, bool sure) {
    candidates.push_back({{run(ref).begin, run(ref).end}, ref.node, sure});
  });
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.time.begin < b.time.begin; });
  std::vector<Holder> held;
  std::vector<Candidate> going_on;  // in order of their begins
  std::size_t next = 0;
  for (TimePoint now = span.begin; now < span.end;) {
    std::erase_if(going_on, [&](const Candidate& one) { return one.time.end <= now; });
    for (; next < candidates.size() && candidates[next].time.begin <= now; ++next) {
      if (candidates[next].time.end > now) going_on.push_back(candidates[next]);
    }
    TimePoint until = next < candidates.size() ? std::min(span.end, candidates[next].time.begin) : span.end;
    for (const Candidate& one : going_on) until = std::min(until, one.time.end);
    Holder holder{{now, until}};
    const auto sure = std::find_if(going_on.rbegin(), going_on.rend(), [](const Candidate& one) { return one.sure; });
    if (sure != going_on.rend()) {
      holder.node = sure->node;
    } else if (going_on.size() == 1) {
      holder.node = going_on.front().node;
    }
    holder.unsure = !holder.node && !going_on.empty();
    if (!held.empty() && held.back().node == holder.node && held.back().unsure == holder.unsure) {
      held.back().time.end = until;
    } else {
      held.push_back(holder);
    }
    now = until;
  }
  return held;
}

std::vector<Span> History::active(SubchainId subchain, Span span) const {
  const std::vector<Span>& all = active_[subchain.index()];
  // They are on one core, so they hardly overlap. The one before the first that begins later may reach into the span.
  auto each = std::partition_point(all.begin(), all.end(), [&](const Span& one) { return one.begin < span.begin; });
  for (int back = 0; back < 2 && each != all.begin(); ++back) --each;
  std::vector<Span> found;
  for (; each != all.end() && each->begin < span.end; ++each) {
    if (overlap(*each, span)) found.push_back({std::max(each->begin, span.begin), std::min(each->end, span.end)});
  }
  return found;
}

std::vector<History::Theft> History::thefts(SubchainId victim, Span span) const {
  const std::vector<Theft>& all = thefts_[victim.index()];
  auto each =
      std::partition_point(all.begin(), all.end(), [&](const Theft& one) { return one.time.begin < span.begin; });
  if (each != all.begin()) --each;
  std::vector<Theft> found;
  for (; each != all.end() && each->time.begin < span.end; ++each) {
    if (overlap(each->time, span)) found.push_back(*each);
  }
  return found;
}

}  // namespace ctn::why
