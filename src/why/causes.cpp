#include "why/causes.h"

#include <algorithm>

namespace ctn::why {
namespace {

bool is_by_another(PartKind kind) { return kind == PartKind::kPreEmpted || kind == PartKind::kStolen; }

// What a subchain loses of its slots, or needs in addition, may make it wait up to this many times as long for the next
// ones.
constexpr int kSlotsPerLoss = 10;

bool waits_for_trigger(PartKind kind) {
  return kind == PartKind::kWaitingForTrigger || kind == PartKind::kLateTrigger || kind == PartKind::kPlanChange ||
         kind == PartKind::kOwnPreviousRun;
}

CauseKind cause_by(PartKind kind) {
  switch (kind) {
    case PartKind::kWaitingForSample:
      return CauseKind::kWaitedForSample;
    case PartKind::kRunning:  // no run took longer than usual, so there were more runs on the way
    case PartKind::kWaitingForTrigger:
      return CauseKind::kWaitedForTrigger;
    case PartKind::kLateTrigger:
      return CauseKind::kLateTrigger;
    case PartKind::kLateTimer:
      return CauseKind::kLateTimer;
    case PartKind::kOwnPreviousRun:
      return CauseKind::kOwnPreviousRun;
    case PartKind::kPlanChange:
      return CauseKind::kPlanChange;
    case PartKind::kNoOutput:
      return CauseKind::kNoOutput;
    case PartKind::kWaitingForSlot:
      return CauseKind::kWaitedForSlot;
    case PartKind::kStolen:
      return CauseKind::kStolen;
    case PartKind::kPreEmpted:
      return CauseKind::kPreEmpted;
    case PartKind::kKernel:
      return CauseKind::kStarved;
    case PartKind::kRunningLonger:
      return CauseKind::kLongRun;
    case PartKind::kDevice:
      return CauseKind::kDevice;
    case PartKind::kWaitingForTick:
      return CauseKind::kWaitedForTick;
    case PartKind::kUnexplained:
      break;
  }
  return CauseKind::kUnexplained;
}

// Of the runs that ended in a stretch of own-previous-run, the one that computed longer than usual by most.
Causes::Excess longest_excess(const Part& part, const History& history) {
  Causes::Excess longest{part.node, part.node, Nanos{0}};
  const graph::Graph& graph = history.app().graph;
  const std::optional<SubchainId> subchain = graph.node(part.node).subchain;
  const std::vector<NodeId> itself{part.node};
  for (const NodeId node : subchain ? graph.subchain(*subchain).nodes : itself) {
    for (std::optional<RunRef> run = history.last_ended(node, part.end, false);
         run && history.run(*run).end > part.begin; --run->index) {
      const Nanos excess = history.run(*run).cpu - history.usual_cpu(node);
      if (excess > longest.length) longest = {part.node, node, excess};
      if (run->index == 0) break;
    }
  }
  return longest;
}

}  // namespace

Causes::Evidence Causes::evidence_of(std::span<const Part> parts) {
  std::map<Key, Sum> sums;
  std::map<Key, Nanos> longest;
  for (const Part& part : parts) {
    const Key key = whose(part);
    Sum& sum = sums[key];
    sum.length += part.length();
    if (!is_by_another(part.kind) || !part.by) continue;
    if (part.length() > longest[key]) {
      longest[key] = part.length();
      sum.held_up = part.node;
    }
    if (part.kind == PartKind::kStolen && !sum.robbed) sum.robbed = part.node;
  }
  Evidence evidence;
  if (!parts.empty()) evidence.first = parts.front().node;
  for (auto& [key, sum] : sums) {
    sum.key = key;
    evidence.sums.push_back(sum);
  }
  return evidence;
}

void Causes::find_excesses(std::span<const Part> parts, const History& history, Evidence& evidence) {
  for (const Part& part : parts) {
    if (part.kind != PartKind::kOwnPreviousRun) continue;
    const Excess excess = longest_excess(part, history);
    if (excess.length <= Nanos{0}) continue;
    std::erase_if(evidence.excesses,
                  [&](const Excess& one) { return one.waiting == excess.waiting && one.length <= excess.length; });
    evidence.excesses.push_back(excess);
  }
}

void Causes::add(const Evidence& response) {
  ++responses_;
  for (const Sum& sum : response.sums) lengths_[sum.key].add(sum.length);
}

std::vector<std::pair<Causes::Key, Nanos>> Causes::medians() {
  const std::size_t rank = (responses_ + 1) / 2;  // from 1
  for (auto& [key, lengths] : lengths_) {
    const std::size_t without = responses_ - lengths.size();
    if (rank <= without) continue;
    const Nanos median = lengths.of_rank(rank - without - 1);
    if (median > Nanos{0}) medians_[key] = median;
  }
  lengths_.clear();
  return {medians_.begin(), medians_.end()};
}

Cause Causes::cause_of(const Evidence& response, const graph::Graph& graph, bool usually_late) const {
  const auto length_of = [&](const Key& key) {
    const auto found =
        std::find_if(response.sums.begin(), response.sums.end(), [&](const Sum& sum) { return sum.key == key; });
    return found == response.sums.end() ? std::optional<Nanos>() : found->length;
  };
  const auto beyond = [&](const Key& key) {
    const auto usual = medians_.find(key);
    return length_of(key).value_or(Nanos{0}) - (usually_late || usual == medians_.end() ? Nanos{0} : usual->second);
  };
  const auto slots_beyond = [&](NodeId of) {
    Nanos sum{0};
    for (const Sum& each : response.sums) {
      if (each.key.first != PartKind::kWaitingForSlot) continue;
      const NodeId node = each.key.second;
      if (node == of || (graph.node(of).subchain && graph.node(node).subchain == graph.node(of).subchain)) {
        sum += std::max(beyond(each.key), Nanos{0});
      }
    }
    return sum;
  };
  Sum max{.key = {PartKind::kUnexplained, response.first}};
  Nanos exceeded{0};
  for (const Sum& sum : response.sums) {
    const auto& [kind, node] = sum.key;
    Nanos excess = beyond(sum.key);
    if (kind == PartKind::kPlanChange) {
      excess = Nanos{0};
      for (const PartKind wait :
           {PartKind::kWaitingForTrigger, PartKind::kLateTrigger, PartKind::kPlanChange, PartKind::kOwnPreviousRun}) {
        excess += beyond({wait, node});
      }
    } else if (waits_for_trigger(kind) && length_of({PartKind::kPlanChange, node})) {
      continue;
    } else if (kind == PartKind::kStolen || kind == PartKind::kRunningLonger) {
      const Nanos slots = slots_beyond(kind == PartKind::kStolen ? sum.robbed.value_or(node) : node);
      if (kSlotsPerLoss * excess >= slots) excess += slots;
    }
    if (excess > exceeded) {
      exceeded = excess;
      max = sum;
    }
  }
  const auto& [kind, node] = max.key;
  Cause cause{cause_by(kind), node, {}, exceeded};
  if (usually_late && kind == PartKind::kRunning) cause.kind = CauseKind::kLongRun;
  if (max.held_up) {
    cause.node = *max.held_up;
    cause.by = node;
  }
  if (kind != PartKind::kOwnPreviousRun) return cause;
  for (const Excess& excess : response.excesses) {
    if (excess.waiting != node || 2 * excess.length < exceeded) continue;
    cause.kind = CauseKind::kLongRun;
    cause.node = excess.node;
  }
  return cause;
}

}  // namespace ctn::why
