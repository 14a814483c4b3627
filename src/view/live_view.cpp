#include "view/live_view.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "plan/json.h"
#include "record/app_changes.h"
#include "record/run_metrics.h"

namespace ctn::view {
namespace {

constexpr std::size_t kRememberedPlans = 64;
// Of each node: as many as the next node's runs may still go back to. On a busy machine many runs are reported at once.
constexpr std::size_t kRememberedRuns = 2048;

template <class Sample>
void keep(std::deque<Sample>& series, Sample sample, TimePoint newest) {
  while (!series.empty() && (series.front().end <= newest - kWindow || series.size() >= kMaxSamples)) {
    series.pop_front();
  }
  series.push_back(std::move(sample));
}

// What plan::from_json() does not check: each subchain has cores, and they are cores of the plan.
bool has_its_cores(const plan::Plan& plan) {
  return std::all_of(plan.subchains.begin(), plan.subchains.end(), [&](const plan::SubchainPlan& subchain) {
    return !subchain.cores.empty() && std::all_of(subchain.cores.begin(), subchain.cores.end(), [&](int core) {
      return core >= 0 && static_cast<std::size_t>(core) < plan.cores.size();
    });
  });
}

std::string text_of(const plan::Plan& plan, const std::string& reason) {
  std::string text =
      fmt::format("{}: objective {:.4g} {}", reason, plan.expected ? plan.expected->objective : plan.objective,
                  plan.expected ? "expected" : "promised");
  if (!plan.relaxed.empty()) text += fmt::format(", bounds relaxed by {:.3g}", plan.relax_factor);
  if (!plan.assumed.empty()) text += fmt::format(", {} costs assumed", plan.assumed.size());
  return text;
}

}  // namespace

const char* to_string(State state) {
  switch (state) {
    case State::kRunning:
      return "running";
    case State::kStalled:
      return "stalled";
    case State::kEnded:
      return "ended";
    case State::kKilled:
      return "killed";
  }
  return "";
}

const char* to_string(Sharing sharing) {
  switch (sharing) {
    case Sharing::kNone:
      return "none";
    case Sharing::kOwned:
      return "owned";
    case Sharing::kFrames:
      return "frames";
    case Sharing::kPriorities:
      return "priorities";
  }
  return "";
}

LiveView::LiveView(graph::App app, const record::Header& header)
    : app_(std::move(app)),
      header_(header),
      nodes_(app_.graph.nodes().size()),
      steps_(app_.graph.nodes().size()),
      subchains_(app_.graph.subchains().size()),
      late_(app_, header.cpus.size()) {
  for (std::size_t node = 0; node < nodes_.size(); ++node) {
    if (app_.graph.nodes()[node].subchain) steps_[node].resize(kRememberedRuns);
  }
  for (std::size_t term = 0; term < app_.objective.size(); ++term) {
    if (app_.objective[term].metric != graph::Metric::kResponseTime) continue;
    chains_.push_back({term, record::ChainTracker(app_.graph, app_.objective[term].path), {}});
  }
}

void LiveView::seen(TimePoint at) {
  if (!first_seen_) first_seen_ = at;
  newest_ = std::max(newest_, at);
}

void LiveView::lost() {
  ++lost_;
  late_.lost(app_);
  first_seen_.reset();
  for (KeptNode& node : nodes_) {
    node.runs.clear();
    node.last_counted.reset();
  }
  for (KeptSubchain& subchain : subchains_) subchain = {};
  for (KeptChain& chain : chains_) {
    chain.tracker = record::ChainTracker(app_.graph, app_.objective[chain.term].path);
    chain.responses.clear();
  }
  slots_.clear();
  steals_.clear();
}

void LiveView::add(const record::Run& run) {
  seen(run.end);
  KeptNode& node = nodes_[run.node.index()];
  RunSample sample{run.begin, run.end, run.cpu, run.wait, {}, run.on_cpu};
  if (record::counts_for_period(run, app_.graph)) {
    if (node.last_counted) sample.period = run.end - *node.last_counted;
    node.last_counted = run.end;
  }
  node.last_end = run.end;
  keep(node.runs, std::move(sample), newest_);
  follow_subchain(run);
  late_.add(run);
  for (std::size_t index = 0; index < chains_.size(); ++index) {
    KeptChain& chain = chains_[index];
    for (const record::ChainSample& found : chain.tracker.add(run)) {
      keep(chain.responses,
           {found.end - found.response.value_or(found.latency), found.end, found.response, found.latency, found.period},
           newest_);
      if (!found.response) continue;
      chain.newest = found.response;
      const TimePoint begin = found.end - *found.response;
      if (is_late(index, begin, *found.response)) late_.late(index, begin, found.end);
      const std::int64_t step = found.end.time_since_epoch() / kHistoryStep;
      Worst& worst = chain.worst[static_cast<std::size_t>(std::max<std::int64_t>(step, 0)) % chain.worst.size()];
      if (worst.step != step) worst = {step, Nanos{0}};
      worst.response = std::max(worst.response, *found.response);
    }
  }
  late_.look(app_);
}

// Whether it exceeds the bound; where there is none, what was promised when the response began.
bool LiveView::is_late(std::size_t chain, TimePoint begin, Nanos response) const {
  if (const std::optional<Nanos>& bound = app_.objective[chains_[chain].term].max) return response > *bound;
  const Promises* const promises = promised_at(begin);
  return promises != nullptr && promises->responses[chain] && to_millis(response) > *promises->responses[chain];
}

void LiveView::follow_subchain(const record::Run& run) {
  const std::optional<SubchainId> id = app_.graph.node(run.node).subchain;
  if (!id) return;
  const std::vector<NodeId>& row = app_.graph.subchain(*id).nodes;
  const auto place = std::find(row.begin(), row.end(), run.node);
  Step step{run.number, run.begin, run.cpu};
  if (place != row.begin()) {
    const NodeId before = *(place - 1);
    const auto taken = std::find_if(run.consumed.begin(), run.consumed.end(),
                                    [&](const record::Consumed& input) { return input.predecessor == before; });
    if (taken == run.consumed.end()) return;
    const Step& from = steps_[before.index()][taken->last % kRememberedRuns];
    if (from.number != taken->last || from.number == 0) return;
    step.begin = from.begin;
    step.cpu += from.cpu;
  }
  steps_[run.node.index()][run.number % kRememberedRuns] = step;
  if (run.node != row.back() && run.emitted) return;
  keep(subchains_[id->index()].executions, {step.begin, run.end, step.cpu}, newest_);
}

void LiveView::add(const record::Trigger& trigger) {
  seen(trigger.sent);
  late_.add(trigger);
  keep(subchains_[trigger.subchain.index()].triggers, {trigger.sent, trigger.sent - trigger.due}, newest_);
}

void LiveView::add(const record::SlotUse& slot) {
  seen(slot.end);
  late_.add(slot);
  keep(slots_, slot, newest_);
}

void LiveView::add(const record::Steal& steal) {
  seen(steal.end);
  late_.add(steal);
  keep(steals_, steal, newest_);
}

void LiveView::add(const record::Overrun& overrun) {
  seen(overrun.at);
  keep(subchains_[overrun.subchain.index()].overruns, {overrun.at, overrun.at, overrun.cpu}, newest_);
}

void LiveView::add(const record::PlanChange& change) {
  if (plan_ && (change.at < plan_at_ || (change.at == plan_at_ && change.json == plan_json_))) return;
  Result<plan::Plan> plan = plan::from_json(change.json, app_, "the plan in force");
  if (!plan || !has_its_cores(*plan)) {
    note(change.at, "plan", change.reason + ": this version of catan cannot read it");
    return;
  }
  late_.add(change);
  plan_ = std::move(*plan);
  plan_json_ = change.json;
  plan_reason_ = change.reason;
  plan_at_ = change.at;
  predicted_ = plan::predictions_of(*plan_, app_).chains;
  Promises promises{change.at, {}, {}};
  for (const std::optional<plan::ChainPrediction>& chain : predicted_) {
    promises.responses.push_back(chain ? std::optional(Millis{chain->promised_response_ms}) : std::nullopt);
  }
  for (const plan::SubchainPlan& subchain : plan_->subchains) promises.executions.push_back(subchain.execution);
  promises_.push_back(std::move(promises));
  if (promises_.size() > kRememberedPlans) promises_.pop_front();
  note(change.at, "plan", text_of(*plan_, change.reason));
}

void LiveView::add(const record::CostChange& change) {
  const std::vector<std::string>& modes = app_.graph.node(change.node).modes;
  note(change.at, "cost-change",
       fmt::format("{}{}: {:.4g} ms -> {:.4g} ms", app_.graph.node(change.node).name,
                   change.mode < modes.size() ? fmt::format(" (mode {})", modes[change.mode]) : "",
                   to_millis(change.before).count(), to_millis(change.after).count()));
}

void LiveView::add(const record::AppChange& change) {
  Result<graph::App> changed = record::app_after(app_, std::array{change});
  if (changed) app_ = std::move(*changed);
}

void LiveView::add(const record::ClockReading& reading) {
  late_.add(reading);
  for (KeptChain& chain : chains_) chain.tracker.set_clock(reading.node, reading.ticks);
}

void LiveView::add(const record::Notice& notice) { note(notice.at, notice.kind, notice.detail); }

void LiveView::note(TimePoint at, std::string kind, std::string detail) {
  Event event{since_start(at), std::move(kind), std::move(detail)};
  if (std::find(events_.begin(), events_.end(), event) != events_.end()) return;
  events_.push_back(std::move(event));
  if (events_.size() > kMaxEvents) events_.pop_front();
}

double LiveView::since_start(TimePoint at) const { return in_seconds(at - header_.started); }

}  // namespace ctn::view
