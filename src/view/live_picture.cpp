// The second half of LiveView: from the samples that it keeps to figures.
#include <algorithm>
#include <chrono>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/statistics.h"
#include "os/cpu_set.h"
#include "view/live_view.h"
#include "why/parts.h"

namespace ctn::view {
namespace {

constexpr std::size_t kDistributionParts = 24;
constexpr double kAbsentAfterPeriods = 10.0;
constexpr double kAbsentAfterMs = 1000.0;  // and at least

double in_ms(Nanos duration) { return to_millis(duration).count(); }

// How much of the time between two instants lies in the window.
template <class Window>
double part_within(TimePoint begin, TimePoint end, const Window& window) {
  if (end <= begin) return window.has(end) ? 1.0 : 0.0;
  const Nanos within = std::min(end, window.to) - std::max(begin, window.from);
  return within <= Nanos{0} ? 0.0 : in_seconds(within) / in_seconds(end - begin);
}

Distribution distribution_of(const std::vector<double>& samples) {
  if (samples.empty()) return {};
  const auto [min, largest] = std::minmax_element(samples.begin(), samples.end());
  Distribution result{*min, (*largest - *min) / kDistributionParts, std::vector<std::uint64_t>(kDistributionParts)};
  for (const double sample : samples) {
    const double part = result.width_ms > 0.0 ? (sample - result.from_ms) / result.width_ms : 0.0;
    ++result.counts[std::min(static_cast<std::size_t>(part), kDistributionParts - 1)];
  }
  return result;
}

// `expected_ms`: the period that is expected, if any is. `up_ms`: since the start.
template <class Shown>
bool is_absent(const Shown& shown, std::optional<double> expected_ms, double up_ms) {
  const double period_ms = std::max(expected_ms.value_or(0.0), shown.period_ms.mean);
  return shown.silent_ms.value_or(up_ms) > std::max(kAbsentAfterPeriods * period_ms, kAbsentAfterMs);
}

void tell_absent(Picture& picture) {
  const double up_ms = picture.up_s * 1000.0;
  for (Subchain& subchain : picture.subchains) {
    subchain.absent = is_absent(subchain, subchain.expected_period_ms, up_ms);
  }
  for (Node& node : picture.nodes) {
    node.absent = is_absent(node, node.expected_hz ? std::optional(1000.0 / *node.expected_hz) : std::nullopt, up_ms);
  }
}

Sharing sharing_of(const plan::CorePlan& core) {
  if (core.form == plan::Form::kPriorities) return Sharing::kPriorities;
  return core.slots.empty() ? Sharing::kOwned : Sharing::kFrames;
}

CoreUse& use_of(Core& core, const std::string& name) {
  const auto found =
      std::find_if(core.uses.begin(), core.uses.end(), [&](const CoreUse& use) { return use.name == name; });
  return found != core.uses.end()
             ? *found
             : core.uses.emplace_back(CoreUse{.name = name, .planned = false, .cores = 0.0, .slots = {}});
}

std::vector<LateBy> by_count(const LateCauses::Counts& counts) {
  std::vector<LateBy> result;
  for (std::size_t kind = 0; kind < counts.size(); ++kind) {
    if (counts[kind] > 0) result.push_back({why::to_string(static_cast<why::CauseKind>(kind)), counts[kind]});
  }
  std::stable_sort(result.begin(), result.end(), [](const LateBy& a, const LateBy& b) { return a.count > b.count; });
  return result;
}

}  // namespace

Picture LiveView::picture(TimePoint now, const Life& life) const {
  Picture picture;
  const TimePoint alive = std::min(life.seen_alive, now);
  picture.app = app_.name;
  picture.scheduler = header_.scheduler;
  picture.note = header_.note;
  picture.real_time = header_.real_time;
  picture.cpus = header_.cpus.cpus();
  picture.silent_ms = in_ms(now - alive);
  if (life.over) {
    picture.state = State::kEnded;
  } else if (now - alive > kStalledAfter) {
    picture.state = life.gone ? State::kKilled : State::kStalled;
  }
  const TimePoint to = picture.state == State::kRunning ? now : std::min(now, std::max(alive, newest_));
  const Window window{std::max(to - kWindow, std::min(first_seen_.value_or(to), to)), to};
  picture.up_s = since_start(to);
  picture.window_s = window.seconds();
  picture.lost = lost_;
  if (plan_) picture.plan = plan_in_force();
  for (std::size_t index = 0; index < chains_.size(); ++index) {
    picture.chains.push_back(picture_of(chains_[index], index, window));
  }
  for (std::size_t index = 0; index < subchains_.size(); ++index) {
    picture.subchains.push_back(picture_of(SubchainId(index), window));
  }
  for (std::size_t index = 0; index < nodes_.size(); ++index) {
    if (!app_.graph.nodes()[index].external) picture.nodes.push_back(picture_of(NodeId(index), window));
  }
  if (picture.state == State::kRunning) tell_absent(picture);
  picture.cores = cores(window);
  picture.objective = objective(picture);
  picture.events.assign(events_.begin(), events_.end());
  picture.plans_made = totals_.plans_made;
  picture.planning_ms = in_ms(totals_.planning_cpu);
  picture.starved = totals_.starved;
  picture.starved_ms = in_ms(totals_.starved_for);
  return picture;
}

PlanInForce LiveView::plan_in_force() const {
  PlanInForce plan;
  plan.at_s = since_start(plan_at_);
  plan.reason = plan_reason_;
  plan.planner = plan_->planner;
  plan.for_typical = plan_->for_typical;
  plan.objective = plan_->expected ? plan_->expected->objective : plan_->objective;
  plan.relax_factor = plan_->relax_factor;
  for (const plan::RelaxedBound& bound : plan_->relaxed) {
    plan.relaxed.push_back({bound.key, bound.asked.count(), bound.planned.count()});
  }
  for (const plan::AssumedCost& assumed : plan_->assumed) {
    plan.assumed.push_back({app_.graph.node(assumed.node).name, assumed.cost.count()});
  }
  return plan;
}

// Null: no plan that is remembered was in force then.
const LiveView::Promises* LiveView::promised_at(TimePoint at) const {
  const auto later =
      std::find_if(promises_.begin(), promises_.end(), [&](const Promises& promises) { return promises.at > at; });
  return later == promises_.begin() ? nullptr : &*(later - 1);
}

Chain LiveView::picture_of(const KeptChain& chain, std::size_t index, const Window& window) const {
  Chain shown;
  const graph::Term& term = app_.objective[chain.term];
  shown.path = app_.graph.path_name(term.path);
  for (const NodeId node : term.path) shown.nodes.push_back(app_.graph.node(node).name);
  shown.weight = term.weight;
  if (term.max) shown.bound_ms = in_ms(*term.max);
  if (index < predicted_.size() && predicted_[index]) {
    shown.expected_ms = predicted_[index]->response_ms;
    shown.promised_ms = predicted_[index]->promised_response_ms;
  }
  if (chain.newest) shown.newest_ms = in_ms(*chain.newest);
  std::vector<double> responses;
  std::vector<double> latencies;
  std::vector<double> periods;
  for (const Response& sample : chain.responses) {
    if (!window.has(sample.end)) continue;
    latencies.push_back(in_ms(sample.latency));
    if (sample.period) periods.push_back(in_ms(*sample.period));
    if (!sample.response) continue;
    responses.push_back(in_ms(*sample.response));
    shown.over_bound += term.max && *sample.response > *term.max ? 1U : 0U;
    const Promises* const promises = promised_at(sample.begin);
    if (promises == nullptr || !promises->responses[index]) continue;
    shown.over_promise += to_millis(*sample.response) > *promises->responses[index] ? 1U : 0U;
  }
  LateCauses::Counts late{};
  for (const LateCauses::Told& told : late_.told(index)) {
    if (window.has(told.end)) ++late[static_cast<std::size_t>(told.cause)];
  }
  shown.late_by = by_count(late);
  shown.late_by_in_all = by_count(late_.counts(index));
  shown.distribution = distribution_of(responses);
  shown.response_ms = summarize_quickly(std::move(responses));
  shown.latency_ms = summarize_quickly(std::move(latencies));
  shown.period_ms = summarize_quickly(std::move(periods));
  const std::int64_t newest = window.to.time_since_epoch() / kHistoryStep;
  const auto steps = static_cast<std::int64_t>(chain.worst.size());
  for (std::int64_t step = newest - steps + 1; step <= newest; ++step) {
    const Worst* const worst = step < 0 ? nullptr : &chain.worst[static_cast<std::size_t>(step) % chain.worst.size()];
    const bool any = worst != nullptr && worst->step == step;
    shown.worst_ms.push_back(any ? std::optional(in_ms(worst->response)) : std::nullopt);
  }
  return shown;
}

Subchain LiveView::picture_of(SubchainId id, const Window& window) const {
  Subchain shown;
  const graph::Subchain& subchain = app_.graph.subchain(id);
  const KeptSubchain& kept = subchains_[id.index()];
  shown.name = subchain.name;
  shown.weight = app_.weight_of(id);
  std::optional<TimePoint> last_end;
  for (const NodeId node : subchain.nodes) {
    shown.nodes.push_back(app_.graph.node(node).name);
    last_end = std::max(last_end, nodes_[node.index()].last_end);
  }
  if (last_end) shown.silent_ms = std::max(in_ms(window.to - *last_end), 0.0);
  if (plan_) {
    const plan::SubchainPlan& planned = plan_->subchains[id.index()];
    const plan::Member* const member = plan::member_of(*plan_, id);
    shown.cores = planned.cores;
    shown.sharing = sharing_of(plan_->cores[static_cast<std::size_t>(planned.cores.front())]);
    if (member != nullptr) shown.priority = member->priority;
    if (shown.sharing == Sharing::kFrames) shown.share = planned.share;
    shown.expected_period_ms = plan::usual_timing(*plan_, id).period.count();
    shown.promised_period_ms = planned.period.count();
    shown.promised_execution_ms = planned.execution.count();
    if (member != nullptr) {
      shown.budget_ms = member->budget.count();
    } else if (planned.share > 0.0) {
      shown.budget_ms = planned.slice.count() / planned.share;
    }
  }
  std::vector<double> periods;
  for (const RunSample& run : nodes_[subchain.tail().index()].runs) {
    if (window.has(run.end) && run.period) periods.push_back(in_ms(*run.period));
  }
  std::vector<double> used;
  std::vector<double> executions;
  for (const Execution& execution : kept.executions) {
    if (!window.has(execution.end)) continue;
    ++shown.runs;
    used.push_back(in_ms(execution.cpu));
    executions.push_back(in_ms(execution.end - execution.begin));
    const Promises* const promises = promised_at(execution.begin);
    if (promises == nullptr) continue;
    shown.late += executions.back() > promises->executions[id.index()].count() ? 1U : 0U;
  }
  std::vector<double> late;
  for (const TriggerSample& trigger : kept.triggers) {
    if (window.has(trigger.end)) late.push_back(in_ms(trigger.late));
  }
  for (const Execution& overrun : kept.overruns) shown.overruns += window.has(overrun.end) ? 1U : 0U;
  for (const record::Steal& steal : steals_) {
    if (!window.has(steal.end)) continue;
    const double length = in_ms(steal.end - steal.begin);
    if (steal.thief == id) {
      ++shown.stole;
      shown.stole_ms += length;
    }
    if (steal.victim == id) {
      ++shown.stolen;
      shown.stolen_ms += length;
    }
  }
  shown.period_ms = summarize_quickly(std::move(periods));
  shown.used_ms = summarize_quickly(std::move(used));
  shown.execution_ms = summarize_quickly(std::move(executions));
  shown.trigger_late_ms = summarize_quickly(std::move(late));
  return shown;
}

Node LiveView::picture_of(NodeId id, const Window& window) const {
  Node shown;
  const graph::Node& node = app_.graph.node(id);
  const KeptNode& kept = nodes_[id.index()];
  shown.name = node.name;
  if (node.subchain) shown.subchain = node.subchain->index();
  for (const graph::Term& term : app_.objective) {
    if (term.metric == graph::Metric::kPeriod && term.path.front() == id) {
      shown.weight = shown.weight.value_or(0.0) + term.weight;
    }
  }
  if (plan_ && node.subchain) {
    const Millis period = plan::usual_timing(*plan_, *node.subchain).period;
    if (period > Millis{0}) shown.expected_hz = Rate::every(period).hertz();
  }
  std::vector<double> periods;
  std::vector<double> costs;
  std::vector<double> waits;
  const bool waited = std::any_of(kept.runs.begin(), kept.runs.end(),
                                  [&](const RunSample& run) { return window.has(run.end) && run.wait > Nanos{0}; });
  double cpu = 0.0;
  for (const RunSample& run : kept.runs) {
    cpu += in_seconds(run.cpu) * part_within(run.begin, run.end, window);
    if (!window.has(run.end)) continue;
    if (run.period) periods.push_back(in_ms(*run.period));
    costs.push_back(in_ms(run.cpu));
    if (waited) waits.push_back(in_ms(run.wait));
  }
  shown.runs = costs.size();
  if (window.seconds() > 0.0) {
    shown.rate_hz = static_cast<double>(shown.runs) / window.seconds();
    shown.cores = cpu / window.seconds();
  }
  shown.period_ms = summarize_quickly(std::move(periods));
  shown.compute_ms = summarize_quickly(std::move(costs));
  shown.wait_ms = summarize_quickly(std::move(waits));
  if (kept.last_end) shown.silent_ms = std::max(in_ms(window.to - *kept.last_end), 0.0);
  return shown;
}

// Core k of a plan is the k-th of the CPUs in use. These are all that the app was started with, unless some were taken
// away since; then it is the CPU on which most runs of the core's subchains ended since the plan came into force.
std::optional<int> LiveView::cpu_of(int core) const {
  const std::vector<int>& cpus = header_.cpus.cpus();
  if (plan_->cores.size() == cpus.size()) return cpus[static_cast<std::size_t>(core)];
  std::map<int, int> ended;
  for (std::size_t index = 0; index < plan_->subchains.size(); ++index) {
    const std::vector<int>& cores = plan_->subchains[index].cores;
    if (cores.size() != 1 || cores.front() != core) continue;
    for (const NodeId node : app_.graph.subchain(SubchainId(index)).nodes) {
      for (const RunSample& run : nodes_[node.index()].runs) {
        if (run.begin >= plan_at_ && run.on_cpu >= 0) ++ended[run.on_cpu];
      }
    }
  }
  const auto max =
      std::max_element(ended.begin(), ended.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  return max == ended.end() ? std::nullopt : std::optional(max->first);
}

std::vector<Core> LiveView::planned_cores() const {
  std::vector<Core> result;
  if (!plan_) return result;
  for (std::size_t number = 0; number < plan_->cores.size(); ++number) {
    const auto core = static_cast<int>(number);
    const plan::CorePlan& planned = plan_->cores[number];
    Core& shown = result.emplace_back();
    shown.core = core;
    shown.cpu = cpu_of(core);
    if (planned.form == plan::Form::kFrames && !planned.slots.empty()) shown.frame_ms = planned.frame.count();
    const auto has = [&](SubchainId id) { shown.uses.push_back({app_.graph.subchain(id).name, true, 0.0, {}}); };
    for (const plan::Slot& slot : planned.slots) has(slot.subchain);
    for (const plan::Member& member : planned.members) has(member.subchain);
    for (std::size_t index = 0; shown.uses.empty() && index < plan_->subchains.size(); ++index) {
      const std::vector<int>& cores = plan_->subchains[index].cores;
      if (std::find(cores.begin(), cores.end(), core) != cores.end()) has(SubchainId(index));
    }
    if (!shown.uses.empty()) shown.sharing = sharing_of(planned);
  }
  return result;
}

std::vector<Core> LiveView::cores(const Window& window) const {
  std::vector<Core> result = planned_cores();
  const double seconds = window.seconds();
  const auto at_cpu = [&](int cpu) -> Core& {
    const auto found = std::find_if(result.begin(), result.end(), [&](const Core& core) { return core.cpu == cpu; });
    if (found != result.end()) return *found;
    result.emplace_back().cpu = cpu;
    return result.back();
  };
  for (const int cpu : header_.cpus.cpus()) at_cpu(cpu);
  for (std::size_t index = 0; index < nodes_.size() && seconds > 0.0; ++index) {
    const std::optional<SubchainId> subchain = app_.graph.nodes()[index].subchain;
    const std::string& name = subchain ? app_.graph.subchain(*subchain).name : app_.graph.nodes()[index].name;
    const std::vector<int> owned = plan_ && subchain ? plan_->subchains[subchain->index()].cores : std::vector<int>();
    for (const RunSample& run : nodes_[index].runs) {
      const double used = in_seconds(run.cpu) * part_within(run.begin, run.end, window) / seconds;
      if (used <= 0.0 || run.on_cpu < 0) continue;
      if (owned.size() > 1) {
        // A run may use all of the subchain's cores, wherever it ends.
        for (const int core : owned) {
          use_of(result[static_cast<std::size_t>(core)], name).cores += used / static_cast<double>(owned.size());
        }
      } else {
        use_of(at_cpu(run.on_cpu), name).cores += used;
      }
    }
  }
  for (const record::SlotUse& slot : slots_) {
    if (seconds <= 0.0 || slot.core < 0 || !plan_ || static_cast<std::size_t>(slot.core) >= plan_->cores.size())
      continue;
    Core& core = result[static_cast<std::size_t>(slot.core)];
    if (core.sharing != Sharing::kFrames) continue;  // slots of an earlier plan, which had frames there
    CoreUse& use = use_of(core, app_.graph.subchain(slot.subchain).name);
    use.slots = use.slots.value_or(0.0) +
                in_seconds(slot.end - slot.begin) * part_within(slot.begin, slot.end, window) / seconds;
  }
  for (Core& core : result) {
    for (const CoreUse& use : core.uses) core.busy += use.cores;
  }
  std::stable_sort(result.begin(), result.end(), [](const Core& a, const Core& b) {
    return a.cpu.has_value() != b.cpu.has_value() ? a.cpu.has_value() : a.cpu < b.cpu;
  });
  return result;
}

std::optional<double> LiveView::objective(const Picture& picture) const {
  double sum = 0.0;
  std::size_t chain = 0;
  for (const graph::Term& term : app_.objective) {
    const Summary* measured = nullptr;
    if (term.metric == graph::Metric::kResponseTime) {
      measured = &picture.chains[chain++].response_ms;
    } else {
      const std::string& name = app_.graph.node(term.path.front()).name;
      const auto node = std::find_if(picture.nodes.begin(), picture.nodes.end(),
                                     [&](const Node& shown) { return shown.name == name; });
      if (node != picture.nodes.end()) measured = &node->period_ms;
    }
    if (term.weight == 0.0) continue;
    if (measured == nullptr || measured->count == 0) return std::nullopt;
    sum += term.weight * measured->mean;
  }
  return sum;
}

}  // namespace ctn::view
