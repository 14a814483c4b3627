#include "why/walk.h"

#include <algorithm>
#include <utility>

#include "why/run_parts.h"

namespace ctn::why {
namespace {

constexpr int kMaxSteps = 4096;  // runs on the path of one response: a damaged record may lead in circles

}  // namespace

std::vector<Part> Walk::take_apart(const Way& before, const Way& way) {
  parts_.clear();
  walk(way, &before, before.sample.end, way.sample.end);
  walk(before, nullptr, before.sample.begin, before.sample.end);
  return {parts_.rbegin(), parts_.rend()};
}

// `before`: the sample before this one; not null if it is asked what kept this one from coming sooner.
void Walk::walk(const Way& way, const Way* before, TimePoint begin, TimePoint end) {
  cursor_ = end;
  floor_ = begin;
  const RunRef last{chain_.nodes.back(), way.runs.back()};
  emit(history_.run(last).end, PartKind::kWaitingForTick, last.node);
  for (std::size_t stage = chain_.nodes.size(); stage-- > 0;) {
    in_run({chain_.nodes[stage], way.runs[stage]});
    before_run(stage, way, before);
  }
  floor_ = begin;
  emit(begin, PartKind::kUnexplained, chain_.nodes.front());
}

void Walk::emit(TimePoint from, PartKind kind, NodeId node, std::optional<NodeId> by) {
  from = std::max(from, floor_);
  if (from >= cursor_) return;
  if (!parts_.empty() && parts_.back().begin == cursor_ && parts_.back().kind == kind && parts_.back().node == node &&
      parts_.back().by == by) {
    parts_.back().begin = from;
  } else {
    parts_.push_back({kind, from, cursor_, node, by});
  }
  cursor_ = from;
}

void Walk::emit(const std::vector<Delay>& delays, NodeId node) {
  for (auto each = delays.rbegin(); each != delays.rend(); ++each) emit(each->time.begin, each->kind, node, each->by);
}

// --- In a run ---

void Walk::in_run(const RunRef& ref) {
  const std::vector<Part> parts = parts_of_run(history_, ref);
  for (auto part = parts.rbegin(); part != parts.rend(); ++part) emit(part->begin, part->kind, ref.node, part->by);
}

// --- Before a run ---

void Walk::before_run(std::size_t stage, const Way& way, const Way* before) {
  const TimePoint begin = floor_;
  const bool of_source = stage == 0;
  TimePoint since = begin;
  if (!of_source) {
    since = std::max(begin, history_.run({chain_.nodes[stage - 1], way.runs[stage - 1]}).end);
  } else if (chain_.begins_at_clock) {
    since = std::max(begin, way.sample.begin);
  }
  const std::optional<LeftOut> left = left_out(stage, way, before);
  floor_ = left ? std::max(since, left->end) : since;
  explain_begin({chain_.nodes[stage], way.runs[stage]}, of_source);
  if (of_source) {
    floor_ = left ? left->end : begin;
    emit(floor_, PartKind::kWaitingForSample, chain_.nodes.front());
  }
  floor_ = of_source ? begin : since;
  if (left) emit(floor_, PartKind::kNoOutput, left->node);
  floor_ = begin;
}

// The last run that gave no output, but would else have brought what now comes with a later run.
std::optional<Walk::LeftOut> Walk::left_out(std::size_t stage, const Way& way, const Way* before) const {
  if (stage == 0 && before == nullptr) return std::nullopt;
  const graph::Graph& graph = history_.app().graph;
  const std::optional<SubchainId> subchain = graph.node(chain_.nodes[stage]).subchain;
  const TimePoint by = history_.run({chain_.nodes[stage], way.runs[stage]}).begin;
  // Whether run `index` of stage `at` goes back to a sample that had not reached the end yet.
  const auto brings_news = [&](std::size_t at, std::size_t index) {
    for (; at > stage; --at) {
      const std::optional<RunRef> input = history_.find(chain_.nodes[at - 1], chain_.taken[at][index]);
      if (!input) return false;
      index = input->index;
    }
    if (stage == 0) {
      return history_.run({chain_.nodes[0], index}).number > history_.run({chain_.nodes[0], before->runs[0]}).number;
    }
    return chain_.taken[stage][index] >= history_.run({chain_.nodes[stage - 1], way.runs[stage - 1]}).number;
  };
  std::optional<LeftOut> last;
  for (std::size_t at = stage; at < chain_.nodes.size(); ++at) {
    const NodeId node = chain_.nodes[at];
    if (at > stage && stage > 0 && (!subchain || graph.node(node).subchain != subchain)) break;
    std::optional<RunRef> ended = history_.last_ended(node, by, false);
    for (; ended && history_.run(*ended).end > std::max(floor_, last ? last->end : floor_); --ended->index) {
      if (!history_.run(*ended).emitted && brings_news(at, ended->index)) {
        last = {history_.run(*ended).end, node};
        break;
      }
      if (ended->index == 0) break;
    }
  }
  return last;
}

// From the run's begin back to the floor: why it began just then.
void Walk::explain_begin(RunRef ref, bool of_source) {
  const graph::Graph& graph = history_.app().graph;
  for (int step = 0; step < kMaxSteps && !arrived(); ++step, of_source = false) {
    const graph::Node& node = graph.node(ref.node);
    const bool head = node.subchain && graph.subchain(*node.subchain).head() == ref.node;
    std::optional<RunRef> next;
    if (head) {
      const SentTrigger* trigger = history_.last_sent(*node.subchain, history_.run(ref).begin);
      if (trigger == nullptr) break;
      ready(ref, trigger->sent);
      if (trigger->due < trigger->sent) {
        const std::optional<TimePoint> busy = history_.last_end(*node.subchain, trigger->due, trigger->sent);
        if (history_.took_turns(*node.subchain, trigger->sent)) {
          emit(delays_in(history_, ref, {std::max(busy.value_or(trigger->due), floor_), cursor_}), ref.node);
        }
        const TimePoint since = busy.value_or(trigger->due);
        if (const auto changed = history_.plan_changed(since, cursor_)) {
          emit(*changed, PartKind::kPlanChange, ref.node);
        }
        emit(std::max(since, held_apart_until(*node.subchain, *trigger)), PartKind::kLateTrigger, ref.node);
        emit(since, PartKind::kWaitingForTrigger, ref.node);
        emit(trigger->due, PartKind::kOwnPreviousRun, ref.node);
      }
      if (arrived()) return;
      next = before_due(*node.subchain);
    } else if (node.unscheduled && !node.follows) {
      return by_timer(ref, of_source);
    } else {
      next = triggered_by(ref);
      if (!next) break;
      ready(ref, history_.run(*next).end);
      in_run(*next);
    }
    if (!next) return;
    ref = *next;
  }
  emit(floor_, PartKind::kUnexplained, ref.node);
}

// A trigger by a leader's output is due with that output, but not sooner than a period after the trigger before.
TimePoint Walk::held_apart_until(SubchainId subchain, const SentTrigger& trigger) const {
  const plan::Plan* const plan = history_.plan_at(trigger.sent);
  const bool planned = plan != nullptr && !plan->subchains[subchain.index()].cores.empty();
  const plan::Member* const member = planned ? plan::member_of(*plan, subchain) : nullptr;
  const SentTrigger* const earlier = history_.last_sent(subchain, trigger.sent - Nanos{1});
  if (member == nullptr || !member->after || earlier == nullptr) return trigger.due;
  return std::min(earlier->sent + to_nanos(member->period), trigger.sent);
}

// The run whose output triggered this one. Its node is no head and has no timer.
std::optional<RunRef> Walk::triggered_by(const RunRef& ref) const {
  const graph::Graph& graph = history_.app().graph;
  const graph::Node& node = graph.node(ref.node);
  const TimePoint begin = history_.run(ref).begin;
  if (node.follows) return history_.last_ended(*node.follows, begin, true);
  if (!node.subchain) return std::nullopt;
  const std::vector<NodeId>& nodes = graph.subchain(*node.subchain).nodes;
  const auto place = std::find(nodes.begin(), nodes.end(), ref.node);
  return history_.last_ended(*(place - 1), begin, true);
}

// Goes back from when a trigger was due. Returns the run that made it due, whose begin is to be explained next, if any.
std::optional<RunRef> Walk::before_due(SubchainId subchain) {
  const graph::Graph& graph = history_.app().graph;
  const NodeId head = graph.subchain(subchain).head();
  // A plan that came into force since the trigger before decides what is waited for, even if that trigger's run was
  // still under way.
  const SentTrigger* const earlier = history_.last_sent(subchain, cursor_ - Nanos{1});
  const TimePoint since_earlier = earlier != nullptr ? std::min(earlier->sent - Nanos{1}, floor_) : floor_;
  if (const auto changed = history_.plan_changed(since_earlier, cursor_)) emit(*changed, PartKind::kPlanChange, head);
  const plan::Plan* const plan = arrived() ? nullptr : history_.plan_at(cursor_ - Nanos{1});
  const bool planned = plan != nullptr && !plan->subchains[subchain.index()].cores.empty();
  const plan::SubchainPlan* const placed = planned ? &plan->subchains[subchain.index()] : nullptr;
  const plan::Member* const member = planned ? plan::member_of(*plan, subchain) : nullptr;
  if (member != nullptr && member->after) {
    const NodeId leader =
        member->after->node() != nullptr ? *member->after->node() : graph.subchain(*member->after->subchain()).tail();
    const std::optional<RunRef> output = history_.last_ended(leader, cursor_, true);
    if (output) {
      emit(history_.run(*output).end, PartKind::kWaitingForTrigger, head);
      in_run(*output);
      return output;
    }
  }
  const bool turns = planned && history_.took_turns(subchain, cursor_ - Nanos{1});
  const bool alone = placed != nullptr && member == nullptr && placed->cores.size() == 1 && !turns &&
                     !plan::has_fixed_frames(history_.app(), plan->cores, *placed);
  if (turns || alone || (member != nullptr && member->pause)) {
    // The trigger is due a while after the end of the subchain's own run.
    const std::optional<TimePoint> ended = history_.last_end(subchain, floor_, cursor_);
    const TimePoint since = std::max(ended.value_or(floor_), floor_);
    const std::optional<RunRef> run = ended ? history_.last_ended(head, *ended, false) : std::nullopt;
    if (turns) {
      std::vector<Delay> others = delays_in(history_, run.value_or(RunRef{head, 0}), {since, cursor_});
      for (Delay& each : others) {
        if (each.kind != PartKind::kStolen)
          each.kind = PartKind::kWaitingForSlot;  // in its own slot it had nothing to do
      }
      emit(others, head);
    }
    emit(since, PartKind::kWaitingForTrigger, head);
    if (run) emit(history_.run(*run).begin, PartKind::kOwnPreviousRun, head);
    return run;
  }
  emit(floor_, PartKind::kWaitingForTrigger, head);
  return std::nullopt;
}

void Walk::by_timer(const RunRef& ref, bool of_source) {
  const RunTimes& run = history_.run(ref);
  const std::optional<Ticks> ticks = history_.ticks(ref.node, run.begin);
  const TimePoint due = ticks ? ticks->last(run.begin) : run.begin;
  ready(ref, due, PartKind::kLateTimer);
  emit(floor_, of_source ? PartKind::kWaitingForSample : PartKind::kWaitingForTrigger, ref.node);
}

// From `since` on the run could have begun, but had not yet. `otherwise`: the kind of time in which no run of the app
// had the core.
void Walk::ready(const RunRef& ref, TimePoint since, PartKind otherwise) {
  since = std::max(since, floor_);
  if (since >= cursor_) return;
  TimePoint free = since;
  if (ref.index > 0) free = std::clamp(history_.run({ref.node, ref.index - 1}).end, since, cursor_);
  std::vector<Delay> delays = delays_in(history_, ref, {free, cursor_});
  for (Delay& each : delays) {
    if (each.kind == PartKind::kKernel) each.kind = otherwise;
  }
  emit(delays, ref.node);
  emit(since, PartKind::kOwnPreviousRun, ref.node);
}

}  // namespace ctn::why
